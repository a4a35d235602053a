"""What lies under the pointer, from front to back, to choose from."""

from __future__ import annotations

from imgui_bundle import imgui

from editor import theme
from editor.ui import Ui
from editor.widgets import text


class PickList:
    """Opens where the pointer is when the session asks for it."""

    NAME = "##pick-list"

    def __init__(self) -> None:
        self._rows: tuple[int, ...] = ()

    def draw(self, ui: Ui) -> None:
        session = ui.session
        if session.ui.pick_list:
            self._rows, session.ui.pick_list = session.ui.pick_list, ()
            imgui.open_popup(self.NAME)
        if not imgui.begin_popup(self.NAME):
            return
        document = session.document
        beside = imgui.is_mouse_clicked(imgui.MouseButton_.left) and not imgui.is_window_hovered()
        if document is None or beside or imgui.is_key_pressed(imgui.Key.escape, False):
            imgui.close_current_popup()
        else:
            text("Under the pointer", theme.FAINT)
            alive = document.runtime.scene.nodes.alive
            for row in (r for r in self._rows if r < len(alive) and alive[r]):
                if imgui.menu_item(f"{session.node_name(row)}##pick{row}", "", row in document.selection)[0]:
                    document.select(row, toggle=bool(imgui.get_io().key_ctrl))
        imgui.end_popup()
