"""Shadow maps that can be blurred: moments of depth, and how much light they leave. Float64 twins of what is in
shaders/lib/shadow_moments.glsl.

A lookup gets the mean of some powers of the depths around it, and from these a bound of the part that lies before the
receiver. Depth here is z = 1 - 2 d of the map's reversed depth d: -1 towards the light, 1 away from it.

    esm     E exp(c (z - 1))               Annen, Mertens, Seidel, Flerackers and Kautz 2008, "Exponential shadow maps"
    vsm     E z, E z^2                     Donnelly and Lauritzen 2006, "Variance shadow maps"
    evsm2   the same of exp(c z)           Lauritzen and McCool 2008, "Layered variance shadow maps", section 7
    evsm4   and of -exp(-c z)
    msm     E z .. E z^4                   Peters and Klein 2015, "Moment shadow mapping"

All are bounds from one side: more light comes through than should where several things cast over each other (`leak`
takes the least of it away), and never less over a receiver that is flat.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

F8 = NDArray[np.float64]

#: numbers kept per texel
COUNTS = {"esm": 1, "vsm": 2, "evsm2": 2, "evsm4": 4, "msm": 4}
#: an exponent whose square still fits with a factor of 2^7 to spare (single), or at all (half), at z = 1
LIMIT = {"single": 42.0, "half": 5.54}
#: below this part of a square, a variance is rounding
ROUNDING = {"single": 1e-6, "half": 2e-3}
#: so much of a known distribution is mixed into four moments, which rounding may have made those of none
MOMENT_BIAS = {"single": 3e-7, "half": 2e-3}
#: E z .. E z^4 of that one (Peters, Münstermann, Wetzstein and Klein 2017, "Improved moment shadow maps", table 1)
BIAS_TOWARDS = (0.0, 0.375, 0.0, 0.375)
#: most texels on a side of a blur's middle
MOST_TAPS = 12


def format_of(filter: str, precision: str) -> str:
    """The texture format of a filter's moments."""
    return {1: "r", 2: "rg", 4: "rgba"}[COUNTS[filter]] + ("32f" if precision == "single" else "16f")


def usable_exponent(wanted: float, precision: str) -> float:
    """Kept where moments stay finite."""
    return min(max(wanted, 1.0), LIMIT[precision]) if math.isfinite(wanted) else LIMIT[precision]


def blur_weights(radius: float) -> list[float]:
    """Weights of the middle texel and of those beside it, 1, 2 … texels away: a Gaussian cut off at `radius` texels,
    two standard deviations. They add up to 1 over both sides, so that no sum on the way is larger than its terms."""
    radius = min(max(radius, 0.0), float(MOST_TAPS))
    sigma = max(radius / 2.0, 1e-3)
    half = [math.exp(-0.5 * (k / sigma) ** 2) for k in range(int(radius) + 1)]
    total = half[0] + 2.0 * sum(half[1:])
    return [value / total for value in half]


def moments(filter: str, z: ArrayLike, c: float) -> F8:
    """f8[...,4]: what a texel of depth `z` keeps."""
    d: F8 = np.asarray(z, np.float64)
    nothing = np.zeros_like(d)
    if filter == "esm":
        parts = [np.exp(c * (d - 1.0)), nothing, nothing, nothing]
    elif filter == "vsm":
        parts = [d, d * d, nothing, nothing]
    elif filter == "msm":
        parts = [d, d**2, d**3, d**4]
    else:
        up, down = np.exp(c * d), -np.exp(-c * d)
        both = filter == "evsm4"
        parts = [up, up * up, down if both else nothing, down * down if both else nothing]
    return np.stack(parts, axis=-1)


def chebyshev(mean: ArrayLike, square: ArrayLike, t: ArrayLike, least: ArrayLike) -> F8:
    """Upper bound of the part at or beyond `t`, where its mean lies before it (Cantelli's inequality); else 1."""
    middle, at = np.asarray(mean, np.float64), np.asarray(t, np.float64)
    variance = np.maximum(np.asarray(square, np.float64) - middle * middle, least)
    off = at - middle
    return np.where(off <= 0.0, 1.0, variance / (variance + off * off))


def without_leak(p: ArrayLike, leak: float) -> F8:
    """What is below `leak` is dark, and the rest is stretched (Lauritzen 2007, "Summed-area variance shadow maps")."""
    result: F8 = np.clip((np.asarray(p, np.float64) - leak) / (1.0 - leak), 0.0, 1.0)
    return result


def hamburger(b: ArrayLike, t: ArrayLike, bias: float) -> F8:
    """Upper bound of the part at or beyond `t` f8[...] of distributions with moments `b` f8[...,4].

    Among all distributions with these moments, the one with a node at `t` and two more has the least before `t`. The
    other nodes are the roots of the polynomial of degree 2 that solves the Hankel system for (1, t, t^2); a weight is
    the mean of its Lagrange polynomial (Peters and Klein 2015, algorithm 2).
    """
    given, at = np.asarray(b, np.float64), np.asarray(t, np.float64)
    b1, b2, b3, b4 = np.moveaxis(given + (np.array(BIAS_TOWARDS) - given) * bias, -1, 0)
    with np.errstate(all="ignore"):
        d11 = b2 - b1 * b1
        l21 = (b3 - b1 * b2) / d11
        d22 = (b4 - b2 * b2) - l21 * (b3 - b1 * b2)
        c1 = (at - b1) / d11
        c2 = ((at * at - b2) - l21 * (at - b1)) / d22
        c1 = c1 - l21 * c2
        c0 = 1.0 - b1 * c1 - b2 * c2
        p, q = c1 / c2, c0 / c2
        root = np.sqrt(np.maximum(p * p / 4.0 - q, 0.0))
        low, high = -p / 2.0 - root, -p / 2.0 + root
        first = (b2 - (at + high) * b1 + at * high) / ((low - at) * (low - high))
        own = (b2 - (low + high) * b1 + low * high) / ((at - low) * (at - high))
        before = np.where(at <= low, 0.0, np.where(at <= high, first, 1.0 - own))
    return np.clip(1.0 - np.nan_to_num(before, nan=0.0), 0.0, 1.0)


def visibility(filter: str, m: ArrayLike, t: ArrayLike, *, c: float, leak: float, precision: str = "single",
               texel: float = 0.0, steep: float = 0.0) -> F8:  # fmt: skip
    """How much of the light reaches a receiver at depth `t` f8[...] past what was blurred into `m` f8[...,4].

    `texel`: width of a texel in depth's unit: a variance less than what one of them spans is none to tell. `steep`: the
    receiver's depth per texel times the square of the blur's radius in texels: where that is large, the mean of
    evsm4's convex warp over the receiver itself lies beyond it, and bounds nothing."""
    m, at = np.asarray(m, np.float64), np.asarray(t, np.float64)
    floor = ROUNDING[precision]
    if filter == "esm":
        return without_leak(np.minimum(m[..., 0] * np.exp(c * (1.0 - at)), 1.0), leak)
    if filter == "vsm":
        return without_leak(chebyshev(m[..., 0], m[..., 1], at, max(floor, (0.25 * texel) ** 2)), leak)
    if filter == "msm":
        return without_leak(hamburger(m, at, MOMENT_BIAS[precision]), leak)
    floor = max(floor, (0.25 * texel * c) ** 2)
    up = np.exp(c * at)
    p = chebyshev(m[..., 0], m[..., 1], up, floor * up * up)
    if filter == "evsm4":
        down = -np.exp(-c * at)
        convex = min(max(c * steep / 4.0 - 1.0, 0.0), 1.0)
        p = np.minimum(p, np.maximum(chebyshev(m[..., 2], m[..., 3], down, floor * down * down), convex))
    return without_leak(p, leak)
