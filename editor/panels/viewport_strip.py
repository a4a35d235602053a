"""The bars above the picture. Tools, comparing and what the frame cost; below, always all of it: what lights the scene
and how it is turned, exposure, the curve to the display, debug view, render path."""

from __future__ import annotations

from typing import Any

from imgui_bundle import imgui

from editor import icons, looks, surroundings, theme
from editor.flowing import button_width
from editor.param_widgets import filled_slider
from editor.ui import Ui
from editor.widgets import cut, em, icon_button, pretty, text, tooltip
from engine.core.param import Param
from engine.render.settings import VIEW_LEGENDS

#: (setting, icon, width in em); those a build's settings do not have are left out
CONTROLS = (
    ("environment_rotation", "", 4.5),
    ("exposure", icons.EXPOSURE, 4.8),
    ("tone_map", icons.LOOK, 7.0),
    ("view", icons.VISIBLE, 6.6),
    ("path", icons.LIGHT, 6.0),
)
SURROUNDINGS = 6.4
GAP = 0.6
#: in a window lower than this, em, the strip takes one line
LOW = 18.0
#: (operation, icon)
TOOLS = (
    ("tool.select", icons.SELECT), ("tool.move", icons.MOVE), ("tool.rotate", icons.ROTATE),
    ("tool.scale", icons.SCALE), ("tool.local", icons.AXES), ("tool.measure", icons.RULER),
)  # fmt: skip
COMPARING = (("compare.take", "A"), ("compare.wipe", icons.COMPARE), ("compare.difference", icons.DIFFERENCE))
STAGING = (("view.look-card", icons.MATERIAL), ("view.shadow-floor", icons.FLOOR), ("view.turntable", icons.TURNTABLE))


def draw(ui: Ui) -> None:
    """Both bars; the lower one goes on in a further line where it does not fit."""
    imgui.set_cursor_pos((em(0.5), imgui.get_cursor_pos_y() + em(0.25)))
    for group in (TOOLS, COMPARING, STAGING):
        for place, (id, icon) in enumerate(group):
            if group is not TOOLS or place:
                _further(button_width(icon), 0.05 if place else 0.9)
            _tool(ui, id, icon)
    imgui.same_line(0, em(0.9))
    _cost(ui)
    look_bar(ui)


def look_bar(ui: Ui) -> None:
    """The look-dev strip. Where the picture would have no room left, what does not fit is behind a button."""
    settings = ui.session.settings
    known = {p.name: p for p in settings.PARAMS}
    left = em(0.5)
    imgui.set_cursor_pos_x(left)
    button = imgui.calc_text_size(icons.LIGHT).x + 2.0 * imgui.get_style().frame_padding.x
    tight = imgui.get_content_region_avail().y < em(LOW)
    _surroundings(ui)
    rest: list[tuple[str, str, float]] = []
    for name, icon, width in CONTROLS:
        if name not in known:
            continue
        imgui.same_line(0, em(GAP if icon else 0.15))
        room = imgui.get_content_region_avail().x - (em(2.0) if tight else 0.0)
        if rest or room < em(width) + (button if icon else 0.0):
            if tight:
                rest.append((name, icon, width))
                continue
            imgui.new_line()
            imgui.set_cursor_pos_x(left)
        _control(ui, known[name], icon, em(width))
    if rest:
        if icon_button(f"{icons.MORE}##look-rest", "The rest of the look"):
            imgui.open_popup("##look-rest")
        if imgui.begin_popup("##look-rest"):
            for name, icon, width in rest:
                _control(ui, known[name], icon, em(width))
            imgui.end_popup()
    imgui.set_cursor_pos_y(imgui.get_cursor_pos_y() - em(0.1))


def _tool(ui: Ui, id: str, icon: str) -> None:
    operation = ui.operations[id]
    active = operation.checked is not None and operation.checked(ui.session)
    if id == "compare.take":
        active = ui.session.comparing.moment(ui.session) is not None
    key = f" ({operation.shortcuts[0]})" if operation.shortcuts else ""
    hint = f"{operation.label}{key}" + (f"\n{operation.doc}" if operation.doc else "")
    if icon_button(f"{icon}##{id}", hint, active=active, enabled=operation.enabled(ui.session)):
        ui.operations.run(id, ui.session)


def _further(width: float, gap: float) -> None:
    """On in the line where `width` fits, else at the start of the next."""
    imgui.same_line(0, em(gap))
    if imgui.get_content_region_avail().x < width:
        imgui.new_line()
        imgui.set_cursor_pos_x(em(0.5))


def _surroundings(ui: Ui) -> None:
    """What the scene is lit by, as a list to choose from."""
    session = ui.session
    if icon_button(f"{icons.ENVIRONMENT}##panorama", "Light with a panorama (.hdr, .exr); or drop one on the window"):
        ui.operations.run("surroundings.panorama", session)
    imgui.same_line(0, 0)
    imgui.set_next_item_width(em(SURROUNDINGS))
    if imgui.begin_combo("##surroundings", cut(surroundings.label(session), em(SURROUNDINGS - 2.2))):
        for kind, (label, doc) in surroundings.KINDS.items():
            chosen = ui.operations[f"surroundings.{kind}"]
            if imgui.selectable(label, bool(chosen.checked and chosen.checked(session)))[0]:
                ui.operations.run(chosen.id, session)
            tooltip(doc)
        panorama = ui.operations["surroundings.panorama"]
        if imgui.selectable("Panorama…", bool(panorama.checked and panorama.checked(session)))[0]:
            ui.operations.run(panorama.id, session)
        tooltip("An .hdr or .exr file; or drop one on the window")
        imgui.end_combo()
    tooltip(f"Surroundings: {surroundings.label(session)}")


def _control(ui: Ui, param: Param, icon: str, width: float) -> None:
    session = ui.session
    value: Any = getattr(session.settings, param.name)
    if icon:
        changed = value != param.default
        if icon_button(
            f"{icon}##reset-{param.name}", f"{pretty(param.name)}: {param.doc}\nClick to reset", active=changed
        ):
            _set(ui, param, param.default)
        imgui.same_line(0, 0)
    imgui.set_next_item_width(width)
    if param.name == "tone_map":
        _look(ui, param)
        return
    if param.type == "enum":
        index = param.choices.index(value)
        changed, index = imgui.combo(f"##{param.name}", index, [pretty(choice) for choice in param.choices])
        if changed:
            _set(ui, param, param.choices[index])
    elif param.name == "environment_rotation":
        changed, new = filled_slider(f"##{param.name}", wrap_degrees(value), -180.0, 180.0, "%.0f°")
        if changed:
            _set(ui, param, float(new))
    else:
        changed, new = imgui.drag_float(f"##{param.name}", value, 0.02, param.min, param.max, "%+.2f EV")
        if changed:
            _set(ui, param, min(max(float(new), param.min), param.max))
    legend = VIEW_LEGENDS.get(value, "") if param.name == "view" else ""
    frame = session.image.frame
    if param.name == "path" and frame is not None and hasattr(frame, "path"):
        legend = f"{param.doc}\nNow: {pretty(frame.path.path)}, {frame.path.reason}"
    unit = "\nRelative EV: one more is twice as bright; 0 shows what the scene says" if param.unit == "EV" else ""
    tooltip(f"{pretty(param.name)}: {legend or param.doc}{unit}")


def _look(ui: Ui, param: Param) -> None:
    """The curve to the display, and the looks that match other programs."""
    session = ui.session
    look, value = looks.current(session), str(getattr(session.settings, param.name))
    shown = look.label if look is not None else f"{tone_map_name(value)}, changed"
    if imgui.begin_combo("##tone_map", cut(shown, em(5.0))):
        for candidate in looks.LOOKS:
            if imgui.selectable(candidate.label, candidate is look)[0]:
                ui.operations.run(f"look.{candidate.id}", session)
            tooltip(candidate.doc)
        imgui.separator_text("Curve alone")
        for choice in param.choices:
            if imgui.selectable(f"{tone_map_name(choice)}##curve-{choice}", choice == value)[0]:
                _set(ui, param, choice)
        imgui.end_combo()
    tooltip(f"{shown}\n{param.doc}")


def _set(ui: Ui, param: Param, value: Any) -> None:
    """One entry of the history for each drag; debug views and paths are looked at, not edited."""
    session = ui.session
    if param.name in ("view", "path") or session.document is None:
        setattr(session.settings, param.name, value)
        return
    session.edit("settings", param.name, (0,), ((value,),), gesture=f"strip-{param.name}", label=pretty(param.name))


def tone_map_name(choice: str) -> str:
    names = {"agx": "AgX", "aces": "ACES", "neutral": "PBR Neutral", "none": "None", "scene": "Scene's own"}
    return names.get(choice, pretty(choice))


def _cost(ui: Ui) -> None:
    """Right-aligned: milliseconds of the last rendered frame, and its size."""
    image = ui.session.image
    if image.frame is None or not ui.session.preferences.show_stats:
        imgui.new_line()
        return
    ms = image.frame.stats.total_ms
    value = f"{ms:.1f} ms   {image.width} × {image.height}"
    width = imgui.calc_text_size(value).x
    if imgui.get_content_region_avail().x > width + em(0.7):
        imgui.same_line(imgui.get_window_width() - width - em(0.7))
        imgui.align_text_to_frame_padding()
        text(value, theme.DIM)
        tooltip(f"The last frame: {ms:.2f} ms, {1000 / max(ms, 1e-6):.0f} a second if it were drawn without pause")
    else:
        imgui.new_line()


def wrap_degrees(angle: float) -> float:
    """Into [-180, 180]."""
    return (angle + 180.0) % 360.0 - 180.0
