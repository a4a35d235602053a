"""What artists and engineers expect of such an editor, and where each is here: the rows of docs/features.md.

A row names operations, panels, commands and gestures; a test looks each of them up, so that none can vanish unnoticed.
`missing` says what is not there."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Feature:
    """`first`: belongs to the first release's floor. `motions`: of navigation.MOTIONS. `more`: what else there is to
    know; `missing`: what is not there yet."""

    name: str
    operations: tuple[str, ...] = ()
    panels: tuple[str, ...] = ()
    commands: tuple[str, ...] = ()
    motions: tuple[str, ...] = ()
    more: str = ""
    missing: str = ""
    first: bool = False


def _f(
    name: str, operations: str = "", panels: str = "", commands: str = "", motions: str = "", **more: str
) -> Feature:
    return Feature(
        name, tuple(operations.split()), tuple(p for p in panels.split(", ") if p), tuple(commands.split()),
        tuple(motions.split()), more.get("more", ""), more.get("missing", ""), bool(more.get("first")),
    )  # fmt: skip


FEATURES = (
    _f("Import a dropped folder or file, with a card and a report", "file.open file.open-path "
       "file.import-card import.scale-down import.z-up import.flip-green", "Assets, Log",
       "convert check inspect", first="1", more="drop a file or a folder on the window"),
    _f("The command line does what the window does", "file.copy-command file.copy-script", "Console",
       "run render convert export", first="1"),
    _f("View strip: exposure, tone map, environment", "look.scene look.blender look.khronos look.aces "
       "look.raw view.reset-settings view.set", "Viewport, Render settings",
       "render", first="1", more="always above the picture"),
    _f("HDR environments, turned by a drag", "edit.set", "Viewport, Inspector", "render", "environment", first="1"),
    _f("Debug views on number keys",
       "view.show-lit view.show-base-color view.show-normal view.show-roughness view.show-metallic "
       "view.show-occlusion view.show-emission view.show-lighting view.show-depth view.show-overdraw "
       "view.show-wireframe view.show-texel-density view.show-uv-checker", "Viewport", "render", first="1"),
    _f("Shaders and materials reload, errors at their line, the last good picture stays",
       "shader.reload shader.next-error shader.previous-error shader.draw-anyway shader.save",
       "Shader editor, Log", "check", first="1", more="files edited elsewhere are noticed"),
    _f("Widgets from annotations of parameters", "material.reset view.set", "Inspector, Render settings",
       "render inspect", first="1"),
    _f("Timeline, key stepping, in and out points",
       "play.toggle play.previous play.next play.next-key play.previous-key play.set-in play.set-out play.mode "
       "play.start play.seek animation.timeline animation.new", "Timeline", "render play", first="1"),
    _f("Blend spaces in one and two dimensions", "view.panel-blend-space", "Blend space", first="1"),
    _f("Bone masks with weights", "view.panel-masks", "Masks", first="1"),
    _f("Times of each pass, with what is not accounted for", "view.show-stats", "Timings", "render report", first="1"),
    _f("Every edit on disk at once; restored after a crash", "file.save", "History", first="1",
       more="asked for at the next start"),
    _f("Undo: one entry a gesture", "edit.undo edit.redo edit.history", "History", "run", first="1"),
    _f("Three keymaps, and an editor for them",
       "help.keymap-industry help.keymap-blender help.keymap-viewer help.preferences", "Preferences", first="1"),
    _f("Command palette", "help.palette", first="1"),
    _f("Interface scale from 75 to 300 %", "view.scale-up view.scale-down view.scale-reset", "Preferences", "edit",
       first="1"),
    _f("Draws nothing while nothing changes", "view.show-stats view.background-slow view.fps-limit", "Timings",
       first="1"),
    _f("Packages: folder build and wheel", commands="doctor", first="1", missing="signing of the packages"),
    _f("Navigation with three buttons, a pen or a trackpad", "view.frame view.frame-all view.reset-camera "
       "view.front view.right view.top view.orthographic view.look view.fly help.pointer-trackpad help.reverse-scroll",
       "Viewport, Preferences", "render play",
       "orbit pan dolly fly"),
    _f("Gizmos, local and world", "tool.move tool.rotate tool.scale tool.local edit.move-by edit.turn-by edit.scale-by",
       "Viewport", "run"),
    _f("Snapping", "tool.move tool.rotate tool.scale edit.drop", "Viewport", more="hold Ctrl, hold Shift for surfaces"),
    _f("Selecting: click, box, through what lies in front", "select.nodes select.matching edit.select-all "
       "edit.select-children edit.select-parent edit.deselect", "Scene, Viewport", "run", "select"),
    _f("Scene tree, hanging elsewhere by a drag", "edit.reparent edit.unparent edit.group edit.rename", "Scene", "run"),
    _f("A picture of each edit", "view.history-pictures edit.history", "History"),
    _f("Search and filters", "help.palette", "Scene, Assets, Log"),
    _f("Editing many at once", "edit.set", "Inspector", "run"),
    _f("Thumbnails of assets", "", "Assets"),
    _f("Material edits survive a new import", "file.reimport file.reimport-on-change material.only_object",
       "Assets, Inspector", "convert"),
    _f("Material editor with a preview", "material.preview material.copy material.paste shader.effect shader.material",
       "Inspector, Material preview, BRDF explorer", "inspect"),
    _f("Variants of shaders, and what their features change", "shader.variants view.measure-features", "Variants",
       "inspect"),
    _f("State graph, cross-fades, layers", "animation.states view.panel-state-graph", "State graph"),
    _f("Root motion", "animation.root-motion animation.show-root-path", "Timeline"),
    _f("Markers and events", "animation.add-marker", "Timeline"),
    _f("Skeletons in the picture", "animation.show-skeleton animation.show-names animation.show-axes animation.ghosts",
       "Viewport"),
    _f("Render paths, switched and compared",
       "compare.path-forward compare.path-deferred compare.path-tiled-deferred compare.path-forward-plus",
       "Compare, Render settings", "render report"),
    _f("Wipe and hold to compare", "compare.take compare.hold compare.wipe compare.flip compare.difference "
       "compare.measure", "Compare"),
    _f("Frame graph, and what is left out and why", "view.panel-frame-graph view.measure-left-out", "Frame graph",
       "render"),
    _f("Textures and targets, channels, pixels, NaN", "view.panel-textures texture.show texture.show-target "
       "view.check-numbers view.mark-numbers",
       "Textures, Numbers", "inspect"),
    _f("Error against run time", "view.report report.run report.apply report.write", "Report", "report"),
    _f("Screenshots, turntables", "file.screenshot view.turntable file.save-turntable", "Viewport", "render"),
    _f("Measuring", "tool.measure", "Viewport"),
    _f("Camera bookmarks", "view.set-bookmark-1 view.bookmark-1", "Viewport"),
    _f("Hide, isolate, lock", "edit.hide edit.show-all edit.isolate edit.lock edit.unlock-all", "Scene"),
    _f("Lights: add, scatter, lay out", "add.point-light add.spot-light add.directional-light add.rectangle-light "
       "add.disk-light add.scatter-lights add.array view.show-lights", "Lights, Inspector", "lights"),
    _f("Projects and loose files", "file.open file.save file.save-as", "Assets", "new edit"),
    _f("Several documents", "document.next document.previous document.close-others"),
    _f("Scripts and plug-ins", "file.copy-script help.plugins help.reload-plugins", "Console, Plug-ins", "run"),
    _f("Asset report: sizes, memory, materials, warnings", "view.panel-asset-report", "Asset report, Log",
       "inspect check"),
    _f("Checks of assets", "", "Log", "check inspect"),
    _f("Layouts: workspaces, own ones, reset", "layout.edit layout.animate layout.shade layout.review layout.save-1 "
       "layout.load-1 view.reset-layout"),
    _f("Prefabs and instances", "prefab.make prefab.choose prefab.place prefab.apply prefab.revert prefab.open "
       "prefab.revert-value prefab.apply-value", "Scene, Inspector, Timeline", more="their clips play"),
    _f("Moving files of a project, references follow", "file.move file.rename-asset", "Assets"),
    _f("Grey, chrome and colour chart in the picture", "view.look-card", "Viewport"),
    _f("A floor that only shadows are seen of", "view.shadow-floor", "Viewport", "render"),
    _f("Themes", "view.theme-dark view.theme-high-contrast", "Preferences"),
    _f("Curves of clips", "", "Timeline", missing="handles and tangents that can be dragged: curves are shown only"),
    _f("Pictures of assets in the system's file manager", missing="no thumbnailers for file managers yet"),
    _f("Screen readers", "", "", "check render run", more="the command line is the accessible way",
       missing="the interface says nothing to screen readers"),
    _f("Display in high dynamic range", missing="the picture goes out with 8 bits a channel"),
    _f("The viewport on macOS", commands="convert check", missing="OpenGL ends at 4.1 there: no pictures"),
    _f("English and Chinese", "help.language-en help.language-zh", "Preferences"),
    _f("Keys, hints and help", "help.keys help.welcome file.open-sample"),
)  # fmt: skip
