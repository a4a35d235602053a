"""Image errors against a reference, in float64. Arrays of any equal shape; a non-finite pixel makes an error infinite.

So a NaN in a picture can never look like a good result. Two equal infinities do not differ.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core.errors import InputError

F8 = NDArray[np.float64]

#: The floor of rel_mse's denominator: keeps dark pixels from ruling the sum (Rousselle et al. 2011 use 1e-2).
RELATIVE_FLOOR = 1e-2


def rmse(image: ArrayLike, reference: ArrayLike) -> float:
    """Return sqrt(mean((x - r)^2)) over all values."""
    return math.sqrt(float(np.mean(_difference(image, reference) ** 2)))


def rel_mse(image: ArrayLike, reference: ArrayLike) -> float:
    """Return mean((x - r)^2 / (r^2 + 1e-2)), the relative squared error of radiance (Rousselle et al. 2011)."""
    difference, r = _difference(image, reference), np.asarray(reference, np.float64)
    bottom = np.where(np.isfinite(r), r * r, 0.0) + RELATIVE_FLOOR
    return float(np.mean(difference * difference / bottom))


def max_error(image: ArrayLike, reference: ArrayLike) -> float:
    """Return max |x - r|."""
    return float(np.max(_difference(image, reference)))


def psnr(image: ArrayLike, reference: ArrayLike, peak: float | None = None) -> float:
    """Return 20 log10(peak / rmse) in dB, infinite for equal images; `peak` is 255 for 8-bit images, else 1."""
    if peak is None:
        peak = 255.0 if np.asarray(reference).dtype == np.uint8 else 1.0
    error = rmse(image, reference)
    if error == 0.0:
        return math.inf
    return 20.0 * math.log10(peak / error) if math.isfinite(error) else -math.inf


def mean_angle(a: ArrayLike, b: ArrayLike) -> float:
    """Return the mean angle (radians) between vectors `a` and `b` [..., 3] of any length; a zero vector counts pi."""
    return float(np.mean(_angles(a, b)))


def max_angle(a: ArrayLike, b: ArrayLike) -> float:
    """Return the greatest angle (radians) between vectors `a` and `b` [..., 3]; a zero vector counts pi."""
    return float(np.max(_angles(a, b)))


def relative_error(values: ArrayLike, reference: ArrayLike, quantile: float = 1.0) -> float:
    """Return the `quantile` (1 = the greatest) of |x - r| / |r|; where r = 0, 0 for an equal value, else infinite."""
    difference, r = _difference(values, reference), np.abs(np.asarray(reference, np.float64))
    zero = r == 0.0
    ratio = difference / np.where(zero, 1.0, r)
    ratio = np.where(zero & (difference > 0.0), math.inf, ratio)
    return float(np.quantile(ratio, quantile, method="lower"))


def energy_deviation(energy: ArrayLike, reference: ArrayLike = 1.0) -> float:
    """Return max |E - E_ref|: how much light is lost or made; in a furnace the reference is 1."""
    e = np.asarray(energy, np.float64)
    return max_error(e, np.broadcast_to(np.asarray(reference, np.float64), e.shape))


def count_nonfinite(image: ArrayLike) -> int:
    """Return how many values are NaN or infinite."""
    return int(np.count_nonzero(~np.isfinite(np.asarray(image, np.float64))))


def is_blank(image: ArrayLike, tolerance: float = 0.0) -> bool:
    """True if an image [h,w,...] shows nothing: empty, or each channel's finite values lie within `tolerance`."""
    v = np.asarray(image, np.float64)
    if v.size == 0:
        return True
    v = v.reshape(-1, v.shape[2] if v.ndim > 2 else 1)
    finite = np.isfinite(v)
    low = np.where(finite, v, math.inf).min(axis=0)
    high = np.where(finite, v, -math.inf).max(axis=0)
    return bool(np.all((high <= low) | (high - np.where(np.isfinite(low), low, 0.0) <= tolerance)))


def _angles(a: ArrayLike, b: ArrayLike) -> F8:
    a, b = np.asarray(a, np.float64), np.asarray(b, np.float64)
    if a.shape != b.shape or a.size == 0:
        raise InputError(f"cannot compare directions of shapes {a.shape} and {b.shape}")
    angle = np.arctan2(np.linalg.norm(np.cross(a, b), axis=-1), np.sum(a * b, axis=-1))
    known = np.any(a != 0.0, axis=-1) & np.any(b != 0.0, axis=-1) & np.isfinite(angle)
    return np.where(known, angle, math.pi)


def _difference(image: ArrayLike, reference: ArrayLike) -> F8:
    """Return |x - r| in float64, infinite where either is not finite and they differ."""
    x, r = np.asarray(image, np.float64), np.asarray(reference, np.float64)
    if x.shape != r.shape:
        raise InputError(f"cannot compare images of shapes {x.shape} and {r.shape}", hint="render both at one size")
    if x.size == 0:
        raise InputError("cannot compare empty images")
    finite = np.isfinite(x) & np.isfinite(r)
    difference = np.abs(np.where(finite, x, 0.0) - np.where(finite, r, 0.0))
    return np.where(finite | (x == r), difference, math.inf)
