"""History: every edit since the document was opened, with the picture after it; a click goes there. What was undone
stands below, greyed."""

from __future__ import annotations

from typing import ClassVar

from imgui_bundle import imgui

from editor import history_operations, icons, theme
from editor.commands.command import Edit
from editor.document import Document
from editor.panels.base import Panel
from editor.ui import Ui
from editor.widgets import em, empty_state, fitted, text

#: em: a picture's width and height in its line; the larger one's width under the pointer; a panel narrower than that
#: shows pictures under the pointer only
WIDTH, HEIGHT, LARGE, NARROW = 3.0, 1.9, 17.0, 9.0
#: before the label: without pictures, with them
INDENT, BESIDE = 1.5, 1.5 + WIDTH + 0.5
_TIP = int(imgui.HoveredFlags_.for_tooltip) | int(imgui.HoveredFlags_.delay_short)


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
        entries: list[Edit | None] = [None, *history.entries, *history.undone]
        now = len(history.entries)
        pictures = ui.session.preferences.history_pictures and not ui.session.null_pictures
        inline = pictures and imgui.get_content_region_avail().x >= em(NARROW)
        imgui.begin_child("entries")
        clipper = imgui.ListClipper()
        clipper.begin(len(entries))
        follow = now != self._shown
        if follow:
            clipper.include_item_by_index(now)
        wanted = -1
        while clipper.step():
            for i in range(clipper.display_start, clipper.display_end):
                if self._row(ui, document, entries[i], i, pictures, inline):
                    wanted = i
                if follow and i == now:
                    imgui.set_scroll_here_y(0.5)
        self._shown = now
        imgui.end_child()
        if wanted >= 0:
            history_operations.go_to(ui.session, wanted)

    def _row(
        self, ui: Ui, document: Document, entry: Edit | None, index: int, pictures: bool, inline: bool
    ) -> bool:  # fmt: skip
        """One line, its picture in it where that is `inline`; True when it was clicked."""
        now, saved = len(document.history.entries), document.history.saved_at
        label = entry.describe() if entry is not None else "Opened"
        height = em(HEIGHT + 0.3) if inline else imgui.get_frame_height() * 0.92
        native, shape = ui.session.history_pictures.native(document, entry) if pictures else (0, 0.0)
        start = imgui.get_cursor_screen_pos()
        clicked = bool(imgui.selectable(f"##entry{index}", index == now, 0, (0, height))[0])
        self._about(entry, index, label, native, shape)
        lines = imgui.get_window_draw_list()
        middle = start.y + height / 2.0
        color = theme.ACCENT if index == now else theme.DIM if index < now else theme.FAINT
        x = start.x + em(0.6)
        if index:  # the thread from edit to edit
            lines.add_line((x, start.y - height / 2.0 + em(0.05)), (x, middle - em(0.25)), theme.u32(theme.FAINT), 1.0)
        lines.add_circle_filled((x, middle), em(0.24 if index == now else 0.17), theme.u32(color))
        if inline:
            _picture(lines, start.x + em(INDENT), middle, native, shape, index > now)
        imgui.same_line(em(BESIDE if inline else INDENT))
        y = imgui.get_cursor_pos_y() + max((height - imgui.get_text_line_height()) / 2.0, 0.0)
        imgui.set_cursor_pos_y(y)
        tag = "  saved" if saved == index and imgui.get_content_region_avail().x > em(6) else ""
        room = imgui.get_content_region_avail().x - imgui.calc_text_size(tag).x
        text(fitted(label, room), theme.TEXT if index == now else theme.DIM if index < now else theme.FAINT)
        if tag:
            imgui.same_line(0, 0)
            imgui.set_cursor_pos_y(y)
            text(tag, theme.GOOD)
        return clicked

    @staticmethod
    def _about(entry: Edit | None, index: int, label: str, native: int, shape: float) -> None:
        """For the line before: the picture larger, and what the edit is of."""
        if entry is None and not native:
            return
        if not imgui.is_item_hovered(_TIP):
            return
        imgui.begin_tooltip()
        if native:
            imgui.image(imgui.ImTextureRef(native), (em(LARGE), em(LARGE) * shape))
        imgui.push_text_wrap_pos(em(24))
        imgui.text_unformatted(f"{index}. {label}" if entry is not None else label)
        if entry is not None:
            text(f"in {entry.target[0]} {entry.target[1]}".rstrip(), theme.DIM)
        imgui.pop_text_wrap_pos()
        imgui.end_tooltip()


def _picture(lines: imgui.ImDrawList, x: float, middle: float, native: int, shape: float, undone: bool) -> None:
    """The picture of a line, or the frame where one would be."""
    width, height = em(WIDTH), em(HEIGHT)
    if not native:
        low, high = (x, middle - height / 2.0), (x + width, middle + height / 2.0)
        lines.add_rect(low, high, theme.u32((*theme.FAINT[:3], 0.35)), em(0.2))
        return
    if shape * width <= height:
        height = shape * width
    else:
        width = height / shape
    x += (em(WIDTH) - width) / 2.0
    tint = 0x66FFFFFF if undone else 0xFFFFFFFF
    low, high = (x, middle - height / 2.0), (x + width, middle + height / 2.0)
    lines.add_image_rounded(imgui.ImTextureRef(native), low, high, (0, 0), (1, 1), tint, em(0.2))


PANEL = HistoryPanel
