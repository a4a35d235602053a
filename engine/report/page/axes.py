"""Logarithmic axes: from values to pixels, with ticks and grid."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from engine.report.page.text import power


@dataclass(frozen=True, slots=True)
class LogAxis:
    """Maps [low, high] to pixels [start, stop] by the logarithm."""

    low: float
    high: float
    start: float
    stop: float

    @classmethod
    def around(cls, values: Iterable[float], start: float, stop: float, margin: float = 0.08) -> LogAxis:
        """Room for all finite positive `values` and a margin; at least a factor of 2."""
        logs = [math.log10(v) for v in values if v > 0.0 and math.isfinite(v)] or [0.0]
        low, high = min(logs), max(logs)
        pad = max((high - low) * margin, (0.4 - (high - low)) / 2.0, 0.03)
        return cls(10.0 ** (low - pad), 10.0 ** (high + pad), start, stop)

    def __call__(self, value: float) -> float:
        share = (math.log10(value) - math.log10(self.low)) / (math.log10(self.high) - math.log10(self.low))
        return self.start + (self.stop - self.start) * share

    @property
    def decades(self) -> float:
        return math.log10(self.high / self.low)

    def ticks(self) -> list[tuple[float, str]]:
        """(value, label): decades, thinned to eight; 1-2-5 steps where the axis spans less than a decade and a half."""
        first, last = math.floor(math.log10(self.low)), math.ceil(math.log10(self.high))
        if self.decades < 1.5:
            steps = (1, 2, 5) if self.decades > 0.7 else (1, 1.5, 2, 3, 4, 5, 6, 7, 8, 9)
            found = [(s * 10.0**e, _short(s * 10.0**e)) for e in range(first, last + 1) for s in steps]
        else:
            every = max(1, math.ceil((last - first) / 8))
            found = [(10.0**e, power(e)) for e in range(first, last + 1) if e % every == 0]
        return [(v, label) for v, label in found if self.low <= v <= self.high]

    def minor(self) -> list[float]:
        """Values of the small ticks: 2 to 9 in each decade, none where they would crowd."""
        if not 1.5 <= self.decades <= 6.0:
            return []
        first, last = math.floor(math.log10(self.low)), math.ceil(math.log10(self.high))
        return [
            s * 10.0**e for e in range(first, last + 1) for s in range(2, 10) if self.low <= s * 10.0**e <= self.high
        ]


def _short(value: float) -> str:
    if 0.001 <= value < 10000.0:
        return f"{value:g}"
    exponent = math.floor(math.log10(value) + 1e-9)
    mantissa = value / 10.0**exponent
    return power(exponent) if abs(mantissa - 1.0) < 1e-6 else f"{mantissa:g}·{power(exponent)}"
