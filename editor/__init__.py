"""The desktop editor: a window of panels around one runtime. May import engine, importers, imgui_bundle; no GL library.

    command.py            `lucarna edit`: arguments -> app
    app.py                hello_imgui window: device, fonts, layout, frame loop        (imgui)
      '-- idling.py       how long it sleeps: no frames while nothing happens; woken by waking.py (threads, jobs),
                          file_watch.py (files), interrupts.py (Ctrl+C); window_state.py: whether anybody looks
    panels/ *.py          one panel a file, listed in panels.registry                  (imgui)
    dialogs/ *.py         open, save, progress, unsaved changes, palette, cards         (imgui)
    menus, keys, widgets, flowing, param_widgets, theme, layout, layout_slots           (imgui)
    compare_overlay       an earlier state beside the present one, a line that wipes    (imgui)
    overlay, markers, axis_widget, gizmo_widget      drawn over the picture             (imgui)
    light_outlines        what lights are and how far they reach, drawn over the picture   (imgui)
    legend_overlay        what a debug view's colours mean, drawn over the picture         (imgui)
      |  read the session, call operations, propose edits
      v
    session.py            what the window works on: document, camera, settings, log    (no imgui, no GL)
      |                   its fields: session_state.py; looking.py: settings, camera, picking; requests.py: for dialogs
      |-- tabs.py         several documents open at once: what each of those behind keeps; dropping.py: dropped files
      |-- operations.py   named user operations with arguments: menu, palette, keys, console and scripts are their doors
      |     |-- keymap.py   presets and the user's keys over them; physical_keys: letters by their place
      |     |-- scripting, script_names, script_run    what was done as lines; `lucarna run`, the console
      |     '-- features, documentation                docs/features.md and docs/operations.md, made from the registries
      |-- strings/        words in other languages than English; fonts.py: glyphs for them
      |-- plugins/        operations, panels, importers, passes, effects from outside, each switched off when it fails
      |-- tasks, live_hints       what goes on in the background; what the mouse does now
      |-- document.py     what is open; every edit is a Command on a table column
      |     |-- commands/ Command, StructureCommand + History: undo, redo, one entry per gesture
      |     '-- journal.py    every edit on disk as it happens; recovering.py restores what a killed session left;
      |                       recovered_numbers.py: which files its numbers of meshes and materials mean
      |-- replacing.py    another scene under a document as one entry (commands/replacement.py), for
      |     |-- reimporting.py     sources that changed, by importers.reimport; import_settings.py: one-click fixes
      |     |-- file_moves.py      files of the project moved by importers.project; asset_links.py: who uses which
      |     '-- prefabs.py         made, placed; prefab_updates.py: reverted, applied, followed when their files change;
      |                            prefab_values.py: what an instance has of its own, value by value
      |-- tools, gizmo, selecting, focusing      move/turn/scale arithmetic, box selection, isolating, measuring, focus
      |-- code/           shader files as text: documents, problems, search, completion
      |-- material_editing, param_groups    materials, one or many: shared parameters, copies, resets, textures
      |-- comparing/      any earlier state, or another render path, beside the present one: pictures and numbers
      |-- looks, surroundings, look_card, turntable    look-dev: curves, light, grey and chrome balls
      |-- bookmarks.py    camera bookmarks, a table of the document (bookmark_table.py)
      |-- texture_sources, picture_files, texture_view    what the texture viewer reads, and how its numbers are shown
      |-- asset_report.py    meshes, textures, materials, memory, findings; log_links: where a message leads
      |-- baking.py       surroundings that a thread bakes: the picture keeps those of before until then
      |-- preview.py      a material on a shape, by engine.app.material_stage; its set-up is remembered
      |-- asset_thumbnails.py    pictures of asset files, made by thumbnail_maker.py in a worker process
      |-- animating/     edits of an animation file, clock and log that follow it
      |-- watch.py        edited shaders and materials on disk -> the runtime, and what is wrong with them
      |-- opening.py      path -> scene file, in a worker thread, cancellable
      |-- work.py         what takes long, a step a frame: measuring what is left out, experiments
      |     '-- report.py, work_precision.py    error over time on the open view: answers, what to set, the diagram
      |-- numbers.py      which pass made the first NaN, and going there
      '-- viewport_image.py   renders only when something visible changed; history_pictures.py keeps it small
      v
    host.py               the engine's side: runtime, view, scene_for (tests put a fake one here)

An edit goes: widget -> session.edit(table, column, rows, values, gesture) -> History -> tables.py -> engine tables ->
revision -> viewport_image renders once -> the picture. Nothing else writes to a scene.
"""
