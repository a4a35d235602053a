"""CodeField: the text field of a CodeDocument, with syntax colours, markers of problems, and completion."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from imgui_bundle import imgui
from imgui_bundle import imgui_color_text_edit as code_edit

from editor import theme
from editor.code.completion import completions, include_names
from editor.code.document import CodeDocument
from editor.code.problems import Problem
from editor.ui import Ui
from editor.widgets import em, fitted_text, text

TextEditor = code_edit.TextEditor
#: candidates shown at once
SHOWN = 12
#: candidates offered at most
MOST = 60


class CodeField:
    """Keeps the widget and the document in step: typing goes into the document, a text from outside into the widget."""

    def __init__(self, document: CodeDocument) -> None:
        self.document = document
        self.editor = TextEditor()
        self.editor.set_tab_size(4)
        self.editor.set_insert_spaces_on_tabs(True)
        self.editor.set_show_whitespaces_enabled(False)
        self.editor.set_palette(TextEditor.get_dark_palette())
        if document.language == "glsl":
            self.editor.set_language(TextEditor.Language.glsl())
        self.editor.set_text(document.text)
        self.editor.set_read_only_enabled(document.read_only)
        self._revision = document.revision
        self._undo_index = self.editor.get_undo_index()
        self._marked: object = None
        self._candidates: list[str] = []
        self._typed = ""
        self._choice = 0

    def go_to(self, line: int, column: int = 1) -> None:
        """Put the cursor at (line, column), from 1, and show it."""
        last = max(self.editor.get_line_count() - 1, 0)
        row = min(line - 1, last)
        column = min(column - 1, len(self.editor.get_line_text(row)))
        self.editor.set_cursor(TextEditor.DocPos(row, max(column, 0)))
        self.editor.scroll_to_line(row)
        self.editor.set_focus()

    def mark(self, problems: Sequence[Problem], key: object) -> None:
        """Show `problems` at their lines; done again when `key` or the text was replaced."""
        if (key, self._revision) == self._marked:
            return
        self._marked = (key, self._revision)
        self.editor.clear_markers()
        self.editor.clear_squiggles()
        by_line: dict[int, list[Problem]] = {}
        for problem in problems:
            if 1 <= problem.line <= self.editor.get_line_count():
                by_line.setdefault(problem.line, []).append(problem)
        color = theme.u32(theme.ERROR)
        for line, found in by_line.items():
            told = "\n\n".join(p.text for p in found)
            self.editor.add_marker(line - 1, color, theme.u32(theme.ERROR, 0.16), told, told)
            for problem in found:
                start, end = _word_at(self.editor.get_line_text(line - 1), problem.column)
                if end > start:
                    self.editor.add_squiggle(
                        TextEditor.DocPos(line - 1, start), TextEditor.DocPos(line - 1, end), 1, color, problem.text
                    )

    def draw(self, ui: Ui, size: tuple[float, float]) -> None:
        document, editor = self.document, self.editor
        if document.revision != self._revision:
            self._revision = document.revision
            self._replace_all(document.text)
        focused = bool(imgui.is_window_focused(imgui.FocusedFlags_.child_windows))
        wants = focused and imgui.is_key_chord_pressed(imgui.Key.mod_ctrl | imgui.Key.space)
        editor.render(f"##{document.path}", size)
        if editor.get_undo_index() != self._undo_index:
            self._undo_index = editor.get_undo_index()
            document.edit(editor.get_text())
        if wants:
            self._complete(ui)
        self._popup()

    def draw_status(self, ui: Ui) -> None:
        """Below the text: where the cursor is; what is wrong in its line."""
        position = self.editor.get_main_cursor_position()
        here = [p for p in ui.session.shaders.problems if p.line == position.line + 1 and p.is_in(self.document.path)]
        text(f"{position.line + 1}:{position.index + 1}", theme.FAINT)
        imgui.same_line(0, em(1))
        if here:
            fitted_text(here[0].message, theme.ERROR, more=here[0].detail)
        else:
            fitted_text(str(self.document.path), theme.FAINT)

    # --- completion ---

    def _complete(self, ui: Ui) -> None:
        position = self.editor.get_main_cursor_position()
        before = self.editor.get_line_text(position.line)[: position.index]
        effects, search = _known(ui)
        self._typed, self._candidates = completions(before, self.document.text, include_names(search), effects)
        if self._candidates and not self.document.read_only:
            self._choice = 0
            imgui.open_popup("complete")

    def _popup(self) -> None:
        if not imgui.is_popup_open("complete"):
            return
        at = self.editor.doc_pos2_screen_pos(self.editor.get_main_cursor_position())
        imgui.set_next_window_pos((at.x, at.y + self.editor.get_line_height()))
        imgui.set_next_window_size_constraints((em(12), 0), (em(26), em(1.6) * SHOWN))
        if not imgui.begin_popup("complete"):
            return
        shown = self._candidates[:MOST]
        moved = self._move_choice(len(shown))
        for index, name in enumerate(shown):
            if imgui.selectable(name, index == self._choice)[0]:
                self._insert(name)
            if moved and index == self._choice:
                imgui.set_scroll_here_y()
        if any(imgui.is_key_pressed(key, False) for key in (imgui.Key.enter, imgui.Key.keypad_enter, imgui.Key.tab)):
            self._insert(shown[self._choice])
            imgui.close_current_popup()
        imgui.end_popup()

    def _move_choice(self, count: int) -> bool:
        """Arrow keys move the choice, round and round; True when it moved."""
        step = int(imgui.is_key_pressed(imgui.Key.down_arrow)) - int(imgui.is_key_pressed(imgui.Key.up_arrow))
        self._choice = (self._choice + step) % count
        return step != 0

    def _insert(self, name: str) -> None:
        end = self.editor.get_main_cursor_position()
        start = TextEditor.DocPos(end.line, end.index - len(self._typed))
        self.editor.replace_section_text(start, end, name)
        self.editor.set_cursor(TextEditor.DocPos(end.line, start.index + len(name)))
        self.editor.set_focus()

    def _replace_all(self, new: str) -> None:
        """Another text in place of all of it, as one step of the field's own undo."""
        last = max(self.editor.get_line_count() - 1, 0)
        end = TextEditor.DocPos(last, len(self.editor.get_line_text(last)))
        cursor = self.editor.get_main_cursor_position()
        self.editor.set_read_only_enabled(False)
        self.editor.replace_section_text(TextEditor.DocPos(0, 0), end, new)
        self.editor.set_read_only_enabled(self.document.read_only)
        self.editor.set_cursor(TextEditor.DocPos(min(cursor.line, self.editor.get_line_count() - 1), 0))
        self._undo_index = self.editor.get_undo_index()


def _known(ui: Ui) -> tuple[list[Any], list[Any]]:
    """The effects of the open scene, and the folders with shaders."""
    document = ui.session.document
    residency = getattr(document.runtime, "residency", None) if document is not None else None
    library = getattr(residency, "effects", None)
    if residency is None or library is None:
        return [], []
    effects = {id(r.effect): r.effect for r in residency.materials.records}
    return list(effects.values()), list(library.search)


def _word_at(line: str, column: int) -> tuple[int, int]:
    """[start, end) of the word at `column` (from 1); the line's text without its indent where none is given."""
    if column < 1 or column > len(line):
        return len(line) - len(line.lstrip()), len(line.rstrip())
    start = end = column - 1
    while end < len(line) and (line[end].isalnum() or line[end] == "_"):
        end += 1
    return start, max(end, start + 1)
