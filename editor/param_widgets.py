"""A widget for every Param: the same declaration that makes the UBO field makes the slider.

Colours are scene-linear Rec.709 in the engine and shown as sRGB, so that the swatch looks like the surface.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from imgui_bundle import imgui

from editor import icons, theme
from editor.strings import tr
from editor.widgets import em, icon_button, pretty, property_row
from engine.core.param import Param

#: stands for values that differ
MIXED = "—"


def srgb_from_linear(c: float) -> float:
    """IEC 61966-2-1:1999 encoding, continued above 1 for HDR colours; negative values are taken as 0."""
    c = max(c, 0.0)
    return 12.92 * c if c <= 0.0031308 else 1.055 * c ** (1 / 2.4) - 0.055


def linear_from_srgb(c: float) -> float:
    """The inverse of srgb_from_linear."""
    c = max(c, 0.0)
    return c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4


def param_row(
    param: Param, value: Any, *, id: str = "", label: str = "", degrees: bool = False, mixed: bool = False,
    changed: bool | None = None, menu: Callable[[], None] | None = None, more: str = "",
) -> tuple[bool, Any]:  # fmt: skip
    """A row of a property grid for `param`: (changed, new value). A value that is not the default can be reset.

    `degrees`: the value is in radians and shown in degrees. `mixed`: `value` is that of one of several, whose values
    differ: a dash is shown. `changed`: whether one of them is not the default. `menu`: of a right click.
    `more`: a line of the tooltip."""
    can_reset = not _same(value, param.default) if changed is None else changed
    unit = f" [{'°' if degrees else param.unit}]" if param.unit or degrees else ""
    told = [
        f"{tr(param.doc or pretty(param.name))}{unit}{_limits(param)}",
        more,
        "The selected ones differ" if mixed else "",
    ]
    doc = "\n".join(line for line in told if line)
    imgui.push_id(f"{id}{param.name}")
    property_row(label or pretty(param.name), doc, changed=can_reset, menu=menu)
    reset = False
    if can_reset:
        imgui.set_next_item_width(-em(2.0))
    edited, new = edit_value(param, value, degrees=degrees, mixed=mixed)
    if can_reset:
        imgui.same_line(0, em(0.2))
        reset = icon_button(f"{icons.RESET}###reset", f"Back to {format_value(param.default)}")
    imgui.pop_id()
    return (True, param.default) if reset else (edited, new)


def edit_value(param: Param, value: Any, *, degrees: bool = False, mixed: bool = False) -> tuple[bool, Any]:
    """The bare widget for `param`, named `##value`; `mixed` shows a dash in the value's stead."""
    kind = param.type
    if kind == "bool":
        imgui.push_item_flag(imgui.ItemFlags_.mixed_value, mixed)
        changed, new = imgui.checkbox("##value", bool(value))
        imgui.pop_item_flag()
        return bool(changed), bool(new)
    if kind == "enum":
        return _edit_choice(param, value, mixed)
    if kind in {"int", "uint"}:
        return _edit_int(param, int(value), mixed)
    if kind in {"color3", "color4"}:
        return _edit_color(param, tuple(value), mixed)
    if kind == "float":
        return _edit_float(param, float(value), degrees, mixed)
    return _edit_vector(param, value, mixed)


def _edit_choice(param: Param, value: Any, mixed: bool) -> tuple[bool, Any]:
    chosen = None
    if imgui.begin_combo("##value", MIXED if mixed else pretty(str(value))):
        for choice in param.choices:
            if imgui.selectable(pretty(choice), not mixed and choice == value)[0]:
                chosen = choice
        imgui.end_combo()
    return chosen is not None, value if chosen is None else chosen


def _edit_float(param: Param, value: float, degrees: bool, mixed: bool) -> tuple[bool, float]:
    factor = 180.0 / math.pi if degrees else 1.0
    low, high = param.min * factor, param.max * factor
    unit = "°" if degrees else f" {param.unit}" if param.unit and param.unit.isascii() else ""
    format = MIXED if mixed else f"%.{1 if degrees else 3}f{unit}"
    if math.isfinite(low) and math.isfinite(high):
        changed, new = filled_slider("##value", value * factor, low, high, format, empty=mixed)
    else:
        speed = param.step or max(abs(value * factor) * 0.005, 0.002)
        bounded = math.isfinite(low) or math.isfinite(high)
        changed, new = imgui.drag_float(
            "##value", value * factor, speed,
            low if math.isfinite(low) else -1e30, high if math.isfinite(high) else 1e30, format,
            imgui.SliderFlags_.always_clamp if bounded else 0,
        )  # fmt: skip
    return bool(changed), min(max(float(new) / factor, param.min), param.max)


def filled_slider(
    label: str, value: float, low: float, high: float, format: str, *, empty: bool = False
) -> tuple[bool, float]:
    """A slider drawn as a bar that fills from the left, or from zero where the range holds it: its number stays
    readable at any value. Takes the next item width. `empty`: without the bar."""
    width, height = imgui.calc_item_width(), imgui.get_frame_height()
    start = imgui.get_cursor_screen_pos()
    lines = imgui.get_window_draw_list()
    rounding = imgui.get_style().frame_rounding
    hovered = imgui.is_mouse_hovering_rect(start, (start.x + width, start.y + height)) and imgui.is_window_hovered()
    ground = theme.FRAME_HOVER if hovered else theme.FRAME
    lines.add_rect_filled(start, (start.x + width, start.y + height), theme.u32(ground), rounding)
    span = max(high - low, 1e-30)
    origin, at = (min(max((v - low) / span, 0.0), 1.0) for v in (0.0 if low < 0.0 < high else low, value))
    left, right = start.x + min(origin, at) * width, start.x + max(origin, at) * width
    fill = theme.FILL_ACTIVE if hovered else theme.FILL
    if right - left > 1.0 and not empty:
        lines.add_rect_filled((left, start.y), (right, start.y + height), theme.u32(fill), rounding)
    if low < 0.0 < high:  # where zero is: short ticks, clear of the number
        x, tick = start.x + origin * width, height * 0.16
        for y0, y1 in ((start.y, start.y + tick), (start.y + height - tick, start.y + height)):
            lines.add_line((x, y0), (x, y1), theme.u32(theme.FAINT))
    clear = imgui.ImVec4(0, 0, 0, 0)
    names = ("frame_bg", "frame_bg_hovered", "frame_bg_active", "slider_grab", "slider_grab_active")
    for name in names:
        imgui.push_style_color(getattr(imgui.Col_, name), clear)
    changed, new = imgui.slider_float(label, value, low, high, format, imgui.SliderFlags_.always_clamp)
    imgui.pop_style_color(len(names))
    return bool(changed), float(new)


def _edit_int(param: Param, value: int, mixed: bool) -> tuple[bool, int]:
    unit = f" {param.unit}" if param.unit and param.unit.isascii() else ""
    format = MIXED if mixed else f"%d{unit}"
    if math.isfinite(param.min) and math.isfinite(param.max):
        changed, new = imgui.slider_int("##value", value, int(param.min), int(param.max), format)
    else:
        changed, new = imgui.drag_int("##value", value, 1.0, 0, 0, format)
    return bool(changed), int(min(max(new, param.min), param.max))


def _edit_vector(param: Param, value: Any, mixed: bool) -> tuple[bool, tuple[float, ...]]:
    widget = {2: imgui.drag_float2, 3: imgui.drag_float3, 4: imgui.drag_float4}[len(value)]
    format = MIXED if mixed else "%.3f"
    changed, new = widget("##value", [float(v) for v in value], param.step or 0.01, 0.0, 0.0, format)
    return bool(changed), tuple(min(max(float(v), param.min), param.max) for v in new)


def _edit_color(param: Param, value: tuple[float, ...], mixed: bool) -> tuple[bool, tuple[float, ...]]:
    if mixed:
        return _edit_mixed_color(param, value)
    shown = [srgb_from_linear(c) for c in value[:3]] + list(value[3:])
    hdr = param.max > 1.0
    flags = imgui.ColorEditFlags_.float | imgui.ColorEditFlags_.hdr if hdr else imgui.ColorEditFlags_.uint8
    if imgui.calc_item_width() < em(2.6 * len(value) + 2.0):  # too narrow for a number a channel
        flags |= imgui.ColorEditFlags_.no_inputs if hdr else imgui.ColorEditFlags_.display_hex
    if len(value) == 4:
        changed, new = imgui.color_edit4("##value", shown, flags | imgui.ColorEditFlags_.alpha_preview_half)
    else:
        changed, new = imgui.color_edit3("##value", shown, flags)
    if not changed:
        return False, value
    channels = [float(c) for c in new][: len(value)]
    linear = [linear_from_srgb(c) for c in channels[:3]] + channels[3:]
    return True, tuple(min(max(c, param.min), param.max) for c in linear)


def _edit_mixed_color(param: Param, value: tuple[float, ...]) -> tuple[bool, tuple[float, ...]]:
    """A dash; a click opens a picker that begins with the first of the colours."""
    if imgui.button(f"{MIXED}##value", (imgui.calc_item_width(), 0)):
        imgui.open_popup("pick")
    changed, new = False, value
    if imgui.begin_popup("pick"):
        imgui.set_next_item_width(em(14))
        changed, new = _edit_color(param, value, False)
        imgui.end_popup()
    return changed, new


def format_value(value: Any) -> str:
    """A short text of a parameter's value."""
    if isinstance(value, bool):
        return "on" if value else "off"
    if isinstance(value, (int, float)):
        return f"{value:g}"
    if isinstance(value, (tuple, list)):
        return ", ".join(f"{float(v):g}" for v in value)
    return str(value)


def _limits(param: Param) -> str:
    if param.type in {"bool", "enum"} or not (math.isfinite(param.min) and math.isfinite(param.max)):
        return ""
    return f"\n{param.min:g} – {param.max:g}"


def _same(a: Any, b: Any) -> bool:
    if isinstance(a, (tuple, list)) and isinstance(b, (tuple, list)):
        return len(a) == len(b) and all(_same(x, y) for x, y in zip(a, b, strict=True))
    if isinstance(a, float) or isinstance(b, float):
        return math.isclose(float(a), float(b), rel_tol=1e-6, abs_tol=1e-9)
    return bool(a == b)
