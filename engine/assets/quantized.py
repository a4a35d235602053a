"""Vertex streams in 16 bits of the box that they lie in: half the bytes of positions, uvs and morph offsets in a file.

    stored = round((value - low) / step), u2        value = low + stored * step, step = (high - low) / 65535

The error is at most half a step in each component, and what float32 rounds. They are float32 again once read: the GPU's
layout does not change.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

STEPS = 65535


@dataclass(frozen=True, slots=True)
class Box:
    """`low`, `step`: f8[k], one of each component."""

    low: NDArray[np.float64]
    step: NDArray[np.float64]

    def to_json(self) -> list[list[float]]:
        return [self.low.tolist(), self.step.tolist()]

    @classmethod
    def from_json(cls, values: ArrayLike) -> Box:
        """Raises ValueError where they are not two rows of finite numbers."""
        rows = np.asarray(values, np.float64)
        if rows.ndim != 2 or len(rows) != 2 or not np.isfinite(rows).all():
            raise ValueError("a quantised stream's box is not two rows of finite numbers")
        return cls(rows[0], rows[1])


def encode(values: NDArray[np.generic]) -> tuple[NDArray[np.uint16], Box]:
    """u2[n,k] of finite f4[n,k], and the box."""
    wide = np.asarray(values, np.float64)
    low = wide.min(axis=0) if len(wide) else np.zeros(wide.shape[1])
    high = wide.max(axis=0) if len(wide) else low
    step = (high - low) / STEPS
    stored = np.rint((wide - low) / np.where(step > 0.0, step, 1.0))
    return stored.clip(0, STEPS).astype("<u2"), Box(low, step)


def decode(stored: NDArray[np.generic], box: Box) -> NDArray[np.float32]:
    """f4[n,k] of u2[n,k]. Raises ValueError where the shapes do not fit."""
    if stored.ndim != 2 or stored.shape[1] != len(box.low):
        raise ValueError(f"a quantised stream is {list(stored.shape)}, its box has {len(box.low)} components")
    wide = np.asarray(stored, np.float64)
    return np.ascontiguousarray((box.low + wide * box.step).astype("<f4"))


def error(values: NDArray[np.generic]) -> float:
    """The largest distance between a row of `values` and what is read of it."""
    back = decode(*encode(values)).astype(np.float64)
    off = np.linalg.norm(back - np.asarray(values, np.float64), axis=1)
    return float(off.max(initial=0.0))
