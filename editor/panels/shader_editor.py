"""Shader editor: effects, shaders and materials as text; what is wrong with them stands at its line."""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar

from imgui_bundle import imgui

from editor import icons
from editor.code.document import CodeDocument
from editor.code_field import CodeField
from editor.panels.base import Panel
from editor.panels.shader_bars import draw_bars, draw_header
from editor.panels.shader_find import FindBar
from editor.ui import Ui
from editor.widgets import em, empty_state, mono, tooltip


class ShaderEditorPanel(Panel):
    title: ClassVar[str] = "Shader editor"
    icon: ClassVar[str] = icons.CODE
    dock: ClassVar[str] = "Code"
    opened: ClassVar[bool] = False

    def __init__(self) -> None:
        self.fields: dict[Path, CodeField] = {}
        self.finder = FindBar()
        self.closing: CodeDocument | None = None
        self.shown: CodeDocument | None = None

    def draw(self, ui: Ui) -> None:
        code = ui.session.code
        if self._asks_to_find():
            code.find = code.front is not None
        code.focused = bool(imgui.is_window_focused(imgui.FocusedFlags_.child_windows)) and code.front is not None
        if not code.documents:
            empty_state(icons.CODE, "No shader is open", "Shaders > Open effect of the selected material")
            return
        draw_header(ui)
        self._tabs(ui)
        self._ask_to_close(ui)
        self.fields = {
            path: field for path, field in self.fields.items() if any(d.path == path for d in code.documents)
        }

    def _tabs(self, ui: Ui) -> None:
        code = ui.session.code
        flags = imgui.TabBarFlags_.reorderable | imgui.TabBarFlags_.fitting_policy_scroll
        if not imgui.begin_tab_bar("documents", flags):
            return
        wrong = {p.file for p in ui.session.shaders.problems}
        for document in list(code.documents):
            forward = code.raise_tab and document is code.front
            item = imgui.TabItemFlags_.set_selected if forward else 0
            if document.dirty:
                item |= imgui.TabItemFlags_.unsaved_document
            mark = f"{icons.ERROR} " if any(_same(document.path, file) for file in wrong) else ""
            lock = f"{icons.LOCK} " if document.read_only else ""
            shown, stays = imgui.begin_tab_item(f"{mark}{lock}{document.name}###{document.path}", True, item)
            tooltip(str(document.path))
            if shown:
                if not code.raise_tab:
                    code.front = document
                if code.front is document:
                    self._document(ui, document)
                imgui.end_tab_item()
            if stays is False:
                self._close(ui, document)
        code.raise_tab = False
        imgui.end_tab_bar()

    @staticmethod
    def _asks_to_find() -> bool:
        focused = bool(imgui.is_window_focused(imgui.FocusedFlags_.child_windows))
        return focused and bool(imgui.is_key_chord_pressed(imgui.Key.mod_ctrl | imgui.Key.f))

    def _document(self, ui: Ui, document: CodeDocument) -> None:
        code = ui.session.code
        draw_bars(ui, document)
        field = self.fields.get(document.path)
        if field is None:
            field = self.fields[document.path] = CodeField(document)
        field.mark([p for p in ui.session.shaders.problems if p.is_in(document.path)], ui.session.shaders.problems)
        if code.cursor is not None:
            field.go_to(*code.cursor)
            code.cursor = None
        if code.find:
            code.find = False
            self.finder.open(field)
        self.finder.draw(field)
        with mono(ui):
            field.draw(ui, (0.0, -em(1.5)))
        field.draw_status(ui)

    def _close(self, ui: Ui, document: CodeDocument) -> None:
        if document.dirty:
            self.closing = document
        else:
            ui.session.code.close(document)

    def _ask_to_close(self, ui: Ui) -> None:
        document = self.closing
        if document is None:
            return
        if not imgui.is_popup_open("Unsaved text"):
            imgui.open_popup("Unsaved text")
        if imgui.begin_popup_modal("Unsaved text", None, imgui.WindowFlags_.always_auto_resize)[0]:
            imgui.text_unformatted(f"{document.name} has unsaved changes.")
            imgui.spacing()
            for label in ("Save", "Discard", "Cancel"):
                if imgui.button(label, (em(7), 0)):
                    self._answer(ui, document, label)
                    imgui.close_current_popup()
                imgui.same_line()
            imgui.end_popup()

    def _answer(self, ui: Ui, document: CodeDocument, answer: str) -> None:
        self.closing = None
        code = ui.session.code
        if answer == "Save":
            code.front = document
            ui.session.save_code()
        if answer == "Discard" or (answer == "Save" and not document.dirty):
            code.close(document)


def _same(path: Path, file: str) -> bool:
    return bool(file) and Path(file).name == path.name and Path(file).resolve() == path


PANEL = ShaderEditorPanel
