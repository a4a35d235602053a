"""A texture's numbers as a picture to look at: channels, exposure, encoding, marks for NaN. Pure numpy."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

CHANNELS = ("rgb", "r", "g", "b", "a")
#: not a number; infinite; shown over everything else
NAN_COLOR, INF_COLOR = (255, 0, 255), (255, 255, 0)


def as_float(pixels: NDArray[Any]) -> NDArray[np.float32]:
    """f4[h,w,c]: whole-number formats as 0..1."""
    values = pixels.reshape(*pixels.shape[:2], -1)
    if values.dtype.kind == "u":
        return (values / np.float32(np.iinfo(values.dtype).max)).astype(np.float32)
    return values.astype(np.float32)


def picture(values: NDArray[np.float32], channels: str, stops: float, low: float, high: float,
            *, encode: bool, normal: bool = False) -> NDArray[np.uint8]:  # fmt: skip
    """u1[h,w,4] of `values` f4[h,w,c]: `channels` of CHANNELS times 2^stops, `low`..`high` to black..white.

    `encode`: the values are scene-linear and get the sRGB curve. Single channels are grey. `normal`: of two
    channels 0..1, the third is the z of a unit vector."""
    count = values.shape[2]
    if channels == "rgb":
        shown = values[..., :3] if count >= 3 else np.repeat(values[..., :1], 3, axis=2)
        if count == 2:
            third = np.zeros_like(values[..., :1])
            if normal:
                square = ((values * 2.0 - 1.0) ** 2).sum(axis=2, keepdims=True)
                third = np.sqrt(np.maximum(1.0 - square, 0.0)) * 0.5 + 0.5
            shown = np.concatenate([values, third], axis=2)
    else:
        index = "rgba".index(channels)
        shown = np.repeat(values[..., index : index + 1] if index < count else np.ones_like(values[..., :1]), 3, axis=2)
    bad_nan = np.isnan(shown).any(axis=2)
    bad_inf = np.isinf(shown).any(axis=2)
    with np.errstate(invalid="ignore", over="ignore"):
        scaled = (np.nan_to_num(shown, nan=0.0, posinf=0.0, neginf=0.0) * np.float32(2.0**stops) - low) / max(
            high - low, 1e-12
        )
        scaled = np.clip(scaled, 0.0, 1.0)
    if encode and channels != "a":
        scaled = np.where(scaled <= 0.0031308, 12.92 * scaled, 1.055 * scaled ** (1 / 2.4) - 0.055)
    out = np.full((*values.shape[:2], 4), 255, np.uint8)
    out[..., :3] = np.rint(scaled * 255.0)
    out[bad_inf, :3] = INF_COLOR
    out[bad_nan, :3] = NAN_COLOR
    return out


def value_range(values: NDArray[np.float32]) -> tuple[float, float]:
    """(smallest, largest) finite value of all channels; (0, 1) where there is none."""
    finite = values[np.isfinite(values)]
    return (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)


def overwritten(plan: Any, name: str) -> bool:
    """Whether a later texture of the frame graph took the memory of `name`, so that it holds that one's content."""
    slot = plan.slots.get(name)
    if slot is None:
        return False
    mine = plan.spans[name]
    return any(s == slot and other != name and plan.spans[other].first > mine.first for other, s in plan.slots.items())
