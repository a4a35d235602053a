"""Observed order of convergence: the slope of log error over log step."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from engine.core.errors import UsageError


@dataclass(frozen=True, slots=True)
class Fit:
    """error = constant * step^slope; `residual`: rms of log10(error) about the line; `used`: points in the fit."""

    slope: float
    constant: float
    residual: float
    used: int

    def at(self, step: float) -> float:
        return float(self.constant * step**self.slope)


def fit_order(step: ArrayLike, error: ArrayLike, *, floor: float = 0.0) -> Fit:
    """Least squares on log-log points. Left out: non-finite or non-positive ones, and errors up to `floor` (what the
    truth's noise or the storage format hides, where the curve has flattened).

    Raises UsageError when fewer than two different steps are left.
    """
    h, e = np.asarray(step, np.float64), np.asarray(error, np.float64)
    good = np.isfinite(h) & np.isfinite(e) & (h > 0.0) & (e > max(floor, 0.0))
    h, e = h[good], e[good]
    if len(np.unique(h)) < 2:
        raise UsageError(f"no order can be fitted to {len(h)} usable points", hint="measure more knob values")
    x, y = np.log10(h), np.log10(e)
    slope, offset = np.polyfit(x, y, 1)
    residual = float(np.sqrt(np.mean((y - slope * x - offset) ** 2)))
    return Fit(float(slope), float(10.0**offset), residual, len(h))
