"""Log: what was found while importing and what happened since; filtered by severity and text, copied as text."""

from __future__ import annotations

from typing import ClassVar

from imgui_bundle import imgui

from editor import icons, theme
from editor.flowing import button_width
from editor.log_links import follow, link_of
from editor.messages import Message
from editor.panels.base import Panel
from editor.ui import Ui
from editor.widgets import em, flow, icon_button, mono, own_text, text, tooltip
from engine.core.findings import Severity

LOOKS = {
    Severity.ERROR: (icons.ERROR, "ERROR", "errors"),
    Severity.WARNING: (icons.WARNING, "WARNING", "warnings"),
    Severity.INFO: (icons.INFO, "INFO", "messages"),
}


def filtered(messages: list[Message], shown: set[Severity], needle: str) -> list[Message]:
    """Messages of a severity in `shown` that hold `needle` anywhere, ignoring case."""
    needle = needle.lower().strip()
    return [m for m in messages if m.severity in shown and (not needle or needle in m.line().lower())]


class LogPanel(Panel):
    title: ClassVar[str] = "Log"
    icon: ClassVar[str] = icons.LOG
    dock: ClassVar[str] = "Bottom"

    def __init__(self) -> None:
        self.shown = set(Severity)
        self.needle = ""
        self._key: object = None
        self._rows: list[Message] = []

    def draw(self, ui: Ui) -> None:
        messages = ui.session.messages
        counts = messages.counts()
        for place, (severity, (icon, color, name)) in enumerate(LOOKS.items()):
            if place:
                flow(button_width(f"{icon} {counts[severity]}"), 0.3)
            on = severity in self.shown
            imgui.push_style_color(
                imgui.Col_.text, imgui.ImVec4(*(theme.named(color) if on and counts[severity] else theme.FAINT))
            )
            imgui.push_style_color(imgui.Col_.button, imgui.ImVec4(*(theme.RAISED if on else theme.PANEL)))
            if imgui.button(f"{icon} {counts[severity]}###{name}"):
                self.shown.symmetric_difference_update({severity})
            imgui.pop_style_color(2)
            tooltip(f"Show {name}")
        flow(em(11.2), 0.3)
        imgui.set_next_item_width(-em(5.2))
        _changed, self.needle = imgui.input_text_with_hint("##filter", f"{icons.SEARCH}  Filter", self.needle)
        key = (messages.revision, frozenset(self.shown), self.needle)
        grown = key != self._key
        if grown:
            self._key, self._rows = key, filtered(messages.snapshot(), self.shown, self.needle)
        imgui.same_line(0, em(0.3))
        if icon_button(f"{icons.COPY}##copy", "Copy what is shown", enabled=bool(self._rows)):
            imgui.set_clipboard_text("\n".join(m.line() for m in self._rows))
        imgui.same_line(0, em(0.1))
        if icon_button(f"{icons.TRASH}##clear", "Clear the log", enabled=bool(self._rows)):
            messages.clear()
        imgui.begin_child("rows", (0, 0), 0, imgui.WindowFlags_.horizontal_scrollbar)
        with mono(ui):
            clipper = imgui.ListClipper()
            clipper.begin(len(self._rows))
            while clipper.step():
                for i in range(clipper.display_start, clipper.display_end):
                    self._row(ui, i)
        if grown:
            imgui.set_scroll_here_y(1.0)
        imgui.end_child()

    def _row(self, ui: Ui, index: int) -> None:
        message = self._rows[index]
        icon, color, _name = LOOKS[message.severity]
        start = imgui.get_cursor_pos_x()
        imgui.selectable(f"##row{index}", False, imgui.SelectableFlags_.allow_overlap)
        tooltip(message.line())
        if imgui.begin_popup_context_item(f"##menu{index}"):
            if imgui.menu_item_simple("Copy line"):
                imgui.set_clipboard_text(message.line())
            imgui.end_popup()
        imgui.same_line(start)
        text(message.clock, theme.FAINT)
        imgui.same_line(0, em(0.6))
        text(icon, theme.named(color))
        imgui.same_line(0, em(0.5))
        text(message.text, theme.TEXT)
        if message.where:
            imgui.same_line(0, em(0.6))
            self._place(ui, message.where)
        if message.hint:
            imgui.same_line(0, em(0.6))
            text(f"→ {message.hint}", theme.INFO)

    def _place(self, ui: Ui, where: str) -> None:
        """Where it is; a click goes there where there is something to show."""
        link = link_of(where, ui.session)
        own_text(where, theme.DIM if link is None else theme.INFO)
        if link is None:
            return
        if imgui.is_item_hovered():
            imgui.set_mouse_cursor(imgui.MouseCursor_.hand)
            low, high = imgui.get_item_rect_min(), imgui.get_item_rect_max()
            imgui.get_window_draw_list().add_line((low.x, high.y), (high.x, high.y), theme.u32(theme.INFO))
        tooltip("A click shows it")
        if imgui.is_item_clicked():
            follow(link, ui.session)


PANEL = LogPanel
