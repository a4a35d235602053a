"""The operations that come with the editor, menu by menu."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from editor import camera_controls, numbers, report, work
from editor.animating.operations import add_animation_operations
from editor.comparing.operations import add_compare_operations
from editor.direct_operations import add_direct_operations
from editor.document_operations import add_document_operations
from editor.editing_operations import add_editing_operations
from editor.habit_operations import add_habit_operations
from editor.history_operations import add_history_operations
from editor.import_operations import add_import_operations
from editor.layout_operations import add_layout_operations
from editor.looks import add_look_operations
from editor.material_operations import add_material_operations
from editor.navigation import PRESETS
from editor.operations import Operation, Operations, always
from editor.prefab_operations import add_prefab_operations
from editor.session import Session
from editor.shadow_floor import add_shadow_floor_operations
from editor.strings import LANGUAGES
from editor.surroundings import add_surroundings_operations
from editor.texture_operations import add_texture_operations
from editor.turntable import add_turntable_operations
from editor.welcome import add_welcome_operations
from engine.render.settings import DEBUG_VIEWS, VIEW_LEGENDS

#: the debug views in the order of their keys: 1 to 9, then the same with Shift
DEBUG_KEYS = (
    *DEBUG_VIEWS[:9], "lighting", "depth", "overdraw", "wireframe", "texel_density", "uv_checker", *DEBUG_VIEWS[9:13],
)  # fmt: skip


def _has_document(session: Session) -> bool:
    return session.document is not None


def _has_selection(session: Session) -> bool:
    return session.document is not None and bool(session.document.selection)


def _measure_left_out(session: Session) -> None:
    if work.start(session, work.MeasureLeftOut()):
        session.ui.focus_panel = "Frame graph"


def _measure_features(session: Session) -> None:
    from editor.code.feature_work import MeasureFeatures

    if work.start(session, MeasureFeatures()):
        session.ui.focus_panel = "Variants"


def _run_report(session: Session) -> None:
    session.ui.focus_panel = "Report"
    report.start(session, report.OWN)


def _has_reports(session: Session) -> bool:
    return bool(session.reports)


def _has_advice(session: Session) -> bool:
    return report.OWN in session.reports


def _is_working(session: Session) -> bool:
    return session.work is not None


def _checks_numbers(session: Session) -> bool:
    return session.document is not None and numbers.offered(session)


def _marks_numbers(session: Session) -> bool:
    return session.settings.values().get("view") == numbers.VIEW


def _can_undo(session: Session) -> bool:
    return session.document is not None and bool(session.document.history.undo_label)


def _can_redo(session: Session) -> bool:
    return session.document is not None and bool(session.document.history.redo_label)


def _can_play(session: Session) -> bool:
    return session.playback.available


def _ask(name: str) -> Callable[[Session], None]:
    def run(session: Session) -> None:
        setattr(session.ui, name, True)

    return run


def _toggle_preference(name: str) -> tuple[Callable[[Session], None], Callable[[Session], bool]]:
    def run(session: Session) -> None:
        setattr(session.preferences, name, not getattr(session.preferences, name))
        session.remember()

    def checked(session: Session) -> bool:
        return bool(getattr(session.preferences, name))

    return run, checked


def _view(side: str) -> Callable[[Session], None]:
    def run(session: Session) -> None:
        session.camera = camera_controls.along(session.camera, side)

    return run


def _debug_view(
    name: str,
) -> tuple[Callable[[Session], None], Callable[[Session], bool], Callable[[Session], bool]]:
    """(run, enabled, checked) of showing one input of the shading instead of the lit picture."""

    def run(session: Session) -> None:
        session.settings.view = name

    def enabled(session: Session) -> bool:
        known = {p.name: p for p in session.settings.PARAMS}
        return session.document is not None and "view" in known and name in known["view"].choices

    def checked(session: Session) -> bool:
        return session.document is not None and getattr(session.settings, "view", "") == name

    return run, enabled, checked


def _keymap(preset: str) -> tuple[Callable[[Session], None], Callable[[Session], bool]]:
    def run(session: Session) -> None:
        session.preferences.keymap = preset
        session.remember()

    def checked(session: Session) -> bool:
        return session.preferences.keymap == preset

    return run, checked


def _language(code: str) -> tuple[Callable[[Session], None], Callable[[Session], bool]]:
    def run(session: Session) -> None:
        session.preferences.language = code
        session.remember()

    return run, lambda session: session.preferences.language == code


def _scale(step: float) -> Callable[[Session], None]:
    def run(session: Session) -> None:
        scale = session.preferences.ui_scale + step if step else 1.0
        session.preferences.ui_scale = min(max(round(scale, 2), 0.75), 3.0)
        session.ui.scale_changed = True
        session.remember()

    return run


def close_document(session: Session) -> None:
    if session.document is not None and session.document.dirty:
        session.ask_discard(session.close)
    else:
        session.close()


def reload_document(session: Session) -> None:
    if session.document is not None:
        session.open(Path(session.document.source), again=True)


def hide_selection(session: Session) -> None:
    document = session.document
    if document is None or not document.selection:
        return
    visible = document.tables["nodes"].read("visible", document.selection)
    session.set_visible(document.selection, not any(visible))


def show_all(session: Session) -> None:
    document = session.document
    if document is None:
        return
    nodes = document.runtime.scene.nodes
    hidden = [row for row in range(len(nodes.name)) if nodes.alive[row] and not nodes.visible[row]]
    if hidden:
        session.set_visible(hidden, True)


def select_parent(session: Session) -> None:
    document = session.document
    if document is not None and document.primary >= 0:
        parent = int(document.runtime.scene.nodes.parent[document.primary])
        if parent >= 0:
            document.select(parent)


def quit_editor(session: Session) -> None:
    if session.request_quit():
        session.ui.quit = True


def _step(frames: int) -> Callable[[Session], None]:
    def run(session: Session) -> None:
        session.playback.step(frames)
        session.seek(session.playback.time)

    return run


def _toggle_loop(session: Session) -> None:
    session.playback.loop = not session.playback.loop


def _toggle_orthographic(session: Session) -> None:
    session.camera = replace(session.camera, orthographic=not session.camera.orthographic)


def _is_orthographic(session: Session) -> bool:
    return session.camera.orthographic


def _save_as(session: Session) -> None:
    session.ui.save_dialog = True


def _screenshot(session: Session) -> None:
    from editor.screenshot import save_viewport

    save_viewport(session)


def _deselect(session: Session) -> None:
    if session.document is not None:
        session.document.select(-1)


def save(session: Session) -> None:
    """The text that has the keys, else the scene."""
    if session.code.focused:
        session.save_code()
    else:
        session.save()


def _can_save(session: Session) -> bool:
    return session.document is not None or session.code.focused


def _has_code(session: Session) -> bool:
    return session.code.front is not None


def _selected_material(session: Session) -> int:
    """The material of the selected node's first part, or -1."""
    document = session.document
    if document is None or document.primary < 0:
        return -1
    instances = document.runtime.scene.instances
    rows = [i for i, node in enumerate(instances.node) if int(node) == document.primary]
    return int(instances.material[rows[0]]) if rows else -1


def _has_material(session: Session) -> bool:
    return _selected_material(session) >= 0


def open_effect(session: Session) -> None:
    """Open the files of the selected material's effect; the fragment shader is in front."""
    material = _selected_material(session)
    if material < 0 or session.document is None:
        return
    from engine.materials.variant import shader_file

    residency = session.document.runtime.residency
    effect = residency.material(material).effect
    if not effect.files:
        session.ui.notice = "This effect has no file"
        return
    session.open_code(effect.files[0])
    technique = effect.techniques.get("forward") or next(iter(effect.techniques.values()), None)
    if technique is not None:
        session.open_code(shader_file(technique.fragment or technique.vertex, residency.effects.search))


def open_material(session: Session) -> None:
    material = _selected_material(session)
    if material >= 0 and session.document is not None:
        path = session.document.runtime.residency.material(material).path
        if path:
            session.open_code(Path(path))
        else:
            session.ui.notice = "This material has no file"


def find_in_text(session: Session) -> None:
    session.code.find = True
    session.ui.focus_panel = "Shader editor"


def _reload_shaders(session: Session) -> None:
    session.shaders.reload(session, force=True)


def _show_panel(title: str) -> Callable[[Session], None]:
    def run(session: Session) -> None:
        session.ui.focus_panel = title

    return run


def builtin_operations() -> Operations:
    """A registry with everything below."""
    ops = Operations()
    doc, sel = _has_document, _has_selection

    def add(
        id: str,
        label: str,
        run: Callable[[Session], None],
        *keys: str,
        menu: str = "",
        enabled: Callable[[Session], bool] = always,
        checked: Callable[[Session], bool] | None = None,
        separator: bool = False,
        about: str = "",
    ) -> None:
        ops.add(Operation(id, label, run, menu, keys, enabled, checked, separator, about))

    add("file.open", "Open…", _ask("open_dialog"), "Ctrl+O", menu="File", about="A project, folder, scene or model")
    add("file.reload", "Reload", reload_document, "Ctrl+R", menu="File", enabled=doc)
    add("file.close", "Close", close_document, "Ctrl+W", menu="File", enabled=doc)
    add("file.save", "Save", save, "Ctrl+S", menu="File", enabled=_can_save, separator=True)
    add("file.save-as", "Save as…", _save_as, "Ctrl+Shift+S", menu="File", enabled=doc)
    add("file.screenshot", "Save viewport picture", _screenshot, "F12", menu="File", enabled=doc, separator=True)
    add("file.quit", "Quit", quit_editor, "Ctrl+Q", menu="File", separator=True)

    add("edit.undo", "Undo", Session.undo, "Ctrl+Z", menu="Edit", enabled=_can_undo)
    add("edit.redo", "Redo", Session.redo, "Ctrl+Y", "Ctrl+Shift+Z", menu="Edit", enabled=_can_redo)
    add("edit.hide", "Hide or show selection", hide_selection, "H", menu="Edit", enabled=sel, separator=True)
    add("edit.show-all", "Show all", show_all, "Alt+H", menu="Edit", enabled=doc)
    add("edit.select-parent", "Select parent", select_parent, "P", menu="Edit", enabled=sel, separator=True)
    add("edit.deselect", "Select nothing", _deselect, "Escape", menu="Edit", enabled=sel)

    add("view.frame", "Frame selection", Session.frame_selection, "F", menu="View", enabled=doc)
    add("view.frame-all", "Frame all", Session.frame_all, "A", "Home", menu="View", enabled=doc)
    add("view.reset-camera", "Reset camera", Session.reset_camera, "Keypad0", menu="View", enabled=doc)
    sides = {"front": "Keypad1", "right": "Keypad3", "top": "Keypad7"}
    opposite = {"back": "Ctrl+Keypad1", "left": "Ctrl+Keypad3", "bottom": "Ctrl+Keypad7"}
    for i, (side, key) in enumerate({**sides, **opposite}.items()):
        add(f"view.{side}", f"View from the {side}", _view(side), key, menu="View", enabled=doc, separator=i == 0)
    add("view.orthographic", "Orthographic", _toggle_orthographic, "Keypad5", menu="View", enabled=doc,
        checked=_is_orthographic)  # fmt: skip
    for name, label in (
        ("show_axes", "Axes"), ("show_stats", "Statistics"), ("show_outline", "Selection outline"),
        ("prepare_views", "Prepare other views while idle"),
        ("show_lights", "Reach of all lights"), ("show_look_card", "Look card"),
    ):  # fmt: skip
        run, checked = _toggle_preference(name)
        id = "view.look-card" if name == "show_look_card" else f"view.{name.replace('_', '-')}"
        add(id, label, run, menu="View", checked=checked, separator=name == "show_axes")
    add("view.scale-up", "Larger interface", _scale(0.1), "Ctrl+=", menu="View", separator=True)
    add("view.scale-down", "Smaller interface", _scale(-0.1), "Ctrl+-", menu="View")
    add("view.scale-reset", "Normal interface size", _scale(0.0), "Ctrl+0", menu="View")
    add("view.reset-settings", "Reset render settings", Session.reset_settings, menu="View", enabled=doc)

    keys = [*map(str, range(1, 10)), *(f"Shift+{k}" for k in range(1, 10)), "Shift+0"]
    for i, name in enumerate(DEBUG_KEYS):
        run, enabled, checked = _debug_view(name)
        label = f"Show {name.replace('_', ' ')}"
        id = f"view.show-{name.replace('_', '-')}"
        add(id, label, run, keys[i], menu="View", enabled=enabled, checked=checked, separator=i == 0,
            about=VIEW_LEGENDS.get(name, ""))  # fmt: skip
    for name in [name for name in DEBUG_VIEWS if name not in DEBUG_KEYS]:  # there are no more keys of their kind
        run, enabled, checked = _debug_view(name)
        add(f"view.show-{name.replace('_', '-')}", f"Show {name.replace('_', ' ')}", run, menu="View",
            enabled=enabled, checked=checked, about=VIEW_LEGENDS.get(name, ""))  # fmt: skip

    add("view.check-numbers", "Check numbers", numbers.toggle, menu="View", enabled=_checks_numbers,
        checked=numbers.checking, separator=True, about="Look for NaN and infinities in every pass")  # fmt: skip
    add("view.mark-numbers", "Mark NaN and infinities", numbers.toggle_marks, "0", menu="View",
        enabled=_checks_numbers, checked=_marks_numbers,
        about="The picture dimmed: magenta NaN, yellow infinite, cyan negative, orange too bright")  # fmt: skip
    add("view.numbers", "Numbers of the passes", _show_panel("Numbers"), menu="View")

    add("view.measure-left-out", "Measure what is left out", _measure_left_out, menu="View", enabled=doc,
        about="Time the frame with all passes forced")  # fmt: skip
    add("view.measure-features", "Measure what features change", _measure_features, menu="View", enabled=doc,
        about="Which features of the scene's shader variants never change a pixel")  # fmt: skip
    add("view.report", "Report: error against run time", _show_panel("Report"), menu="View",
        about="Measure what the settings of this view cost and what they buy")  # fmt: skip
    add("report.run", "Run the report on this view", _run_report, enabled=doc,
        about="What each setting of this view costs and buys")  # fmt: skip
    add("report.apply", "Apply what the report advises", report.apply_advice, enabled=_has_advice,
        about="The settings that would be gained by; undo takes them back")  # fmt: skip
    add("report.write", "Write the report", report.write, enabled=_has_reports,
        about="The results at hand as report.html and report.json")  # fmt: skip
    add("view.cancel-work", "Cancel what is being measured", work.cancel, enabled=_is_working)

    add("play.toggle", "Play or pause", lambda s: s.playback.toggle(), "Space", menu="Playback", enabled=_can_play)
    add("play.previous", "Previous frame", _step(-1), ",", menu="Playback", enabled=_can_play)
    add("play.next", "Next frame", _step(1), ".", menu="Playback", enabled=_can_play)
    add("play.start", "Go to start", lambda s: s.seek(0.0), menu="Playback", enabled=_can_play)
    add("play.loop", "Loop", _toggle_loop, menu="Playback", enabled=_can_play, checked=lambda s: s.playback.loop)

    add("shader.editor", "Shader editor", _show_panel("Shader editor"), menu="Shaders")
    add("shader.effect", "Open effect of the selected material", open_effect, menu="Shaders", enabled=_has_material,
        about="Its effect file and fragment shader, as text")  # fmt: skip
    add("shader.material", "Open file of the selected material", open_material, menu="Shaders", enabled=_has_material)
    add("shader.save", "Save text", lambda s: void(s.save_code()), menu="Shaders", enabled=_has_code, separator=True)
    add("shader.reload", "Reload shaders", _reload_shaders, "F5", menu="Shaders", enabled=doc,
        about="Compile all of them again; edited files are noticed without it")  # fmt: skip
    add("shader.draw-anyway", "Draw it anyway", lambda s: s.shaders.draw_anyway(s), menu="Shaders",
        enabled=lambda s: s.shaders.refused,
        about="Show new shaders that were sent back because they write NaN")  # fmt: skip
    add("shader.next-error", "Next error", lambda s: void(s.shaders.next_problem(s)), "F8", menu="Shaders", enabled=doc)
    add("shader.previous-error", "Previous error", lambda s: void(s.shaders.next_problem(s, -1)), "Shift+F8",
        menu="Shaders", enabled=doc)  # fmt: skip
    add("shader.find", "Find and replace in the text", find_in_text, menu="Shaders", enabled=_has_code,
        about="Ctrl+F in the text; Enter finds the next")  # fmt: skip
    add("shader.variants", "Variants", _show_panel("Variants"), menu="Shaders", separator=True)

    add("help.palette", "Command palette", _ask("palette"), "Ctrl+Shift+P", "F3", menu="Help")
    add("help.keys", "Keys and mouse", _ask("help"), "F1", menu="Help")
    add("help.welcome", "Welcome", _ask("welcome"), menu="Help")
    for preset in PRESETS:
        run, checked = _keymap(preset)
        first = preset == "industry"
        add(f"help.keymap-{preset}", f"Keymap: {preset}", run, menu="Help", checked=checked, separator=first)
    for code, name in LANGUAGES.items():
        run, checked = _language(code)
        add(f"help.language-{code}", f"Language: {name}", run, menu="Help", checked=checked, separator=code == "en")
    add("help.preferences", "Preferences…", _show_panel("Preferences"), "Ctrl+,", menu="Edit", separator=True,
        about="Keys, language, size of the interface")  # fmt: skip
    add("help.plugins", "Plug-ins…", _show_panel("Plug-ins"), menu="Help", separator=True,
        about="Which there are, and what went wrong with them")  # fmt: skip
    add("help.reload-plugins", "Load plug-ins again", _ask("reload_plugins"), menu="Help")
    add("help.about", "About Lucarna", _ask("about"), menu="Help", separator=True)
    add_material_operations(ops)
    add_editing_operations(ops)
    add_document_operations(ops)
    add_import_operations(ops)
    add_prefab_operations(ops)
    add_history_operations(ops)
    add_compare_operations(ops)
    add_layout_operations(ops)
    add_habit_operations(ops)
    add_texture_operations(ops)
    add_look_operations(ops)
    add_surroundings_operations(ops)
    add_turntable_operations(ops)
    add_shadow_floor_operations(ops)
    add_welcome_operations(ops)
    add_animation_operations(ops)
    add_direct_operations(ops)
    return ops


def void(_value: object) -> None:
    """Drop a result."""
