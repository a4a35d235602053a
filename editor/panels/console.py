"""Console: Python with the editor's operations and tables at hand."""

from __future__ import annotations

from typing import Any, ClassVar

from imgui_bundle import imgui

from editor import icons, theme
from editor.console import Console
from editor.panels.base import Panel
from editor.ui import Ui
from editor.widgets import em, icon_button, mono, own_text, text

#: "did": what was done elsewhere in the window, as the line that does it here
COLORS = {"did": "FAINT", "in": "TEXT", "out": "DIM", "error": "ERROR"}


class ConsolePanel(Panel):
    title: ClassVar[str] = "Console"
    icon: ClassVar[str] = icons.CONSOLE
    dock: ClassVar[str] = "Bottom"

    def __init__(self) -> None:
        self.console: Console | None = None
        self._line = ""
        self._back = 0
        self._focus = False
        self._count = 0

    def draw(self, ui: Ui) -> None:
        if self.console is None:
            self.console = Console(ui.session, ui.operations)
        console = self.console
        console.follow()
        footer = imgui.get_frame_height_with_spacing()
        with mono(ui):
            if imgui.begin_child("lines", (0, -footer)):
                if not console.lines:
                    text('run("edit.duplicate")   edit("nodes", "translation", selection(), [(0, 1, 0)])', theme.FAINT)
                for line in console.lines:
                    imgui.push_text_wrap_pos(0.0)
                    own_text(f"> {line.text}" if line.kind == "in" else line.text, theme.named(COLORS[line.kind]))
                    imgui.pop_text_wrap_pos()
                if len(console.lines) != self._count:
                    self._count = len(console.lines)
                    imgui.set_scroll_here_y(1.0)
            imgui.end_child()
            text("…" if console.pending else ">", theme.ACCENT)
            imgui.same_line(0, em(0.4))
            imgui.set_next_item_width(-em(2.2))
            if self._focus:
                imgui.set_keyboard_focus_here()
                self._focus = False
            flags = (
                imgui.InputTextFlags_.enter_returns_true
                | imgui.InputTextFlags_.callback_history
                | imgui.InputTextFlags_.callback_completion
            )
            entered, self._line = imgui.input_text("##line", self._line, flags, self._callback)
        imgui.same_line(0, em(0.3))
        if icon_button(f"{icons.TRASH}##clear-console", "Clear"):
            console.clear()
        if entered:
            console.push(self._line)
            self._line, self._back, self._focus = "", 0, True

    def _callback(self, data: Any) -> int:
        """Up and down walk through what was entered; Tab completes."""
        console = self.console
        assert console is not None
        if data.event_flag == imgui.InputTextFlags_.callback_completion:
            before = data.buf[: data.cursor_pos]
            word = before[max(before.rfind(c) for c in " (,=[") + 1 :]
            found = console.complete(word)
            if found:
                further = _common(found)[len(word) :]
                data.insert_chars(data.cursor_pos, further)
                if len(found) > 1 and not further:
                    console.offer(found)
        elif data.event_flag == imgui.InputTextFlags_.callback_history and console.entered:
            step = 1 if data.event_key == imgui.Key.up_arrow else -1
            self._back = min(max(self._back + step, 0), len(console.entered))
            data.delete_chars(0, data.buf_text_len)
            if self._back:
                data.insert_chars(0, console.entered[-self._back])
        return 0


def _common(words: list[str]) -> str:
    """The longest start that all have."""
    first, last = min(words), max(words)
    length = next((i for i, (a, b) in enumerate(zip(first, last, strict=False)) if a != b), min(len(first), len(last)))
    return first[:length]


PANEL = ConsolePanel
