"""The bar above the picture: the light's rotation, exposure, tone map, debug view; what the frame cost."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from imgui_bundle import imgui

from editor import icons, theme
from editor.param_widgets import filled_slider
from editor.ui import Ui
from editor.widgets import em, icon_button, pretty, text, tooltip
from engine.core.param import Param, ParamBlock
from engine.render.settings import VIEW_LEGENDS

#: (setting, icon, width in em); those a build's settings do not have are left out
CONTROLS = (
    ("environment_rotation", icons.ENVIRONMENT, 5.5),
    ("exposure", icons.EXPOSURE, 5.0),
    ("tone_map", icons.LOOK, 7.5),
    ("view", icons.VISIBLE, 7.0),
    ("path", icons.LIGHT, 7.5),
)
#: where there is no room for all: which stay, the first ones longest
KEPT = ("view", "path", "exposure", "tone_map", "environment_rotation")
GAP = 0.9
#: (operation, icon)
TOOLS = (
    ("tool.select", icons.SELECT), ("tool.move", icons.MOVE), ("tool.rotate", icons.ROTATE),
    ("tool.scale", icons.SCALE), ("tool.local", icons.AXES), ("tool.measure", icons.RULER),
)  # fmt: skip


def draw(ui: Ui) -> None:
    """One line over the width; where not all controls fit, the last of KEPT are left out."""
    settings = ui.session.settings
    known = {p.name: p for p in settings.PARAMS}
    imgui.set_cursor_pos((em(0.5), imgui.get_cursor_pos_y() + em(0.25)))
    _tools(ui)
    button = imgui.calc_text_size(icons.LIGHT).x + 2.0 * imgui.get_style().frame_padding.x
    shown = fitting(
        {name: em(width + GAP) + button for name, _icon, width in CONTROLS if name in known},
        imgui.get_content_region_avail().x,
    )
    for name, icon, width in CONTROLS:
        if name in shown:
            _control(settings, known[name], icon, em(width))
            if name == "path" and ui.session.image.frame is not None:
                tooltip(f"Now: {pretty(ui.session.image.frame.path.path)}\n{ui.session.image.frame.path.reason}")
            imgui.same_line(0, em(GAP))
    _cost(ui)


def fitting(widths: Mapping[str, float], room: float) -> set[str]:
    """Which of the controls fit, by KEPT."""
    shown: set[str] = set()
    for name in KEPT:
        if name in widths and widths[name] <= room:
            shown.add(name)
            room -= widths[name]
    return shown


def _tools(ui: Ui) -> None:
    """The tools as buttons, each with its key."""
    for id, icon in TOOLS:
        operation = ui.operations[id]
        active = operation.checked is not None and operation.checked(ui.session)
        hint = f"{operation.label} ({operation.shortcuts[0]})" + (f"\n{operation.doc}" if operation.doc else "")
        if icon_button(f"{icon}##{id}", hint, active=active):
            ui.operations.run(id, ui.session)
        imgui.same_line(0, em(0.05))
    imgui.same_line(0, em(0.7))


def _control(settings: ParamBlock, param: Param, icon: str, width: float) -> None:
    value: Any = getattr(settings, param.name)
    if icon:
        changed = value != param.default
        if icon_button(
            f"{icon}##reset-{param.name}", f"{pretty(param.name)}: {param.doc}\nClick to reset", active=changed
        ):
            setattr(settings, param.name, param.default)
        imgui.same_line(0, 0)
    imgui.set_next_item_width(width)
    if param.type == "enum":
        index = param.choices.index(value)
        changed, index = imgui.combo(f"##{param.name}", index, [_choice(param, c) for c in param.choices])
        if changed:
            setattr(settings, param.name, param.choices[index])
    elif param.name == "environment_rotation":
        changed, new = filled_slider(f"##{param.name}", wrap_degrees(value), -180.0, 180.0, "%.0f°")
        if changed:
            setattr(settings, param.name, float(new))
    else:
        changed, new = imgui.drag_float(f"##{param.name}", value, 0.02, param.min, param.max, "%+.2f EV")
        if changed:
            setattr(settings, param.name, min(max(float(new), param.min), param.max))
    legend = VIEW_LEGENDS.get(value, "") if param.name == "view" else ""
    tooltip(f"{pretty(param.name)}: {legend or param.doc}")


def _choice(param: Param, choice: str) -> str:
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
