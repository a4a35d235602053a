"""Timings: what the last frame cost, pass by pass, with the remainder shown, and what was left out and why."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from imgui_bundle import imgui

from editor import icons, theme
from editor.panels.base import Panel
from editor.ui import Ui
from editor.widgets import em, empty_state, flow_text, mono, text, tooltip

UNACCOUNTED = "unaccounted"
#: counters worth a place in the head line, in order
HEADLINE = ("draws", "triangles", "instances", "api_calls", "bytes_uploaded")


@dataclass(frozen=True, slots=True)
class TimeRow:
    """`share` of the frame, 0..1; `color`: index into theme.SERIES, -1 for the remainder."""

    name: str
    ms: float
    kind: str
    share: float
    color: int


def time_rows(stats: Any) -> list[TimeRow]:
    """The passes in order and, last, what no pass accounts for (never hidden, never negative)."""
    total = max(stats.total_ms, sum(p.ms for p in stats.passes), 1e-9)
    rows = [TimeRow(p.name, p.ms, p.kind, p.ms / total, i % len(theme.SERIES)) for i, p in enumerate(stats.passes)]
    rest = max(0.0, stats.total_ms - sum(p.ms for p in stats.passes))
    return [*rows, TimeRow(UNACCOUNTED, rest, "", rest / total, -1)]


def short_count(value: float) -> str:
    """1234567 -> `1.23 M`."""
    for limit, unit in ((1e9, " G"), (1e6, " M"), (1e4, " k")):
        if abs(value) >= limit:
            return f"{value / (1e3 if unit == ' k' else limit):.3g}{unit}"
    return f"{value:g}"


def asleep_line(counters: Mapping[str, float]) -> str:
    """`2 of 3 animations asleep`."""
    return f"{counters['animations_asleep']:g} of {counters['animations']:g} animations asleep"


class TimingsPanel(Panel):
    title: ClassVar[str] = "Timings"
    icon: ClassVar[str] = icons.TIMER
    dock: ClassVar[str] = "BottomRight"

    def draw(self, ui: Ui) -> None:
        frame = ui.session.image.frame
        if frame is None:
            empty_state(icons.TIMER, "No frame yet")
            return
        stats = frame.stats
        rows = time_rows(stats)
        text(f"{stats.total_ms:.2f} ms", theme.TEXT)
        tooltip("Of the last frame that was rendered; nothing is rendered while nothing changes")
        for name in HEADLINE:
            if name in stats.counters:
                flow_text(f"{short_count(stats.counters[name])} {name.replace('_', ' ')}", theme.DIM, gap=0.9)
        _bar(rows)
        if stats.counters.get("animations_asleep"):
            text(asleep_line(stats.counters), theme.DIM)
            tooltip("Not sampled: nothing that they move was in the last picture. Their time and markers go on")
        self._table(ui, rows)
        self._left_out(frame.graph)

    def _table(self, ui: Ui, rows: list[TimeRow]) -> None:
        flags = imgui.TableFlags_.row_bg | imgui.TableFlags_.no_saved_settings
        if not imgui.begin_table("passes", 4, flags):
            return
        fixed = imgui.TableColumnFlags_.width_fixed
        imgui.table_setup_column("Pass", imgui.TableColumnFlags_.width_stretch)
        imgui.table_setup_column("ms", fixed, em(4.4))
        imgui.table_setup_column("%", fixed, em(2.8))
        imgui.table_setup_column("Clock", fixed, em(2.2))
        for row in rows:
            imgui.table_next_row()
            imgui.table_next_column()
            text("■", _color(row))
            imgui.same_line(0, em(0.4))
            text(row.name, theme.DIM if row.color < 0 else theme.TEXT)
            with mono(ui):
                for value in (f"{row.ms:9.3f}", f"{row.share * 100:5.1f}"):
                    imgui.table_next_column()
                    imgui.text_unformatted(value)
            imgui.table_next_column()
            text(row.kind, theme.FAINT)
        imgui.end_table()

    def _left_out(self, graph: Any) -> None:
        left_out = list(getattr(graph, "left_out", ()))
        if not left_out:
            return
        imgui.spacing()
        imgui.separator_text(f"Left out ({len(left_out)})")
        for item in left_out:
            text(item.name, theme.DIM)
            imgui.same_line(0, em(0.6))
            text(str(item.reason), theme.FAINT)
            tooltip(f"{item.name}: {item.reason}\nsaved: {item.saved}")


def _color(row: TimeRow) -> theme.Rgba:
    return theme.FAINT if row.color < 0 else theme.SERIES[row.color]


def _bar(rows: list[TimeRow]) -> None:
    """All rows as one stacked bar over the width."""
    width, height = imgui.get_content_region_avail().x, em(0.8)
    start = imgui.get_cursor_screen_pos()
    lines = imgui.get_window_draw_list()
    x = start.x
    for row in rows:
        end = x + row.share * width
        if end - x >= 1.0:
            lines.add_rect_filled((x, start.y), (end - 1.0, start.y + height), theme.u32(_color(row)), 2)
        if imgui.is_mouse_hovering_rect((x, start.y), (end, start.y + height)) and imgui.is_window_hovered():
            imgui.set_tooltip(f"{row.name}  {row.ms:.3f} ms")
        x = end
    imgui.dummy((width, height))


PANEL = TimingsPanel
