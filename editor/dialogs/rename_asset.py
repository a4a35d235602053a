"""Rename or move a file of the project: its new path, who uses it, and why it is refused, before anything is done."""

from __future__ import annotations

from pathlib import Path

from imgui_bundle import imgui

from editor import file_moves, icons, theme
from editor.dialogs.modals import begin_card, center_next_window
from editor.ui import Ui
from editor.widgets import bold, em, fitted_text, text
from engine.core.errors import LucarnaError
from importers.project.moving import Move, plan
from importers.project.references import project_root

#: users that are named; of more, their count
NAMED = 8


class RenameAsset:
    NAME = "Rename or move"

    def __init__(self) -> None:
        self._old = Path()
        self._root = Path()
        self._path = ""
        self._planned: Move | None = None
        self._problem = ""
        self._users: list[str] = []
        self._focus = False

    def draw(self, ui: Ui) -> None:
        asked, ui.session.ui.rename_asset = ui.session.ui.rename_asset, None
        if asked is not None:
            self._start(ui, asked)
            imgui.open_popup(self.NAME)
        center_next_window(34)
        if not begin_card(self.NAME, modal=True):
            return
        with bold(ui):
            imgui.text_unformatted(f"{icons.FILE}  {self._old.relative_to(self._root).as_posix()}")
        if self._focus:
            imgui.set_keyboard_focus_here()
            self._focus = False
        imgui.set_next_item_width(-1)
        changed, self._path = imgui.input_text("##path", self._path)
        if changed:
            self._look()
        if self._problem:
            imgui.push_text_wrap_pos(0)
            text(self._problem, theme.WARNING)
            imgui.pop_text_wrap_pos()
        text(f"Used by {len(self._users) or 'nothing'}", theme.DIM)
        for name in self._users[:NAMED]:
            fitted_text(f"    {name}", theme.FAINT)
        if len(self._users) > NAMED:
            text(f"    and {len(self._users) - NAMED} more", theme.FAINT)
        imgui.spacing()
        imgui.begin_disabled(self._planned is None)
        done = imgui.button("Move", (em(6), 0)) or (self._planned is not None and _entered())
        imgui.end_disabled()
        if done and self._planned is not None:
            file_moves.move(ui.session, self._old, self._root / self._path.strip(), self._root)
            imgui.close_current_popup()
        imgui.same_line()
        if imgui.button("Cancel", (em(6), 0)) or imgui.is_key_pressed(imgui.Key.escape):
            imgui.close_current_popup()
        imgui.end_popup()

    def _start(self, ui: Ui, path: Path) -> None:
        self._old = path.absolute()
        file_moves.put_back(ui.session, self._old)
        self._root = project_root(self._old)
        self._path = self._old.relative_to(self._root).as_posix()
        links = ui.session.links
        links.refresh(self._root, wait=True)
        self._users = [p.relative_to(self._root).as_posix() for p in links.used_by(self._old)]
        self._focus, self._planned, self._problem = True, None, ""

    def _look(self) -> None:
        """What would happen with the path as it is typed now."""
        self._planned, self._problem = None, ""
        wanted = self._path.strip()
        if not wanted or wanted == self._old.relative_to(self._root).as_posix():
            return
        try:
            self._planned = plan(self._old, self._root / wanted, root=self._root)
        except LucarnaError as error:
            self._problem = f"{error.message}{f' ({error.hint})' if error.hint else ''}"


def _entered() -> bool:
    return bool(imgui.is_key_pressed(imgui.Key.enter) or imgui.is_key_pressed(imgui.Key.keypad_enter))
