"""Bootstrap intervals: how sure a ratio of two medians is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from engine.core.errors import UsageError

#: samples of which the percentile bootstrap's interval holds roughly what it says
FEW = 9


@dataclass(frozen=True, slots=True)
class Interval:
    """`value` with its interval [`low`, `high`] of the stated confidence."""

    value: float
    low: float
    high: float
    confidence: float = 0.95

    def to_json(self) -> dict[str, float]:
        return {"value": self.value, "low": self.low, "high": self.high, "confidence": self.confidence}


def ratio_interval(
    a: Sequence[float], b: Sequence[float], *, confidence: float = 0.95, resamples: int = 2000, seed: int = 1
) -> Interval:
    """Return median(a) / median(b) with its percentile bootstrap interval (Efron 1979). Samples positive.

    Interleaved samples of equal count are resampled in pairs, so that what disturbed both (another process, a clock
    change) does not widen the interval. Of fewer than FEW samples a bootstrap is too sure of itself: there the interval
    is everything that was seen. Raises UsageError for no samples.
    """
    x, y = np.asarray(a, np.float64), np.asarray(b, np.float64)
    if x.size == 0 or y.size == 0:
        raise UsageError("no samples to compare")
    rng = np.random.default_rng(seed)
    rows = rng.integers(0, x.size, (resamples, x.size))
    other = rows if x.size == y.size else rng.integers(0, y.size, (resamples, y.size))
    bottom = np.maximum(np.median(y[other], axis=1), 1e-12)
    ratios = np.median(x[rows], axis=1) / bottom
    low, high = np.quantile(ratios, [(1.0 - confidence) / 2.0, (1.0 + confidence) / 2.0])
    if min(x.size, y.size) < FEW:
        low, high = x.min() / max(y.max(), 1e-12), x.max() / max(y.min(), 1e-12)
    value = float(np.median(x)) / max(float(np.median(y)), 1e-12)
    return Interval(value, float(min(low, value)), float(max(high, value)), confidence)
