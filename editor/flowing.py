"""Rows of widgets for panels of any width: what does not fit goes on in the next line, what is wider than the panel is
cut and said in full by its tooltip. See widgets.flow and widgets.flow_text, which this builds on."""

from __future__ import annotations

from imgui_bundle import imgui

from editor import theme
from editor.strings import tr, verbatim
from editor.widgets import cut, em, flow, icon_button, tooltip, wrapped


def button_width(label: str) -> float:
    """Of a button with that label, in imgui units."""
    return float(imgui.calc_text_size(label.partition("##")[0]).x + 2.0 * imgui.get_style().frame_padding.x)


def flow_button(
    label: str, hint: str = "", *, gap: float = 0.4, first: bool = False, active: bool = False, enabled: bool = True
) -> bool:
    """A button that goes on in the line where it fits, else in the next; `first`: the row begins with it."""
    shown, hashes, identity = label.partition("##")
    words = tr(shown)
    if not first:
        flow(button_width(words), gap)
    room = imgui.get_content_region_avail().x - 2.0 * imgui.get_style().frame_padding.x
    short = cut(words, max(room, em(2)))
    imgui.begin_disabled(not enabled)
    if active:
        imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(*theme.ACCENT))
    with verbatim():
        pressed = bool(imgui.button(f"{short}###{identity.lstrip('#') if hashes else shown}"))
    if active:
        imgui.pop_style_color()
    imgui.end_disabled()
    if short != words or hint:
        tooltip("\n".join(part for part in (words if short != words else "", tr(hint) if hint else "") if part))
    return pressed


def wide_button(label: str, hint: str = "", *, enabled: bool = True) -> bool:
    """A button over the whole width; what does not fit into one line goes on in a further one."""
    shown, _hashes, identity = label.partition("##")
    room = imgui.get_content_region_avail().x - 2.0 * imgui.get_style().frame_padding.x
    lines = "\n".join(wrapped(tr(shown), room))
    height = imgui.calc_text_size(lines).y + 2.0 * imgui.get_style().frame_padding.y
    imgui.begin_disabled(not enabled)
    with verbatim():
        pressed = bool(imgui.button(f"{lines}###{identity.lstrip('#')}", (-1, max(em(2.0), height))))
    imgui.end_disabled()
    tooltip(tr(hint))
    return pressed


def flow_icon(icon: str, id: str, hint: str, *, gap: float = 0.1, active: bool = False, enabled: bool = True) -> bool:
    """A frameless icon button that goes on in the line where it fits, else in the next."""
    flow(button_width(icon), gap)
    return icon_button(f"{icon}##{id}", hint, active=active, enabled=enabled)


def field_width(count: float, *, least: float = 3.0) -> None:
    """The next widget is `count` em wide, or as wide as the line has room for, but not less than `least` em."""
    room = float(imgui.get_content_region_avail().x)
    imgui.set_next_item_width(max(min(em(count), room), min(em(least), em(count))))


def flow_field(count: float, *, gap: float = 0.4) -> None:
    """The next widget is `count` em wide and goes on in the line where it fits, else in the next."""
    flow(em(count), gap)
    field_width(count)
