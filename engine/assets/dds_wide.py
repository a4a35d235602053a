"""DDS pixels of more than 8 bits, or signed, that no format of ours equals: as half or single floats.

    unorm16 snorm16 snorm8    normalised integers of 1 to 4 channels     mask     any masks of up to 16 bits
    r11g11b10f rgb9e5 rgb32f  packed and three-channel floats            bc4s bc5s   signed blocks

Source: "DXGI_FORMAT" and "Block compression" (Microsoft Learn); signed values are max(v / top, -1).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

#: kind -> bytes of one texel (integers: of one channel); blocks: bytes of one block
TEXEL_BYTES = {"unorm16": 2, "snorm16": 2, "snorm8": 1, "r11g11b10f": 4, "rgb9e5": 4, "rgb32f": 12}
BLOCK_BYTES = {"bc4s": 8, "bc5s": 16}


def stored_size(kind: str, channels: int, bits: int, width: int, height: int, depth: int) -> int:
    """Bytes of one image in the file."""
    if kind in BLOCK_BYTES:
        return -(-width // 4) * -(-height // 4) * BLOCK_BYTES[kind] * depth
    if kind == "wide-mask":
        return width * height * depth * (bits // 8)
    return width * height * depth * TEXEL_BYTES[kind] * (channels if kind.endswith(("8", "16")) else 1)


def widen(
    kind: str, image: memoryview, channels: int, masks: tuple[int, ...], bits: int, width: int, height: int
) -> Floats:
    """f8[n, c] of one image, rows top to bottom."""
    if kind in ("unorm16", "snorm16", "snorm8"):
        values = np.frombuffer(image, {"unorm16": "<u2", "snorm16": "<i2", "snorm8": "i1"}[kind]).reshape(-1, channels)
        return np.maximum(values / float(np.iinfo(values.dtype).max), -1.0)
    if kind == "wide-mask":
        return _masked(np.frombuffer(image, f"<u{bits // 8}"), masks)
    if kind == "rgb32f":
        rgb = np.frombuffer(image, "<f4").reshape(-1, 3).astype(np.float64)
    elif kind == "rgb9e5":
        words = np.frombuffer(image, "<u4")
        scale = np.ldexp(1.0, (words >> np.uint32(27)).astype(np.int32) - 24)
        rgb = np.stack([(words >> np.uint32(9 * k) & np.uint32(511)) * scale for k in range(3)], -1)
    elif kind == "r11g11b10f":
        words = np.frombuffer(image, "<u4")
        rgb = np.stack([_small_float(words >> np.uint32(s), b) for s, b in ((0, 6), (11, 6), (22, 5))], -1)
    else:
        parts = [_signed_blocks(image, 8 * k, BLOCK_BYTES[kind], width, height) for k in range(BLOCK_BYTES[kind] // 8)]
        return np.stack(parts, -1)
    return np.concatenate([rgb, np.ones((len(rgb), 1))], axis=1)


def packed(values: Floats, format: str) -> bytes:
    """f8[n,c] in one of our float formats (`r32f`, `rg16f`, `rgba16f` …)."""
    if format.endswith("16f"):
        half: bytes = np.clip(values, -65504.0, 65504.0).astype("<f2").tobytes()
        return half
    single: bytes = values.astype("<f4").tobytes()
    return single


def _masked(words: NDArray[Any], masks: tuple[int, ...]) -> Floats:
    out = np.ones((len(words), 4))
    for channel, mask in enumerate(masks):
        if mask:
            low = mask & -mask
            out[:, channel] = ((words & words.dtype.type(mask)) // words.dtype.type(low)) / float(mask // low)
        elif channel < 3:
            out[:, channel] = 0.0
    return out


def _small_float(words: NDArray[np.uint32], mantissa: int) -> Floats:
    """Unsigned floats of 5 bits of exponent (bias 15) in the low bits."""
    m = (words & np.uint32((1 << mantissa) - 1)).astype(np.float64) / (1 << mantissa)
    e = (words >> np.uint32(mantissa) & np.uint32(31)).astype(np.int32)
    return np.where(e == 0, np.ldexp(m, -14), np.where(e == 31, 65504.0, np.ldexp(1.0 + m, e - 15)))


def _signed_blocks(image: memoryview, offset: int, size: int, width: int, height: int) -> Floats:
    """f8[h*w] of one channel of signed BC4 or BC5 blocks."""
    columns, rows = -(-width // 4), -(-height // 4)
    raw = np.frombuffer(image, np.uint8).reshape(-1, size)[:, offset : offset + 8]
    ends = np.maximum(np.ascontiguousarray(raw[:, :2]).view(np.int8) / 127.0, -1.0)
    first, second = ends[:, :1], ends[:, 1:]
    k = np.arange(1, 7)
    six = (first * (7 - k) + second * k) / 7.0
    k = np.arange(1, 5)
    four = np.concatenate(
        [(first * (5 - k) + second * k) / 5.0, np.full_like(first, -1.0), np.full_like(first, 1.0)], 1
    )
    palette = np.concatenate([first, second, np.where(first > second, six, four)], axis=1)
    bits = np.zeros(len(raw), np.uint64)
    for byte in range(6):
        bits |= raw[:, 2 + byte].astype(np.uint64) << np.uint64(8 * byte)
    picks = (bits[:, None] >> (np.uint64(3) * np.arange(16, dtype=np.uint64)) & np.uint64(7)).astype(np.intp)
    texels = np.take_along_axis(palette, picks, 1).reshape(rows, columns, 4, 4).swapaxes(1, 2)
    return np.ascontiguousarray(texels.reshape(rows * 4, columns * 4)[:height, :width]).reshape(-1)
