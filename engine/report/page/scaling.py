"""The figure of growth: what each method costs as the problem grows, log-log, with the sizes where lines cross."""

from __future__ import annotations

from engine.report.page.svg import COLORS, Figure, figure, marker
from engine.report.page.text import escape, milliseconds, scientific
from engine.report.records import Chart

_DASHES = ("", "6 3", "2 3", "9 3 2 3")


def scaling(chart: Chart) -> str:
    """A line for each method with bars from quartile to quartile; "" where nothing was measured."""
    points = [point for line in chart.lines for point in line.points]
    if not points:
        return ""
    names = [line.name for line in chart.lines]
    entries = [(_sample(i), name) for i, name in enumerate(names)]
    fig = figure(chart.title, [p.x for p in points], [v for p in points for v in (p.low, p.high)], names)
    fig.frame(chart.x_label, chart.y_label)
    for i, mark in enumerate(chart.marks):
        _mark(fig, mark.x, mark.y, mark.text, i)
    for i, line in enumerate(chart.lines):
        css = f"c{i % COLORS}"
        fig.polyline([(p.x, p.y) for p in line.points], f"line {css}", _DASHES[i % len(_DASHES)])
        for p in line.points:
            x = fig.x(p.x)
            fig.add(f'<path class="bar {css}" d="M{x:.1f} {fig.y(p.low):.1f}V{fig.y(p.high):.1f}"/>')
            tip = f"{line.name}: {milliseconds(p.y)} at {p.x:,g} ({milliseconds(p.low)} to {milliseconds(p.high)})"
            fig.add(marker(i, x, fig.y(p.y), f"dot on {css}", 3.5, tip))
    fig.legend(entries)
    return fig.render()


def _sample(i: int) -> str:
    css = f"c{i % COLORS}"
    dash = f' stroke-dasharray="{_DASHES[i % len(_DASHES)]}"' if i % len(_DASHES) else ""
    return f'<path class="line {css}" d="M-10 0H10"{dash}/>' + marker(i, 0, 0, f"dot on {css}", 4.0)


def _mark(fig: Figure, x: float, y: float, text: str, row: int) -> None:
    """A ring where the lines cross, a line down to the axis, and its words near the bottom, one row a mark."""
    at, bottom = fig.x(x), fig.y.start
    fig.add(f'<path class="slope" d="M{at:.1f} {fig.y(y):.1f}V{bottom}"/>')
    fig.add(f'<circle class="default" cx="{at:.1f}" cy="{fig.y(y):.1f}" r="8"/>')
    words = f"N* = {scientific(x)}: {text}"
    room = 5.4 * len(words)
    right = at + 6 + room < fig.x.stop
    where = f'x="{at + 6 if right else at - 6:.1f}" y="{bottom - 10 - 14 * row:.1f}"'
    fig.add(f'<text class="note" {where} text-anchor="{"start" if right else "end"}">{escape(words)}</text>')
