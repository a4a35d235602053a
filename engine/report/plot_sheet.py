"""Plots side by side as a picture: curves over an axis, and polar slices above a horizon. Pillow, no window."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

F8 = NDArray[np.float64]

INK, FAINT, GRID, PAPER = (32, 34, 38), (120, 124, 130), (222, 224, 228), (252, 252, 252)
COLORS = ((47, 111, 176), (214, 134, 30), (70, 150, 80), (160, 80, 180), (200, 70, 55), (40, 150, 145))
_OVER = 2  # drawn so many times as large, then brought down: smooth lines


@dataclass(frozen=True, slots=True)
class Plot:
    """`curves`: (name, x, y); of a polar plot angle from the vertical (radians) and radius in [0, 1]. `marks`: y values
    that get a line of their own."""

    title: str
    curves: Sequence[tuple[str, F8, F8]]
    x_label: str = ""
    polar: bool = False
    logarithmic: bool = False
    low: float | None = None
    high: float | None = None
    marks: Sequence[float] = ()
    lines: Sequence[str] = field(default_factory=tuple)


def draw_sheet(
    title: str, plots: Sequence[Plot], *, columns: int = 2, cell: tuple[int, int] = (460, 320)
) -> NDArray[np.uint8]:
    """u1[h,w,3] of all plots under a heading."""
    from PIL import Image, ImageDraw, ImageFont

    rows = -(-len(plots) // columns)
    width, height = columns * cell[0] + 24, rows * cell[1] + 60
    image = Image.new("RGB", (width * _OVER, height * _OVER), PAPER)
    draw = ImageDraw.Draw(image)
    fonts = [ImageFont.load_default(size * _OVER) for size in (12, 15, 19)]
    draw.text((20 * _OVER, 14 * _OVER), title, INK, fonts[2])
    for i, plot in enumerate(plots):
        x, y = 12 + i % columns * cell[0], 48 + i // columns * cell[1]
        _Cell(draw, fonts, [v * _OVER for v in (x + 54, y + 34, x + cell[0] - 18, y + cell[1] - 44)]).plot(plot)
    return np.asarray(image.resize((width, height), Image.Resampling.BOX))


class _Cell:
    def __init__(self, draw: Any, fonts: list[Any], box: list[int]) -> None:
        self.draw, self.fonts, self.box = draw, fonts, box

    def plot(self, plot: Plot) -> None:
        left, top, _, _ = self.box
        self.draw.text((left - 40 * _OVER, top - 27 * _OVER), plot.title, INK, self.fonts[1])
        (self._polar if plot.polar else self._curves)(plot)

    def _polar(self, plot: Plot) -> None:
        left, top, right, bottom = self.box
        center = ((left + right) / 2, bottom - 6 * _OVER)
        size = min((right - left) / 2 - 30 * _OVER, bottom - top - 40 * _OVER)
        for part in (0.25, 0.5, 0.75, 1.0):
            r = size * part
            box = (center[0] - r, center[1] - r, center[0] + r, center[1] + r)
            self.draw.arc(box, 180, 360, GRID, _OVER)
        for degrees in range(-90, 91, 30):
            a = math.radians(degrees)
            at = (center[0] + size * math.sin(a), center[1] - size * math.cos(a))
            self.draw.line([center, at], GRID, _OVER)
            edge = (center[0] + 1.07 * size * math.sin(a), center[1] - 1.07 * size * math.cos(a))
            self.draw.text(edge, f"{abs(degrees)}°", FAINT, self.fonts[0], anchor="mm")
        for i, (_, angle, radius) in enumerate(plot.curves):
            points = np.stack(
                [center[0] + size * radius * np.sin(angle), center[1] - size * radius * np.cos(angle)], -1
            )
            self.draw.line([tuple(p) for p in points], COLORS[i % len(COLORS)], 2 * _OVER, joint="curve")
        for mark in plot.marks:  # the light comes from there
            tip = (center[0] + size * math.sin(mark), center[1] - size * math.cos(mark))
            self.draw.line([tip, center], INK, _OVER)
        self._legend(plot, bottom + 8 * _OVER)

    def _curves(self, plot: Plot) -> None:
        left, top, right, bottom = self.box
        x = np.concatenate([c[1] for c in plot.curves])
        y = np.concatenate([c[2] for c in plot.curves])
        scale = (lambda v: np.log10(np.maximum(v, 1e-12))) if plot.logarithmic else np.asarray
        high = plot.high if plot.high is not None else float(y.max())
        low = (
            plot.low
            if plot.low is not None
            else (max(high * 1e-5, 0.5 * float(y.min())) if plot.logarithmic else min(0.0, float(y.min())))
        )
        y0, y1 = float(scale(low)), float(scale(max(high, low + 1e-9)))
        x0, x1 = float(x.min()), float(x.max())

        def at(u: Any, v: Any) -> Any:
            return (
                left + (np.asarray(u) - x0) / (x1 - x0) * (right - left),
                bottom - np.clip((scale(v) - y0) / (y1 - y0), -0.02, 1.02) * (bottom - top),
            )

        for tick in _ticks(x0, x1):
            px = float(at(tick, low)[0])
            self.draw.line([(px, top), (px, bottom)], GRID, _OVER)
            self.draw.text((px, bottom + 4 * _OVER), f"{tick:.0f}", FAINT, self.fonts[0], anchor="mt")
        values = 10.0 ** np.arange(math.ceil(y0), y1 + 1e-9) if plot.logarithmic else _ticks(low, high)
        for tick in values:
            py = float(at(x0, tick)[1])
            self.draw.line([(left, py), (right, py)], GRID, _OVER)
            self.draw.text((left - 5 * _OVER, py), f"{tick:.3g}", FAINT, self.fonts[0], anchor="rm")
        for mark in plot.marks:
            py = float(at(x0, mark)[1])
            self.draw.line([(left, py), (right, py)], INK, _OVER)
        self.draw.rectangle((left, top, right, bottom), outline=FAINT, width=_OVER)
        for i, (_, u, v) in enumerate(plot.curves):
            px, py = at(u, v)
            self.draw.line(
                list(zip(px.tolist(), py.tolist(), strict=True)), COLORS[i % len(COLORS)], 2 * _OVER, joint="curve"
            )
        self._legend(plot, bottom + 20 * _OVER)

    def _legend(self, plot: Plot, y: float) -> None:
        x = float(self.box[0])
        for i, (name, _, _) in enumerate(plot.curves if len(plot.curves) > 1 else ()):
            self.draw.line([(x, y + 8 * _OVER), (x + 14 * _OVER, y + 8 * _OVER)], COLORS[i % len(COLORS)], 3 * _OVER)
            self.draw.text((x + 18 * _OVER, y), name, INK, self.fonts[0])
            x += 26 * _OVER + self.draw.textlength(name, self.fonts[0])
        self.draw.text((self.box[2], y), plot.x_label, FAINT, self.fonts[0], anchor="ra")


def _ticks(low: float, high: float) -> list[float]:
    """Five or so round numbers between."""
    span = max(high - low, 1e-9)
    step = 10.0 ** math.floor(math.log10(span))
    step *= next(f for f in (0.1, 0.2, 0.5, 1.0, 2.0) if span / (step * f) <= 6.0)
    first = math.ceil(low / step - 1e-9)
    return [i * step for i in range(first, math.floor(high / step + 1e-9) + 1)]
