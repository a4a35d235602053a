"""Smaller images: separable area and Kaiser filters, in linear light, for any size.

    resample(image, w, h, kind)     one image to another size
    chain(image, kind)              all mips of a linear image
    normal_chain(vectors)           mips of unit vectors, renormalised
    keep_coverage(levels, cutoff)   alpha scaled so that as much passes the alpha test in every mip as in mip 0

Images are f4[h,w,c], scene-linear. A filter is a small matrix per axis, so odd sizes weigh their texels exactly.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float32]

#: Kaiser window: support in output texels on each side, and beta (Kaiser 1974; 4 is the usual choice for mips)
KAISER_RADIUS = 3.0
KAISER_BETA = 4.0


def resample(image: Floats, width: int, height: int, kind: str = "kaiser", *, wrap: bool = False) -> Floats:
    """`image` f4[h,w,c] at another size. `kind`: box (exact area average) or kaiser (sharper, may overshoot).

    Beyond the border the image repeats with `wrap`, else its edge texels do.
    """
    if kind == "box" and image.shape[:2] == (2 * height, 2 * width):
        rows = image[0::2] + image[1::2]  # the common case, several times faster than taps
        halved: Floats = (rows[:, 0::2] + rows[:, 1::2]) * np.float32(0.25)
        return halved
    out = image
    if out.shape[0] != height:
        out = _apply(out, _taps(out.shape[0], height, kind, wrap), 0)
    if out.shape[1] != width:
        out = _apply(out, _taps(out.shape[1], width, kind, wrap), 1)
    return out


def chain(image: Floats, kind: str = "kaiser", *, wrap: bool = False, low: float = 0.0) -> list[Floats]:
    """`image` and all its mips down to 1x1, each made from the one before; values below `low` are cut to it."""
    levels = [image]
    while max(levels[-1].shape[:2]) > 1:
        height, width = levels[-1].shape[:2]
        small = resample(levels[-1], max(1, width // 2), max(1, height // 2), kind, wrap=wrap)
        if kind != "box":
            np.maximum(small, np.float32(low), out=small)
        levels.append(small)
    return levels


def normal_chain(vectors: Floats, *, wrap: bool = False) -> list[Floats]:
    """Mips of unit vectors f4[h,w,3]: averaged, then scaled to length 1 (+z where they cancel out)."""
    levels = [normalised(vectors)]
    while max(levels[-1].shape[:2]) > 1:
        height, width = levels[-1].shape[:2]
        levels.append(normalised(resample(levels[-1], max(1, width // 2), max(1, height // 2), "box", wrap=wrap)))
    return levels


def normalised(vectors: Floats) -> Floats:
    """`vectors` f4[h,w,3] at length 1; +z where the length is 0."""
    x, y, z = vectors[..., 0], vectors[..., 1], vectors[..., 2]
    length = np.sqrt(x * x + y * y + z * z)
    zero = length <= 1e-6
    length[zero] = 1.0
    result: Floats = vectors / length[..., None]
    if zero.any():
        result[zero] = (0.0, 0.0, 1.0)
    return result


def keep_coverage(levels: list[Floats], cutoff: float) -> list[Floats]:
    """`levels` of rgba with alpha scaled per mip, so that the part of texels with alpha >= cutoff stays that of mip 0.

    Averaging alone makes leaves vanish with distance (Castano 2010, "Computing Alpha Mipmaps").
    """
    alpha = levels[0][..., 3]
    wanted = float(np.mean(alpha >= cutoff))
    if wanted in (0.0, 1.0):
        return levels
    out = [levels[0]]
    for level in levels[1:]:
        flat = np.sort(level[..., 3], axis=None)
        count = flat.size
        # the alpha that as many texels reach as should pass; scaling it to the cutoff lets just those pass
        rank = min(count - 1, max(0, round(count * (1.0 - wanted))))
        at = float(flat[rank])
        scaled = level.copy()
        if at > 1e-4:
            scaled[..., 3] = np.clip(level[..., 3] * (cutoff * 1.001 / at), 0.0, 1.0)
        out.append(scaled)
    return out


@lru_cache(maxsize=64)
def _taps(source: int, target: int, kind: str, wrap: bool) -> tuple[NDArray[np.intp], Floats]:
    """For each output texel the indices [target,k] and the weights [target,k] of the input texels it is made of."""
    scale = source / target
    if kind == "box" or scale <= 1.0:
        radius = 0.5 * max(scale, 1.0)
    else:
        radius = KAISER_RADIUS * scale
    centre = (np.arange(target) + 0.5) * scale
    first = np.floor(centre - radius + 1e-9).astype(np.intp)
    count = math.ceil(2.0 * radius - 1e-9) + (0 if _whole(scale, radius) else 1)
    index = first[:, None] + np.arange(count)
    if kind == "box" or scale <= 1.0:
        low = np.maximum(index, (centre - radius)[:, None])
        high = np.minimum(index + 1, (centre + radius)[:, None])
        weight = np.maximum(0.0, high - low)
    else:
        x = (index + 0.5 - centre[:, None]) / scale
        inside = np.clip(1.0 - np.square(x / KAISER_RADIUS), 0.0, 1.0)
        weight = np.sinc(x) * np.i0(KAISER_BETA * np.sqrt(inside)) * (np.abs(x) < KAISER_RADIUS)
    weight /= weight.sum(1, keepdims=True)
    index = index % source if wrap else np.clip(index, 0, source - 1)
    return index, weight.astype(np.float32)


def _whole(scale: float, radius: float) -> bool:
    """Whether every window starts on a texel edge, so that no extra tap is needed."""
    return float(scale).is_integer() and float(scale * 0.5 - radius).is_integer()


def _apply(image: Floats, taps: tuple[NDArray[np.intp], Floats], axis: int) -> Floats:
    index, weight = taps
    shape = (-1, 1, 1) if axis == 0 else (1, -1, 1)
    out: Floats | None = None
    for k in range(index.shape[1]):
        w = weight[:, k].reshape(shape)
        term: Floats = np.take(image, index[:, k], axis=axis)
        term *= w
        if out is None:
            out = term
        else:
            out += term
    assert out is not None
    return out
