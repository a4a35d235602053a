"""History: every edit since the document was opened; a click goes there. What was undone stands below, greyed."""

from __future__ import annotations

from typing import ClassVar

from imgui_bundle import imgui

from editor import icons, theme
from editor.commands.command import Edit
from editor.panels.base import Panel
from editor.ui import Ui
from editor.widgets import em, empty_state, fitted, text, tooltip


class HistoryPanel(Panel):
    title: ClassVar[str] = "History"
    icon: ClassVar[str] = icons.HISTORY
    dock: ClassVar[str] = "LeftBottom"

    def __init__(self) -> None:
        self._shown = -1

    def draw(self, ui: Ui) -> None:
        document = ui.session.document
        if document is None:
            empty_state(icons.HISTORY, "No edits yet")
            return
        history = document.history
        labels = ["Opened", *(entry.describe() for entry in (*history.entries, *history.undone))]
        entries: list[Edit | None] = [None, *history.entries, *history.undone]
        now = len(history.entries)
        imgui.begin_child("entries")
        clipper = imgui.ListClipper()
        clipper.begin(len(labels))
        follow = now != self._shown
        if follow:
            clipper.include_item_by_index(now)
        wanted = -1
        while clipper.step():
            for i in range(clipper.display_start, clipper.display_end):
                if self._row(labels[i], entries[i], i, now, history.saved_at):
                    wanted = i
                if follow and i == now:
                    imgui.set_scroll_here_y(0.5)
        self._shown = now
        imgui.end_child()
        if wanted >= 0:
            history.go_to(wanted)

    def _row(self, label: str, entry: Edit | None, index: int, now: int, saved: int | None) -> bool:
        """One line; True when it was clicked."""
        start = imgui.get_cursor_screen_pos()
        clicked = bool(imgui.selectable(f"##entry{index}", index == now, 0, (0, imgui.get_frame_height() * 0.92))[0])
        if entry is not None:
            tooltip(f"{index}. {label}\nin {entry.target[0]} {entry.target[1]}".rstrip())
        lines = imgui.get_window_draw_list()
        middle = start.y + imgui.get_frame_height() * 0.46
        color = theme.ACCENT if index == now else theme.DIM if index < now else theme.FAINT
        x = start.x + em(0.6)
        if index:  # the thread from edit to edit
            lines.add_line((x, start.y - em(0.3)), (x, middle - em(0.25)), theme.u32(theme.FAINT), 1.0)
        lines.add_circle_filled((x, middle), em(0.24 if index == now else 0.17), theme.u32(color))
        imgui.same_line(em(1.5))
        imgui.align_text_to_frame_padding()
        tag = "  saved" if saved == index else ""
        room = imgui.get_content_region_avail().x - imgui.calc_text_size(tag).x
        text(fitted(label, room), theme.TEXT if index == now else theme.DIM if index < now else theme.FAINT)
        if tag:
            imgui.same_line(0, 0)
            text(tag, theme.GOOD)
        return clicked


PANEL = HistoryPanel
