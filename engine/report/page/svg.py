"""SVG by hand: the frame of a figure, markers, lines, text that does not collide."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from engine.report.page.axes import LogAxis
from engine.report.page.text import escape

WIDTH, HEIGHT = 560, 400
LEFT, RIGHT, TOP, BOTTOM = 66, 14, 40, 52
#: how many line colours the style sheet has; then they repeat
COLORS = 7


@dataclass(slots=True)
class Figure:
    """Collects elements; `boxes` are the places already taken by text."""

    x: LogAxis
    y: LogAxis
    title: str
    parts: list[str] = field(default_factory=list)
    boxes: list[tuple[float, float, float, float]] = field(default_factory=list)

    def add(self, text: str) -> None:
        self.parts.append(text)

    def frame(self, x_label: str, y_label: str) -> None:
        """Grid, ticks and axis titles."""
        left, right, top, bottom = self.x.start, self.x.stop, self.y.stop, self.y.start
        self.add(f'<rect class="plot" x="{left}" y="{top}" width="{right - left:.1f}" height="{bottom - top:.1f}"/>')
        for value, label in self.x.ticks():
            at = self.x(value)
            self.add(f'<path class="grid" d="M{at:.1f} {top}V{bottom}"/>')
            self.add(f'<text class="tick" x="{at:.1f}" y="{bottom + 17}" text-anchor="middle">{label}</text>')
        for value, label in self.y.ticks():
            at = self.y(value)
            self.add(f'<path class="grid" d="M{left} {at:.1f}H{right}"/>')
            self.add(f'<text class="tick" x="{left - 8}" y="{at + 4:.1f}" text-anchor="end">{label}</text>')
        small = "".join(f"M{self.x(v):.1f} {bottom}v-4" for v in self.x.minor())
        small += "".join(f"M{left} {self.y(v):.1f}h4" for v in self.y.minor())
        self.add(f'<path class="axis" d="M{left} {top}V{bottom}H{right}{small}"/>')
        middle = (left + right) / 2
        self.add(
            f'<text class="label" x="{middle:.0f}" y="{HEIGHT - 10}" text-anchor="middle">{escape(x_label)}</text>'
        )
        self.add(
            f'<text class="label" transform="translate(15 {(top + bottom) / 2:.0f}) rotate(-90)"'
            f' text-anchor="middle">{escape(y_label)}</text>'
        )

    def polyline(self, points: Sequence[tuple[float, float]], css: str, dash: str = "") -> None:
        """A line through values; those that are no number break it."""
        path, pen = "", "M"
        for px, py in points:
            if not (px > 0.0 and py > 0.0 and math.isfinite(px) and math.isfinite(py)):
                pen = "M"
                continue
            path += f"{pen}{self.x(px):.1f} {self.y(py):.1f}"
            pen = "L"
        if path:
            extra = f' stroke-dasharray="{dash}"' if dash else ""
            self.add(f'<path class="{css}" d="{path}"{extra}/>')

    def take(self, x: float, y: float, width: float, height: float) -> bool:
        """Claim a box in pixels; False if it leaves the plot or meets another."""
        inside = self.x.start <= x and x + width <= self.x.stop and self.y.stop <= y and y + height <= self.y.start
        free = all(x + width < bx or bx + bw < x or y + height < by or by + bh < y for bx, by, bw, bh in self.boxes)
        if inside and free:
            self.boxes.append((x, y, width, height))
        return inside and free

    def reserve(self, x: float, y: float, size: float) -> None:
        """Keep text away from a marker."""
        self.boxes.append((x - size, y - size, 2 * size, 2 * size))

    def note(self, x: float, y: float, text: str, css: str = "note", *, left: bool = False) -> bool:
        """A small text beside (x, y) in pixels, where there is room (`left`: rather on that side); else none."""
        width = 5.4 * len(text)
        places = [(8, -5), (8, 11), (-8 - width, -5), (-8 - width, 11), (-width / 2, -11), (-width / 2, 19)]
        if left:
            places = [*places[2:], *places[:2]]
        for dx, dy in places:
            if self.take(x + dx, y + dy - 8, width, 10):
                self.add(f'<text class="{css}" x="{x + dx:.1f}" y="{y + dy:.1f}">{escape(text)}</text>')
                return True
        return False

    def legend(self, entries: Sequence[tuple[str, str]]) -> None:
        """(SVG of a sample centred on 0 0, name), in rows above the plot."""
        x, y = float(LEFT), 12.0
        for sample, name in entries:
            width = 24 + 6.3 * len(name) + 14
            if x + width > WIDTH - RIGHT and x > LEFT:
                x, y = float(LEFT), y + 16.0
            self.add(f'<g transform="translate({x + 8:.1f} {y:.1f})">{sample}</g>')
            self.add(f'<text class="legend" x="{x + 22:.1f}" y="{y + 4:.1f}">{escape(name)}</text>')
            x += width

    def render(self) -> str:
        body = "\n".join(self.parts)
        return (
            f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="{escape(self.title)}">'
            f"<title>{escape(self.title)}</title>\n{body}\n</svg>"
        )


def figure(
    title: str, xs: Sequence[float], ys: Sequence[float], legend_names: Sequence[str], *, nan_row: bool = False
) -> Figure:
    """An empty figure with room for these values and for a legend of those names."""
    top = TOP + 16 * (_legend_rows(legend_names) - 1) + (14 if nan_row else 0)
    x = LogAxis.around(xs, LEFT, WIDTH - RIGHT)
    y = LogAxis.around(ys, HEIGHT - BOTTOM, top)
    return Figure(x, y, title)


def marker(shape: int, x: float, y: float, css: str, size: float = 5.0, tip: str = "") -> str:
    """One of seven shapes, centred."""
    s = size
    kind = shape % COLORS
    polygons = {
        1: [(-s, -s), (s, -s), (s, s), (-s, s)],
        2: [(0, -1.25 * s), (1.15 * s, 0.8 * s), (-1.15 * s, 0.8 * s)],
        3: [(0, -1.35 * s), (1.35 * s, 0), (0, 1.35 * s), (-1.35 * s, 0)],
        4: [(0, 1.25 * s), (1.15 * s, -0.8 * s), (-1.15 * s, -0.8 * s)],
        5: [(1.2 * s * math.cos(a), 1.2 * s * math.sin(a)) for a in (math.pi / 6 + i * math.pi / 3 for i in range(6))],
        6: [(-s, 0), (-s / 2, -s), (s / 2, -s), (s, 0), (s / 2, s), (-s / 2, s)],
    }
    inner = f"<title>{escape(tip)}</title>" if tip else ""
    if kind == 0:
        return f'<circle class="{css}" cx="{x:.1f}" cy="{y:.1f}" r="{s}">{inner}</circle>'
    points = " ".join(f"{x + dx:.1f},{y + dy:.1f}" for dx, dy in polygons[kind])
    return f'<polygon class="{css}" points="{points}">{inner}</polygon>'


def _legend_rows(names: Sequence[str]) -> int:
    x, rows = float(LEFT), 1
    for name in names:
        width = 24 + 6.3 * len(name) + 14
        if x + width > WIDTH - RIGHT and x > LEFT:
            x, rows = float(LEFT), rows + 1
        x += width
    return rows
