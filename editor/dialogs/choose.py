"""A dialog that chooses one file for whoever asked: `session.ui.choose = ChooseFile(...)`."""

from __future__ import annotations

from imgui_bundle import imgui

from editor.dialogs.files import FileDialog
from editor.panels.folder_listing import Entry
from editor.requests import ChooseFile
from editor.ui import Ui


class ChooseDialog(FileDialog):
    def __init__(self) -> None:
        super().__init__(saving=False)
        self.name, self.has_recent = "Choose a file", False
        self._request: ChooseFile | None = None

    def _asked(self, ui: Ui) -> bool:
        request, ui.session.ui.choose = ui.session.ui.choose, None
        if request is None:
            return False
        self._request = request
        self.name = request.title
        return True

    def _shows(self, entry: Entry) -> bool:
        return self._request is not None and entry.name.lower().endswith(self._request.endings)

    def _start(self, ui: Ui) -> None:
        assert self._request is not None
        start = self._request.start
        self.folder, self.file = (start, "") if start.is_dir() else (start.parent, start.name)
        while not self.folder.is_dir() and self.folder != self.folder.parent:
            self.folder = self.folder.parent

    def _accept(self, ui: Ui) -> None:
        path = (self.folder / self.file).expanduser()
        if self.file and path.is_dir():
            self.folder, self.file = path, ""
        elif self.file and self._request is not None:
            imgui.close_current_popup()
            self._request.take(path)
