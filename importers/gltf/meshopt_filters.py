"""Filters of meshopt compression: what decoded rows stand for. Rows are u1[n, stride] in and out.

Source: EXT_meshopt_compression, appendix B; KHR_meshopt_compression for colour.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Bytes = NDArray[np.uint8]


def octahedral(rows: Bytes) -> Bytes:
    """Unit vectors from two octahedral coordinates; the fourth component is passed on."""
    dtype = np.dtype("i1" if rows.shape[1] == 4 else "<i2")
    given = np.ascontiguousarray(rows).view(dtype)
    one = np.maximum(given[:, 2].astype(np.float64), 1.0)
    x, y = given[:, 0] / one, given[:, 1] / one
    z = 1.0 - np.abs(x) - np.abs(y)
    fold = np.minimum(z, 0.0)
    x, y = x - np.copysign(fold, x), y - np.copysign(fold, y)
    length = np.sqrt(x * x + y * y + z * z)
    scale = np.iinfo(dtype).max / np.where(length > 0, length, 1.0)
    out = given.copy()
    for k, axis in enumerate((x, y, z)):
        out[:, k] = np.clip(_rounded(axis * scale), np.iinfo(dtype).min, np.iinfo(dtype).max)
    return out.view(np.uint8)


def quaternion(rows: Bytes) -> Bytes:
    """Unit quaternions from three components, the largest left out."""
    given = np.ascontiguousarray(rows).view("<i2")
    one = (given[:, 3] | np.int16(3)).astype(np.float64)
    three = given[:, :3] / np.where(one != 0, one, 1.0)[:, None] / np.sqrt(2.0)
    largest = np.sqrt(np.maximum(0.0, 1.0 - (three * three).sum(axis=1)))
    at = (given[:, 3] & 3).astype(np.intp)
    out = np.empty_like(given)
    row = np.arange(len(given))
    for k, values in enumerate((largest, three[:, 0], three[:, 1], three[:, 2])):
        out[row, (at + k) % 4] = np.clip(_rounded(values * 32767.0), -32768, 32767)
    return out.view(np.uint8)


def exponential(rows: Bytes) -> Bytes:
    """Floats from a signed 8-bit exponent and a signed 24-bit mantissa."""
    given = np.ascontiguousarray(rows).view("<i4")
    exponent, mantissa = given >> 24, (given << 8) >> 8
    values: NDArray[np.float64] = np.ldexp(mantissa.astype(np.float64), np.clip(exponent, -100, 100))
    return values.astype("<f4").view(np.uint8)


def color(rows: Bytes) -> Bytes:
    """RGBA from Y, Co, Cg and alpha; the highest bit set of the fourth component says how many bits they have."""
    dtype = np.dtype("u1" if rows.shape[1] == 4 else "<u2")
    given = np.ascontiguousarray(rows).view(dtype)
    signed = given.view(dtype.str.replace("u", "i"))
    top = float(np.iinfo(dtype).max)
    bits = np.frexp(np.maximum(given[:, 3], 1).astype(np.float64))[1] - 1  # index of the highest bit set
    y, co, cg = given[:, 0].astype(np.int64), signed[:, 1].astype(np.int64), signed[:, 2].astype(np.int64)
    # alpha has one bit less than the colours; its lowest bit stands for two
    mask = (np.int64(1) << bits) - 1
    alpha = given[:, 3].astype(np.int64) & mask
    alpha = alpha << 1 | alpha & 1
    scale = top / np.maximum((np.int64(1) << (bits + 1)) - 1, 1)
    out = np.empty_like(given)
    for k, value in enumerate((y + co - cg, y + cg, y - co - cg, alpha)):
        out[:, k] = np.clip(np.floor(value * scale + 0.5), 0, top)
    return out.view(np.uint8)


def _rounded(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """To the nearest, halves away from zero."""
    return np.trunc(values + np.copysign(0.5, values))


#: name in the file -> (function, strides that it goes with; none: all)
FILTERS: dict[str, tuple[Callable[[Bytes], Bytes], tuple[int, ...]]] = {
    "OCTAHEDRAL": (octahedral, (4, 8)), "QUATERNION": (quaternion, (8,)), "EXPONENTIAL": (exponential, ()),
    "COLOR": (color, (4, 8)),
}  # fmt: skip
