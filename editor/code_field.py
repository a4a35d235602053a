"""CodeField: the text field of a CodeDocument, with syntax colours, markers of problems, and completion."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from imgui_bundle import imgui
from imgui_bundle import imgui_color_text_edit as code_edit

from editor import theme
from editor.code.completion import Candidate, candidates, include_names
from editor.code.document import CodeDocument
from editor.code.gestures import Gestures
from editor.code.problems import Problem
from editor.ui import Ui
from editor.widgets import cut, em, fitted_text, text, tooltip

TextEditor = code_edit.TextEditor
#: candidates shown at once
SHOWN = 12
#: candidates offered at most
MOST = 60


REDO = (imgui.Key.mod_ctrl | imgui.Key.y, imgui.Key.mod_ctrl | imgui.Key.mod_shift | imgui.Key.z)


class CodeField:
    """Keeps the widget and the document in step: typing goes into the document, a text from outside into the widget."""

    def __init__(self, document: CodeDocument) -> None:
        self.document = document
        self.editor = TextEditor()
        self.editor.set_tab_size(4)
        self.editor.set_insert_spaces_on_tabs(True)
        self.editor.set_show_whitespaces_enabled(False)
        self.editor.set_palette(TextEditor.get_dark_palette())
        self.editor.set_language(language_of(document))
        self.editor.set_find_replace_enabled(False)  # its own bar does not fit into a narrow panel
        self.editor.set_show_matching_brackets(True)
        self.editor.set_complete_paired_glyphs(False)
        self.editor.set_text(document.text)
        self.editor.set_read_only_enabled(document.read_only)
        self._revision = document.revision
        self._undo_index = self.editor.get_undo_index()
        self._gestures = Gestures(self._undo_index)
        self._line = -1
        self._marked: object = None
        self._candidates: list[Candidate] = []
        #: as they were when the list was opened
        self._all: list[Candidate] = []
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

    # --- what is selected: (line, column), from 0 ---

    def selected(self) -> str:
        """The selected text; '' for none."""
        return self.editor.get_cursor_text(0) if self.editor.main_cursor_has_selection() else ""

    def selection_start(self) -> tuple[int, int]:
        start = self.editor.get_main_cursor_selection().start
        return int(start.line), int(start.index)

    def selection_end(self) -> tuple[int, int]:
        end = self.editor.get_main_cursor_selection().end
        return int(end.line), int(end.index)

    def select(self, line: int, start: int, end: int) -> None:
        """Select part of a line and show it."""
        self.editor.select_region(TextEditor.DocPos(line, start), TextEditor.DocPos(line, end))
        self.editor.scroll_to_line(line)

    def replace_selection(self, new: str) -> None:
        """One step of the field's own undo."""
        line, start = self.selection_start()
        self.editor.replace_text_in_current_cursor(new)
        self.editor.set_cursor(TextEditor.DocPos(line, start + len(new)))
        self._take_typing()

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
        self._take_typing()
        if wants:
            self._complete(ui)
        self._popup()

    def _take_typing(self) -> None:
        """Bring what was typed into the document. What was undone or redone takes the rest of its step along."""
        before, editor = self._undo_index, self.editor
        index = editor.get_undo_index()
        if index == before:
            return
        line = editor.get_main_cursor_position().line
        if index < before:
            target = self._gestures.undone_to(index)
            while editor.get_undo_index() > target and editor.can_undo():
                editor.undo()
        elif any(imgui.is_key_chord_pressed(chord) for chord in REDO):
            target = self._gestures.redone_to(index)
            while editor.get_undo_index() < target and editor.can_redo():
                editor.redo()
        else:
            typing = index == before + 1 and line == self._line and imgui.get_io().input_queue_characters.size() > 0
            self._gestures.edited(before, index, imgui.get_time(), typing=typing)
        self._line = line
        self._undo_index = editor.get_undo_index()
        self.document.edit(editor.get_text())

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
        self._typed, self._candidates = candidates(
            before,
            self.document.text,
            position.line + 1,
            self.document.language,
            include_names(search),
            effects,
            search,
        )
        if self._candidates and not self.document.read_only:
            self._choice, self._all = 0, list(self._candidates)
            imgui.open_popup("complete")

    def _popup(self) -> None:
        if not imgui.is_popup_open("complete"):
            return
        at = self.editor.doc_pos2_screen_pos(self.editor.get_main_cursor_position())
        imgui.set_next_window_pos((at.x, at.y + self.editor.get_line_height()))
        imgui.set_next_window_size_constraints((em(16), 0), (em(40), em(1.6) * SHOWN))
        if not imgui.begin_popup("complete"):
            return
        self._narrow()
        shown = self._candidates[:MOST]
        if not shown:
            imgui.close_current_popup()
            imgui.end_popup()
            self.editor.set_focus()
            return
        moved = self._move_choice(len(shown))
        beside = max(imgui.calc_text_size(c.name).x for c in shown) + em(1)
        for index, candidate in enumerate(shown):
            if imgui.selectable(f"{candidate.name}##{index}", index == self._choice)[0]:
                self._insert(candidate.name)
            tooltip(candidate.doc)
            if candidate.about:
                imgui.same_line(beside)
                text(cut(candidate.about, em(22)), theme.FAINT)
            if moved and index == self._choice:
                imgui.set_scroll_here_y()
        chosen = shown[self._choice]
        if chosen.doc:
            imgui.separator()
            imgui.push_text_wrap_pos(em(36))
            text(chosen.doc, theme.DIM)
            imgui.pop_text_wrap_pos()
        if any(imgui.is_key_pressed(key, False) for key in (imgui.Key.enter, imgui.Key.keypad_enter, imgui.Key.tab)):
            self._insert(chosen.name)
            imgui.close_current_popup()
        imgui.end_popup()

    def _narrow(self) -> None:
        """What is typed while the list is open goes into the text and leaves fewer."""
        io = imgui.get_io()
        new = (
            "".join(chr(c) for c in io.input_queue_characters if c == 95 or chr(c).isalnum()) if not io.key_ctrl else ""
        )
        back = bool(imgui.is_key_pressed(imgui.Key.backspace)) and bool(self._typed)
        if not new and not back:
            return
        end = self.editor.get_main_cursor_position()
        if back:
            self.editor.replace_section_text(TextEditor.DocPos(end.line, end.index - 1), end, "")
            self._typed = self._typed[:-1]
            end = TextEditor.DocPos(end.line, end.index - 1)
        if new:
            self.editor.replace_section_text(end, end, new)
            self._typed += new
            end = TextEditor.DocPos(end.line, end.index + len(new))
        self.editor.set_cursor(end)
        lowered = self._typed.lower()
        pool = [c for c in self._candidates if lowered in c.name.lower()] if new else self._all
        found = [c for c in pool if lowered in c.name.lower()]
        self._candidates = sorted(found, key=lambda c: not c.name.lower().startswith(lowered))
        self._choice = 0

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
        before, self._undo_index = self._undo_index, self.editor.get_undo_index()
        self._gestures.edited(before, self._undo_index, 0.0, typing=False)


def language_of(document: CodeDocument) -> Any:
    """Whose words the widget colours. It knows no TOML: Python has the same comments, strings and numbers."""
    language = TextEditor.Language
    return {"glsl": language.glsl, "json": language.json, "markdown": language.markdown}.get(
        document.language, language.python
    )()


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
