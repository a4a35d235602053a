"""A and B in the viewport: A left of a line that is dragged, A alone, or where they differ; and what they are."""

from __future__ import annotations

from imgui_bundle import imgui

from editor import keys, overlay, theme
from editor.comparing.comparing import DIFFERENCE, OFF, ONLY_A, WIPE
from editor.ui import Ui
from editor.widgets import cut, em

HOLD = "compare.hold"
#: how near to the line, in em, the pointer takes it
REACH = 0.5
#: the line never leaves the picture
MARGIN = 0.01


class CompareOverlay:
    """`dragging`: the line is held."""

    def __init__(self) -> None:
        self.dragging = False

    def release(self, ui: Ui) -> None:
        """End holding once the key is up. Before anything of the frame is drawn."""
        comparing = ui.session.comparing
        if comparing.held:
            io = imgui.get_io()
            down = any(imgui.is_key_down(key) for key in _keys(ui))
            if not down or io.app_focus_lost:
                comparing.release()

    def draw(self, ui: Ui, x: float, y: float, width: float, height: float, *, hoverable: bool) -> bool:
        """Over the picture at (x, y); True while the pointer is on the line or drags it."""
        session = ui.session
        comparing, mode = session.comparing, session.comparing.showing(session)
        moment = comparing.shown_moment(session)
        if mode == OFF or moment is None:
            self.dragging = False
            return False
        native = comparing.native(session)
        share = comparing.split if mode == WIPE else 1.0
        lines = imgui.get_window_draw_list()
        if native:
            lines.add_image(imgui.ImTextureRef(native), (x, y), (x + share * width, y + height), (0, 0), (share, 1))
        taken = False
        if mode == WIPE:
            taken = self._line(ui, x, y, width, height, hoverable)
        self._words(ui, mode, x, y, width, height)
        return taken

    def _line(self, ui: Ui, x: float, y: float, width: float, height: float, hoverable: bool) -> bool:
        comparing, mouse = ui.session.comparing, imgui.get_io().mouse_pos
        at = x + comparing.split * width
        over = hoverable and abs(mouse.x - at) < em(REACH) and y <= mouse.y <= y + height
        if over and imgui.is_mouse_clicked(imgui.MouseButton_.left):
            self.dragging = True
        if self.dragging:
            self.dragging = bool(imgui.is_mouse_down(imgui.MouseButton_.left))
            comparing.split = min(max((mouse.x - x) / max(width, 1.0), MARGIN), 1.0 - MARGIN)
            at = x + comparing.split * width
        if over or self.dragging:
            imgui.set_mouse_cursor(imgui.MouseCursor_.resize_ew)
        lines = imgui.get_window_draw_list()
        color = theme.u32(theme.ACCENT if over or self.dragging else theme.TEXT)
        lines.add_line((at, y), (at, y + height), theme.u32((0.0, 0.0, 0.0, 0.55)), 4.0)
        lines.add_line((at, y), (at, y + height), color, 1.6)
        middle, r = y + 0.5 * height, em(0.75)
        lines.add_circle_filled((at, middle), r, theme.u32((0.05, 0.055, 0.065, 0.85)))
        lines.add_circle((at, middle), r, color, 0, 1.6)
        for side in (-1.0, 1.0):
            tip, back, half = at + side * 0.55 * r, at + side * 0.2 * r, 0.3 * r
            lines.add_triangle_filled((tip, middle), (back, middle - half), (back, middle + half), color)
        return over or self.dragging

    def _words(self, ui: Ui, mode: str, x: float, y: float, width: float, height: float) -> None:
        """Whose half is whose, and the numbers in the middle of the upper edge."""
        session = ui.session
        comparing, moment = session.comparing, session.comparing.shown_moment(session)
        assert moment is not None
        split = x + comparing.split * width if mode == WIPE else x + width
        top = y + em(0.6)
        stale = "  (last picture)" if moment.frozen else ""
        if mode == DIFFERENCE:
            overlay.chip(x + em(0.6), top, "Where A and B differ, × 32", theme.ACCENT)
        elif split - x > em(5):
            overlay.chip(x + em(0.6), top, cut(f"A  {moment.label}{stale}", split - x - em(2.2)), theme.ACCENT)
        if mode == WIPE and x + width - split > em(12):
            overlay.chip(split + em(0.6), top, "B  now")
        line = numbers_line(ui)
        if mode != ONLY_A and line:
            size = imgui.calc_text_size(line).x + 2 * imgui.get_style().frame_padding.x
            overlay.chip(x + max(0.5 * (width - size), em(0.6)), top + em(1.9), line)


def numbers_line(ui: Ui) -> str:
    """How the two differ and what they cost, in one line; '' while there are no numbers."""
    comparing = ui.session.comparing
    difference = comparing.difference
    if difference is None:
        return ""
    if difference.equal:
        parts = ["A = B in every pixel"]
    else:
        flip = f"{comparing.flip:.4f}" if isinstance(comparing.flip, float) else "…" if comparing.flip is None else "–"
        parts = [f"FLIP {flip}", f"max {difference.largest}", f"{100 * difference.differing:.3g} % of pixels"]
    a, b = comparing.times()
    if a and b:
        parts.append(f"{a:.1f} → {b:.1f} ms")
    return "   ".join(parts)


def _keys(ui: Ui) -> list[imgui.Key]:
    """The keys that hold, without their modifiers: those may be let go of first."""
    shortcuts = [key for key, id in ui.operations.shortcuts().items() if id == HOLD]
    return [imgui.Key(keys.chord(shortcut.split("+")[-1])) for shortcut in shortcuts]
