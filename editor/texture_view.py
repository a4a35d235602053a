"""A texture's numbers as a picture to look at: channels, exposure, encoding, marks for NaN. Pure numpy."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

CHANNELS = ("rgb", "r", "g", "b", "a", "luma", "normal")
#: Rec. 709: what each channel adds to luminance (ITU-R BT.709-6)
LUMA = (0.2126, 0.7152, 0.0722)
#: not a number; infinite; shown over everything else
NAN_COLOR, INF_COLOR = (255, 0, 255), (255, 255, 0)


def as_float(pixels: NDArray[Any]) -> NDArray[np.float32]:
    """f4[h,w,c]: whole-number formats as 0..1."""
    values = pixels.reshape(*pixels.shape[:2], -1)
    if values.dtype.kind == "u":
        return (values / np.float32(np.iinfo(values.dtype).max)).astype(np.float32)
    return values.astype(np.float32)


def linear(values: NDArray[np.float32]) -> NDArray[np.float32]:
    """`values` f4[h,w,c] stored with the sRGB curve as scene-linear ones; alpha has no curve (IEC 61966-2-1)."""
    color = values[..., :3]
    curved = np.where(color <= 0.04045, color / 12.92, ((np.maximum(color, 0.0) + 0.055) / 1.055) ** 2.4)
    return np.concatenate([curved, values[..., 3:]], axis=2).astype(np.float32)


def normals(values: NDArray[np.float32], *, signed: bool) -> NDArray[np.float32]:
    """f4[h,w,3] vectors of what is stored: `signed` as it is, else 0..1 for -1..1. Of two channels the third is the z
    of a unit vector."""
    vectors = values[..., :3] if signed else values[..., :3] * np.float32(2.0) - np.float32(1.0)
    if vectors.shape[2] == 2:
        square = (vectors**2).sum(axis=2, keepdims=True)
        vectors = np.concatenate([vectors, np.sqrt(np.maximum(1.0 - square, 0.0))], axis=2)
    return np.asarray(vectors, np.float32)


def picture(values: NDArray[np.float32], channels: str, stops: float, low: float, high: float,
            *, encode: bool, normal: bool = False) -> NDArray[np.uint8]:  # fmt: skip
    """u1[h,w,4] of `values` f4[h,w,c]: `channels` of CHANNELS times 2^stops, `low`..`high` to black..white.

    `encode`: the values are scene-linear and get the sRGB curve. Single channels are grey. `normal`: of two
    channels 0..1, the third is the z of a unit vector. Channels `luma`: Rec. 709 luminance; `normal`: unit vectors,
    -1..1 as 0..1, whatever range and exposure are."""
    count = values.shape[2]
    if channels == "normal" and count >= 2:
        with np.errstate(invalid="ignore"):
            signed = bool((values[..., :2] < 0.0).any())
        shown = normals(values, signed=signed) * np.float32(0.5) + np.float32(0.5)
        stops, low, high, encode = 0.0, 0.0, 1.0, False
    elif channels == "luma" and count >= 3:
        with np.errstate(invalid="ignore", over="ignore"):
            shown = np.repeat((values[..., :3] @ np.array(LUMA, np.float32))[..., None], 3, axis=2)
    elif channels in ("rgb", "luma", "normal"):
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


def magnified(
    pixels: NDArray[np.uint8], low: tuple[float, float], scale: float, size: tuple[int, int]
) -> NDArray[np.uint8]:
    """u1[size y, size x, 4]: each texel a square, `scale` pixels wide, the first with its corner at `low`; clear beside
    the picture."""
    (height, width), (columns, rows) = pixels.shape[:2], size
    x, y = (np.floor((np.arange(n) + 0.5 - start) / scale).astype(int) for n, start in zip(size, low, strict=True))
    inside = ((y >= 0) & (y < height))[:, None] & ((x >= 0) & (x < width))[None, :]
    found = pixels[np.clip(y, 0, height - 1)[:, None], np.clip(x, 0, width - 1)[None, :]]
    out = np.zeros((rows, columns, 4), np.uint8)
    out[inside] = found[inside]
    return out


def value_range(values: NDArray[np.float32]) -> tuple[float, float]:
    """(smallest, largest) finite value of all channels; (0, 1) where there is none."""
    finite = values[np.isfinite(values)]
    return (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)


def depth_range(values: NDArray[np.float32]) -> tuple[float, float]:
    """What to show of a depth texture: from the smallest to the largest value that something was drawn with. 0 is
    infinitely far (reversed depth), so nothing is there. (0, 1) where nothing was drawn."""
    drawn = values[np.isfinite(values) & (values > 0.0)]
    if not drawn.size:
        return 0.0, 1.0
    low, high = float(drawn.min()), float(drawn.max())
    return (low, high) if high > low else (0.0, high)


def not_numbers(values: NDArray[np.float32]) -> tuple[int, int]:
    """How many texels have a NaN, and how many an infinity."""
    return int(np.isnan(values).any(axis=2).sum()), int(np.isinf(values).any(axis=2).sum())


def cross(faces: list[NDArray[np.float32]]) -> NDArray[np.float32]:
    """f4[3n,4n,c]: six faces +x -x +y -y +z -z as an unfolded cube, +z in the middle of the left half; zero beside."""
    n, count = faces[0].shape[0], faces[0].shape[2]
    out = np.zeros((3 * n, 4 * n, count), np.float32)
    for face, (row, column) in zip(faces, ((1, 2), (1, 0), (0, 1), (2, 1), (1, 1), (1, 3)), strict=True):
        out[row * n : (row + 1) * n, column * n : (column + 1) * n] = face
    return out


def overwritten(plan: Any, name: str) -> bool:
    """Whether a later texture of the frame graph took the memory of `name`, so that it holds that one's content."""
    slot = plan.slots.get(name)
    if slot is None:
        return False
    mine = plan.spans[name]
    return any(s == slot and other != name and plan.spans[other].first > mine.first for other, s in plan.slots.items())
