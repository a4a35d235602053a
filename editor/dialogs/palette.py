"""The command palette: type a few letters of an operation, press Enter."""

from __future__ import annotations

from imgui_bundle import imgui

from editor import icons, theme
from editor.keys import shown_shortcut
from editor.operations import Operation
from editor.strings import tr
from editor.ui import Ui
from editor.widgets import em, own_text, text

NAME = "###palette"
ROWS = 12


class Palette:
    def __init__(self) -> None:
        self.needle = ""
        self.index = 0

    def draw(self, ui: Ui) -> None:
        if ui.session.ui.palette:
            ui.session.ui.palette = False
            self.needle, self.index = "", 0
            imgui.open_popup(NAME)
        viewport = imgui.get_main_viewport()
        at = (viewport.pos.x + viewport.size.x * 0.5, viewport.pos.y + viewport.size.y * 0.14)
        imgui.set_next_window_pos(at, imgui.Cond_.always, (0.5, 0.0))
        imgui.set_next_window_size((em(34), 0))
        if not imgui.begin_popup(NAME):
            return
        if imgui.is_window_appearing():
            imgui.set_keyboard_focus_here()
        imgui.set_next_item_width(-1)
        changed, self.needle = imgui.input_text_with_hint("##needle", f"{icons.SEARCH}  What to do", self.needle)
        found = ui.operations.search(self.needle, ui.session)
        if changed:
            self.index = 0
        self.index += int(imgui.is_key_pressed(imgui.Key.down_arrow)) - int(imgui.is_key_pressed(imgui.Key.up_arrow))
        self.index = max(0, min(self.index, len(found) - 1))
        chosen: Operation | None = None
        first = max(0, self.index - ROWS + 1)
        for i, operation in enumerate(found[first : first + ROWS], first):
            if self._row(ui, operation, i == self.index):
                chosen = operation
        if not found:
            text("No operation of that name is available now", theme.DIM)
        if found and imgui.is_key_pressed(imgui.Key.enter):
            chosen = found[self.index]
        if chosen is not None or imgui.is_key_pressed(imgui.Key.escape):
            imgui.close_current_popup()
        imgui.end_popup()
        if chosen is not None and chosen.asks:
            ui.asked = chosen
        elif chosen is not None:
            ui.operations.attempt(chosen.id, ui.session)

    def _row(self, ui: Ui, operation: Operation, selected: bool) -> bool:
        start = imgui.get_cursor_pos_x()
        clicked = bool(imgui.selectable(f"##{operation.id}", selected)[0])
        imgui.same_line(start)
        if operation.menu:
            text(f"{operation.menu}  ", theme.FAINT)
            imgui.same_line(0, 0)
        text(f"{tr(operation.label)}…" if operation.asks else operation.label)
        keys = "   ".join(map(shown_shortcut, ui.operations.keys_of(operation)))
        if keys:
            imgui.same_line(imgui.get_window_width() - imgui.calc_text_size(keys).x - em(1.0))
            own_text(keys, theme.DIM)
        return clicked
