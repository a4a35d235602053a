"""The look of the editor: its palettes, fonts and spacing. Colours here are display sRGB.

Text keeps a contrast ratio (WCAG 2.2, 1.4.3 and 1.4.6) of 4.5 on what it stands on, 7 in the high-contrast theme.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from imgui_bundle import hello_imgui, imgui

from editor.fonts import cjk_font

Rgba = tuple[float, float, float, float]


def rgb(text: str, alpha: float = 1.0) -> Rgba:
    """`#rrggbb` -> (r, g, b, a) in 0..1."""
    value = int(text.lstrip("#"), 16)
    return (value >> 16 & 255) / 255, (value >> 8 & 255) / 255, (value & 255) / 255, alpha


BACKGROUND = rgb("#121316")
PANEL = rgb("#1a1c20")
RAISED = rgb("#23262b")
FRAME = rgb("#0f1013")
FRAME_HOVER = rgb("#282c33")
FRAME_ACTIVE = rgb("#2f343c")
BUTTON = rgb("#2a2e35")
BUTTON_HOVER = rgb("#363b45")
BORDER = rgb("#2c2f36")
TEXT = rgb("#dcdfe4")
DIM = rgb("#a6adb8")
FAINT = rgb("#888f9b")
ACCENT = rgb("#e9a94a")
ACCENT_DIM = rgb("#e9a94a", 0.30)
SELECTION = rgb("#2c5480", 0.72)
SELECTION_HOVER = rgb("#3a6ea5", 0.35)
INFO = rgb("#6fa8ec")
WARNING = rgb("#e8c15a")
ERROR = rgb("#f0655c")
GOOD = rgb("#8fd890")
AXES = (rgb("#e5534b"), rgb("#8ee063"), rgb("#4c8df0"))
FILL = rgb("#3d5a78")
FILL_ACTIVE = rgb("#3d6189")
POPUP = rgb("#1e2025")
BUTTON_ACTIVE = rgb("#424853")
#: handles that are dragged, scroll bars' and sliders'; lines of trees and quiet tabs
GRAB = rgb("#4c525d")
SLIDER = rgb("#6f7784")
LINES = rgb("#3a3f48")
#: bars of the timings panel, in order; apart for every colour vision, and told apart by their labels too
SERIES = tuple(rgb(c) for c in ("#47b8f0", "#f0c947", "#d55e00", "#a5f082", "#476ef0", "#bbbbbb", "#a9547e", "#7d6b4e"))

#: what the other themes change; the rest is as above
THEMES: dict[str, dict[str, Rgba]] = {
    "high-contrast": {
        "BACKGROUND": rgb("#000000"), "PANEL": rgb("#000000"), "RAISED": rgb("#1c1c1c"), "FRAME": rgb("#000000"),
        "FRAME_HOVER": rgb("#333333"), "FRAME_ACTIVE": rgb("#4d4d4d"), "BUTTON": rgb("#202020"),
        "BUTTON_HOVER": rgb("#404040"), "BORDER": rgb("#b8b8b8"), "TEXT": rgb("#ffffff"), "DIM": rgb("#e6e6e6"),
        "FAINT": rgb("#d2d2d2"), "ACCENT": rgb("#ffd600"), "ACCENT_DIM": rgb("#ffd600", 0.45),
        "SELECTION": rgb("#053278"), "SELECTION_HOVER": rgb("#053278", 0.75), "INFO": rgb("#a8dcff"),
        "WARNING": rgb("#ffd600"), "ERROR": rgb("#ffb8b0"), "GOOD": rgb("#7dff8a"), "FILL": rgb("#053278"),
        "FILL_ACTIVE": rgb("#0a4a9e"), "POPUP": rgb("#000000"), "BUTTON_ACTIVE": rgb("#4d4d4d"),
        "GRAB": rgb("#b8b8b8"), "SLIDER": rgb("#ffffff"), "LINES": rgb("#b8b8b8"),
    },
}  # fmt: skip
_DARK: dict[str, Rgba] = {name: globals()[name] for name in THEMES["high-contrast"]}


def use(name: str) -> None:
    """Make a theme's colours this module's; `apply` brings them to imgui. Unknown ones are the dark one."""
    globals().update(_DARK | THEMES.get(name, {}))


FONT_SIZE = 15.0


@dataclass(slots=True)
class Fonts:
    """Loaded once at start; None before that and where no font file was found (then the default font serves)."""

    regular: Any = None
    bold: Any = None
    mono: Any = None


def load_fonts() -> Fonts:
    """Roboto with Font Awesome 6 icons merged in, its bold cut for headings, Inconsolata for numbers and logs."""
    fonts = Fonts()
    fonts.regular = hello_imgui.load_font("fonts/Roboto/Roboto-Regular.ttf", FONT_SIZE)
    _merge_icons(FONT_SIZE * 0.86)
    _merge_cjk(FONT_SIZE * 1.08)
    fonts.bold = hello_imgui.load_font("fonts/Roboto/Roboto-Bold.ttf", FONT_SIZE)
    _merge_icons(FONT_SIZE * 0.86)
    _merge_cjk(FONT_SIZE * 1.08)
    fonts.mono = hello_imgui.load_font("fonts/Inconsolata-Medium.ttf", FONT_SIZE)
    _merge_icons(FONT_SIZE * 0.82)
    _merge_cjk(FONT_SIZE)
    return fonts


def _merge_cjk(size: float) -> None:
    """Glyphs of Chinese, Japanese and Korean, from a font of the system; without one they stay boxes (see fonts.py)."""
    font = cjk_font()
    if font is not None:
        params = hello_imgui.FontLoadingParams(merge_to_last_font=True, inside_assets=False)
        params.font_config.font_no = font.index
        hello_imgui.load_font(str(font.path), size, params)


def _merge_icons(size: float) -> None:
    params = hello_imgui.FontLoadingParams(merge_to_last_font=True)
    params.font_config.glyph_min_advance_x = FONT_SIZE * 1.15  # icons in a column line up
    hello_imgui.load_font("fonts/Font_Awesome_6_Free-Solid-900.otf", size, params)


def named(name: str) -> Rgba:
    """The colour of that name in the theme in use, or a `#rrggbb` of one's own: tables of colours hold names, so that
    they follow the theme."""
    return rgb(name) if name.startswith("#") else globals()[name]


def high_contrast() -> bool:
    """Whether the theme in use is made for the eyes before all else."""
    return THEMES["high-contrast"]["PANEL"] == PANEL


def apply(scale: float = 1.0, display: float = 1.0) -> None:
    """Set imgui's style, whatever it was before. `scale` is the user's own factor on top of the display's, which sizes
    want too (`display`) once the window has scaled what it found at the start; fonts have it already."""
    style, fresh = imgui.get_style(), imgui.Style()
    for name in dir(fresh):  # scaling goes over all sizes: those that are not set here must not grow each time
        value = getattr(fresh, name)
        if isinstance(value, (float, imgui.ImVec2)) and not name.startswith("font_"):
            setattr(style, name, value)
    style.window_padding = imgui.ImVec2(10, 8)
    style.frame_padding = imgui.ImVec2(8, 4)
    style.cell_padding = imgui.ImVec2(6, 3)
    style.item_spacing = imgui.ImVec2(8, 5)
    style.item_inner_spacing = imgui.ImVec2(6, 4)
    style.indent_spacing = 16
    style.scrollbar_size = 12
    style.grab_min_size = 10
    style.window_border_size = style.child_border_size = style.popup_border_size = 1
    style.tab_border_size = 0
    style.frame_border_size = 1
    style.tab_bar_border_size = 1
    style.tab_bar_overline_size = 2
    style.window_rounding = style.popup_rounding = 6
    style.child_rounding = 4
    style.frame_rounding = style.grab_rounding = style.tab_rounding = 4
    style.scrollbar_rounding = 6
    style.window_title_align = imgui.ImVec2(0.0, 0.5)
    style.window_menu_button_position = imgui.Dir.none
    style.docking_separator_size = 3
    style.docking_node_has_close_button = False
    style.tab_close_button_min_width_selected = style.tab_close_button_min_width_unselected = 0  # while hovered
    style.separator_text_border_size = 1
    style.separator_text_padding = imgui.ImVec2(0, 6)
    style.disabled_alpha = 0.7 if high_contrast() else 0.45
    style.hover_delay_short = 0.25
    style.font_scale_main = scale
    style.scale_all_sizes(scale * display)
    for name in ("window_border_size", "child_border_size", "popup_border_size", "frame_border_size"):
        setattr(style, name, max(getattr(style, name), 1.0))  # at 75 % it would be rounded away
    for name, color in _colors().items():
        style.set_color_(getattr(imgui.Col_, name), imgui.ImVec4(*color))


def _colors() -> dict[str, Rgba]:
    clear = (0.0, 0.0, 0.0, 0.0)
    return {
        "text": TEXT, "text_disabled": DIM, "window_bg": PANEL, "child_bg": clear, "popup_bg": POPUP,
        "border": BORDER, "border_shadow": clear, "frame_bg": FRAME, "frame_bg_hovered": FRAME_HOVER,
        "frame_bg_active": FRAME_ACTIVE, "title_bg": BACKGROUND, "title_bg_active": BACKGROUND,
        "title_bg_collapsed": BACKGROUND, "menu_bar_bg": BACKGROUND, "scrollbar_bg": clear,
        "scrollbar_grab": GRAB, "scrollbar_grab_hovered": SLIDER,
        "scrollbar_grab_active": ACCENT, "check_mark": ACCENT, "slider_grab": SLIDER,
        "slider_grab_active": ACCENT, "button": BUTTON, "button_hovered": BUTTON_HOVER,
        "button_active": BUTTON_ACTIVE, "header": SELECTION, "header_hovered": SELECTION_HOVER,
        "header_active": SELECTION, "separator": BORDER, "separator_hovered": ACCENT_DIM, "separator_active": ACCENT,
        "resize_grip": clear, "resize_grip_hovered": ACCENT_DIM, "resize_grip_active": ACCENT, "tab": BACKGROUND,
        "tab_hovered": RAISED, "tab_selected": PANEL, "tab_selected_overline": ACCENT, "tab_dimmed": BACKGROUND,
        "tab_dimmed_selected": PANEL, "tab_dimmed_selected_overline": SLIDER, "docking_preview": ACCENT_DIM,
        "docking_empty_bg": BACKGROUND, "table_header_bg": RAISED, "table_border_strong": BORDER,
        "table_border_light": RAISED, "table_row_bg": clear, "table_row_bg_alt": (1.0, 1.0, 1.0, 0.018),
        "text_selected_bg": SELECTION, "drag_drop_target": ACCENT, "nav_cursor": ACCENT,
        "modal_window_dim_bg": (0.0, 0.0, 0.0, 0.55), "plot_histogram": ACCENT, "tree_lines": LINES,
    }  # fmt: skip


def u32(color: Rgba, alpha: float = 1.0) -> int:
    """A colour for draw lists, its alpha scaled by `alpha`."""
    return int(imgui.get_color_u32(imgui.ImVec4(color[0], color[1], color[2], color[3] * alpha)))
