"""Colour: the sRGB transfer function and luminance. Linear means scene-linear Rec.709 primaries, D65."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

F8 = NDArray[np.float64]

#: Luminance weights of linear Rec.709 (ITU-R BT.709-6).
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
LUMINANCE.setflags(write=False)


def srgb_to_linear(encoded: ArrayLike) -> F8:
    """Decode sRGB values [...] (0..1) to linear (IEC 61966-2-1:1999); negative values are mirrored, NaN stays NaN."""
    v = np.asarray(encoded, np.float64)
    size = np.abs(v)
    return np.copysign(np.where(size <= 0.04045, size / 12.92, ((size + 0.055) / 1.055) ** 2.4), v)


def linear_to_srgb(linear: ArrayLike) -> F8:
    """Encode linear values [...] to sRGB (IEC 61966-2-1:1999); negative values are mirrored, NaN stays NaN."""
    v = np.asarray(linear, np.float64)
    size = np.abs(v)
    return np.copysign(np.where(size <= 0.0031308, size * 12.92, 1.055 * size ** (1.0 / 2.4) - 0.055), v)


def to_u1(linear: ArrayLike) -> NDArray[np.uint8]:
    """Encode linear values [...] to 8-bit sRGB, rounded to nearest; out of range is clamped, NaN becomes 0."""
    encoded = linear_to_srgb(np.nan_to_num(np.asarray(linear, np.float64), nan=0.0, posinf=1.0, neginf=0.0))
    return np.rint(np.clip(encoded, 0.0, 1.0) * 255.0).astype(np.uint8)


def luminance(rgb: ArrayLike) -> F8:
    """Return the relative luminance [...] of linear `rgb` [..., 3]."""
    result: F8 = np.asarray(rgb, np.float64) @ LUMINANCE
    return result
