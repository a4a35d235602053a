"""The diagram of error over time as arrays to plot: one series a curve, the front, what is current. No imgui.

Both axes are logarithmic, so an error of 0 is drawn a decade below the least error there is, and said to be 0.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from engine.report.records import Point

F8 = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Series:
    """A curve: x ms, y error, `low` and `high` ms below and above the median to the quartiles; `points` likewise."""

    name: str
    x: F8
    y: F8
    low: F8
    high: F8
    points: tuple[Point, ...]


@dataclass(frozen=True, slots=True)
class Diagram:
    """`front`: x, y of the points that nothing beats, by time. `current`: where the present setting is, or None.
    `zero`: the height at which errors of 0 stand, 0 where there is none. `limits`: x and y from, to."""

    series: tuple[Series, ...] = ()
    front: tuple[F8, F8] = field(default_factory=lambda: (np.zeros(0), np.zeros(0)))
    current: tuple[float, float] | None = None
    zero: float = 0.0
    limits: tuple[float, float, float, float] = (0.1, 10.0, 1e-3, 1.0)

    @property
    def empty(self) -> bool:
        return not self.series


def diagram(
    points: Sequence[Point], metric: str, is_current: Callable[[Point], bool], floors: Sequence[float] = ()
) -> Diagram:
    """The diagram of the points that have a time and a finite error."""
    shown = [
        p for p in points
        if p.ms is not None and p.ms.median > 0.0 and math.isfinite(p.error.get(metric, math.nan))
    ]  # fmt: skip
    if not shown:
        return Diagram()
    positive = [abs(p.error[metric]) for p in shown if p.error[metric] != 0.0]
    zero = min(positive, default=1.0) / 10.0 if len(positive) < len(shown) else 0.0
    height = {id(p): abs(p.error[metric]) or zero for p in shown}
    series = []
    for name in dict.fromkeys(p.curve for p in shown):
        mine = sorted((p for p in shown if p.curve == name), key=_time)
        x = np.array([_time(p) for p in mine])
        quartiles = np.array([(p.ms.low or _time(p), p.ms.high or _time(p)) for p in mine if p.ms is not None])
        series.append(
            Series(
                name, x, np.array([height[id(p)] for p in mine]), np.maximum(x - quartiles[:, 0], 0.0),
                np.maximum(quartiles[:, 1] - x, 0.0), tuple(mine),
            )
        )  # fmt: skip
    front = sorted((p for p in shown if p.front), key=_time)
    now = next((p for p in shown if is_current(p)), None)
    least = min(height.values())  # a floor far below would squeeze the points into a line
    every_x, every_y = [_time(p) for p in shown], [*height.values(), *(f for f in floors if f > least / 5.0)]
    return Diagram(
        tuple(series),
        (np.array([_time(p) for p in front]), np.array([height[id(p)] for p in front])),
        None if now is None else (_time(now), height[id(now)]),
        zero,
        (*_padded(every_x), *_padded(every_y)),
    )


def nearest(shown: Diagram, place: Callable[[float, float], tuple[float, float]], at: tuple[float, float],
            reach: float) -> Point | None:  # fmt: skip
    """The point whose place on the screen is next to `at`, within `reach`."""
    best, found = reach, None
    for series in shown.series:
        for x, y, point in zip(series.x, series.y, series.points, strict=True):
            px, py = place(float(x), float(y))
            away = math.hypot(px - at[0], py - at[1])
            if away < best:
                best, found = away, point
    return found


def ticks(low: float, high: float) -> list[float]:
    """Round numbers from `low` to `high`: powers of ten, over less than three decades 2 and 5 times them too, over less
    than one some between."""
    fine = (1.0, 1.2, 1.5, 2.0, 3.0, 5.0, 7.0)
    steps = (1.0,) if high > 1e3 * low else (1.0, 2.0, 5.0) if high > 8.0 * low else fine
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    return [m * 10.0**e for e in range(first, last + 1) for m in steps if low <= m * 10.0**e <= high]


def _time(point: Point) -> float:
    assert point.ms is not None
    return point.ms.median


def _padded(values: Sequence[float]) -> tuple[float, float]:
    """A range in which all values stand off the border: a tenth of the decades more, at least a fifth of one."""
    low, high = math.log10(min(values)), math.log10(max(values))
    room = max(0.12 * (high - low), 0.2)
    return 10.0 ** (low - room), 10.0 ** (high + room)
