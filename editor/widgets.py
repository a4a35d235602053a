"""Small parts that the panels share: rows of a property grid, icon buttons, headings, notices."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from imgui_bundle import imgui

from editor import icons, theme
from editor.strings import tr, verbatim
from editor.theme import Rgba
from editor.ui import Ui

#: a property grid narrower than this, em, has its labels above their widgets
NARROW = 13.0

#: put together once: an enum of Python takes its time, and every widget asks
_TIP = int(imgui.HoveredFlags_.for_tooltip) | int(imgui.HoveredFlags_.delay_normal)


def em(count: float = 1.0) -> float:
    """`count` times the height of the font, in imgui units."""
    return float(imgui.get_font_size()) * count


def text(value: str, color: Rgba | None = None) -> None:
    """A line of text; without a `color` in the theme's own."""
    imgui.text_colored(imgui.ImVec4(*(color or theme.TEXT)), value)


def own_text(value: str, color: Rgba | None = None) -> None:
    """Text of the user's own, a name or a line of code, which no language of the interface changes."""
    with verbatim():
        text(value, color)


@contextmanager
def pages(name: str) -> Iterator[bool]:
    """A row of tabs inside a panel, the one in front on a ground of its own. Yields False when it is clipped away."""
    imgui.push_style_color(imgui.Col_.tab_selected, imgui.ImVec4(*theme.FRAME_ACTIVE))
    imgui.push_style_color(imgui.Col_.tab_dimmed_selected, imgui.ImVec4(*theme.FRAME_ACTIVE))
    shown = bool(imgui.begin_tab_bar(name, imgui.TabBarFlags_.fitting_policy_scroll))
    yield shown
    if shown:
        imgui.end_tab_bar()
    imgui.pop_style_color(2)


def wrapped_text(value: str, color: Rgba | None = None) -> None:
    """Text in as many lines as the panel's width asks for."""
    imgui.push_text_wrap_pos(0.0)
    text(value, color)
    imgui.pop_text_wrap_pos()


def flow(width: float, gap: float = 1.0) -> None:
    """Go on in the line, `gap` em further, where `width` imgui units still fit into it; else in the next one."""
    imgui.same_line(0, em(gap))
    if imgui.get_content_region_avail().x < width:
        imgui.new_line()


def flow_text(value: str, color: Rgba | None = None, hint: str = "", *, gap: float = 1.0) -> None:
    """Text that goes on in the line, or in the next one where it does not fit."""
    flow(imgui.calc_text_size(value).x, gap)
    text(value, color)
    tooltip(hint)


def tooltip(value: str) -> None:
    """For the item before: shown after a moment, wrapped."""
    if value and imgui.is_item_hovered(_TIP):
        imgui.begin_tooltip()
        imgui.push_text_wrap_pos(em(24))
        imgui.text_unformatted(value)
        imgui.pop_text_wrap_pos()
        imgui.end_tooltip()


def bare_button(label: str, color: Rgba) -> bool:
    """A button without frame or ground until it is hovered."""
    imgui.push_style_color(imgui.Col_.button, imgui.ImVec4(0, 0, 0, 0))
    imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(*color))
    imgui.push_style_var(imgui.StyleVar_.frame_border_size, 0.0)
    clicked = bool(imgui.button(label))
    imgui.pop_style_var()
    imgui.pop_style_color(2)
    return clicked


def icon_button(label: str, hint: str, *, active: bool = False, enabled: bool = True) -> bool:
    """A frameless button; `active` colours it with the accent."""
    imgui.begin_disabled(not enabled)
    clicked = bare_button(label, theme.ACCENT if active else theme.TEXT)
    imgui.end_disabled()
    tooltip(hint)
    return clicked


def search_field(label: str, value: str, hint: str) -> str:
    """A text field over the full width with a hint, and a cross to empty it; returns what stands in it."""
    imgui.set_next_item_width(-em(2.0) if value else -1)
    _changed, new = imgui.input_text_with_hint(label, hint, value)
    if value:
        imgui.same_line(0, em(0.2))
        if icon_button(f"{icons.CLEAR}{label}-clear", "Clear"):
            return ""
    return str(new)


@contextmanager
def bold(ui: Ui) -> Iterator[None]:
    imgui.push_font(ui.fonts.bold, 0.0)
    yield
    imgui.pop_font()


@contextmanager
def mono(ui: Ui) -> Iterator[None]:
    imgui.push_font(ui.fonts.mono, 0.0)
    yield
    imgui.pop_font()


def section(ui: Ui, title: str, *, opened: bool = True) -> bool:
    """A collapsible heading; True when its content should be drawn."""
    flags = imgui.TreeNodeFlags_.default_open if opened else 0
    imgui.push_style_color(imgui.Col_.header, imgui.ImVec4(*theme.RAISED))
    imgui.push_style_color(imgui.Col_.header_hovered, imgui.ImVec4(*theme.FRAME_HOVER))
    imgui.push_style_color(imgui.Col_.header_active, imgui.ImVec4(*theme.FRAME_ACTIVE))
    imgui.push_style_var(imgui.StyleVar_.frame_border_size, 0.0)
    with bold(ui):
        shown = bool(imgui.collapsing_header(title, flags))
    imgui.pop_style_var()
    imgui.pop_style_color(3)
    return shown


@contextmanager
def property_grid(name: str) -> Iterator[bool]:
    """Two columns, labels and widgets; in a narrow panel one, each label above its widget. Yields False when it is
    clipped away; then draw nothing."""
    flags = imgui.TableFlags_.sizing_stretch_prop | imgui.TableFlags_.no_saved_settings
    stacked = imgui.get_content_region_avail().x < em(NARROW)
    shown = bool(imgui.begin_table(f"{name}##stacked" if stacked else name, 1 if stacked else 2, flags))
    if shown and not stacked:
        imgui.table_setup_column("name", imgui.TableColumnFlags_.width_stretch, 0.38)
        imgui.table_setup_column("value", imgui.TableColumnFlags_.width_stretch, 0.62)
    yield shown
    if shown:
        imgui.end_table()


def property_row(label: str, doc: str = "", *, changed: bool = False, menu: Callable[[], None] | None = None) -> None:
    """Begin a row: write the label, move to the widget's cell. `changed` marks a value that is not the default.
    `menu` draws what a right click on the label opens."""
    imgui.table_next_row()
    imgui.table_next_column()
    shown = fitted(label, imgui.get_content_region_avail().x)
    if imgui.table_get_column_count() > 1:
        imgui.align_text_to_frame_padding()
    text(shown, theme.TEXT if changed else theme.DIM)
    tooltip(doc if shown == label else f"{label}\n{doc}")
    if menu is not None and imgui.begin_popup_context_item("menu"):
        menu()
        imgui.end_popup()
    if imgui.table_get_column_count() > 1:
        imgui.table_next_column()
    imgui.set_next_item_width(-1)


def cut(value: str, width: float) -> str:
    """`value`, or as much of its start as fits into `width` imgui units, with an ellipsis."""
    if imgui.calc_text_size(value).x <= width:
        return value
    letters = len(value)
    while letters > 1 and imgui.calc_text_size(f"{value[:letters]}…").x > width:
        letters -= max(1, letters // 20)
    return f"{value[:letters]}…"


def wrapped(value: str, width: float) -> list[str]:
    """`value` in lines of at most `width` imgui units, broken between words."""
    rows: list[str] = []
    for word in value.split(" "):
        longer = f"{rows[-1]} {word}" if rows else word
        if rows and imgui.calc_text_size(longer).x <= width:
            rows[-1] = longer
        else:
            rows.append(word)
    return rows


def fitted(value: str, width: float) -> str:
    """`value`, or as much of its both ends as fits into `width` imgui units, with an ellipsis between."""
    if imgui.calc_text_size(value).x <= width:
        return value
    low, high = 0, len(value)
    while low < high:  # the most letters that still fit
        middle = (low + high + 1) // 2
        low, high = (middle, high) if imgui.calc_text_size(shortened(value, middle)).x <= width else (low, middle - 1)
    return shortened(value, low)


def shortened(value: str, letters: int) -> str:
    """`letters` of `value`, two fifths from its start and the rest from its end: file names differ at the end."""
    head = letters * 2 // 5
    tail = letters - head
    return f"{value[:head]}…{value[len(value) - tail :]}"


def fitted_text(value: str, color: Rgba | None = None, *, more: str = "") -> None:
    """Text that fits into what is left of the line; the whole of it and `more` in a tooltip."""
    shown = fitted(value, imgui.get_content_region_avail().x)
    text(shown, color)
    tooltip("\n".join(part for part in (value if shown != value else "", more) if part))


def property_text(label: str, value: str, doc: str = "") -> None:
    """A row that only tells."""
    property_row(label, doc)
    imgui.align_text_to_frame_padding()
    fitted_text(value)


def empty_state(icon: str, line: str, more: str = "") -> None:
    """What a panel shows when there is nothing to show: centred, quiet, says what to do."""
    size = imgui.get_content_region_avail()
    start = imgui.get_cursor_pos()
    parts = [icon, tr(line), *([tr(more)] if more else [])]
    lines = [(i, row) for i, part in enumerate(parts) for row in wrapped(part, size.x)]
    height = imgui.get_text_line_height_with_spacing() * len(lines)
    y = start.y + max(0.0, (size.y - height) * 0.42)
    for i, row in lines:
        width = imgui.calc_text_size(row).x
        imgui.set_cursor_pos((start.x + max(0.0, (size.x - width) * 0.5), y))
        own_text(row, theme.FAINT if i == 0 else theme.DIM)
        y += imgui.get_text_line_height_with_spacing()


def pretty(name: str) -> str:
    """`base_color` -> `Base color`."""
    words = name.replace("_", " ").strip()
    return words[:1].upper() + words[1:]
