"""PNG files of 16 bits a channel, whole: Pillow drops the lower half of colours.

A scan line's filter needs the texel on its left, so lines are undone along diagonals: all lines at once, each one texel
behind the one above it. Source: PNG Specification, 3rd edition (W3C, 2025), sections 7.2 and 9 (filters).
"""

from __future__ import annotations

import struct
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

SIGNATURE = b"\x89PNG\r\n\x1a\n"
#: colour type -> channels
_CHANNELS = {0: 1, 2: 3, 4: 2, 6: 4}


def is_deep_color(data: bytes) -> bool:
    """Whether this is a PNG of 16-bit colours, without interlacing (those go to Pillow)."""
    return data[:8] == SIGNATURE and len(data) > 28 and data[24] == 16 and data[25] in _CHANNELS and data[28] == 0


def decode_png16(data: bytes) -> NDArray[np.uint16]:
    """u2[h,w,4]; grey is spread, a tRNS colour becomes transparent. Raises ValueError, zlib.error, struct.error."""
    width, height = struct.unpack_from(">2I", data, 16)
    channels = _CHANNELS[data[25]]
    packed, key = bytearray(), None
    at = 8
    while at + 8 <= len(data):
        size, kind = struct.unpack_from(">I4s", data, at)
        body = data[at + 8 : at + 8 + size]
        if kind == b"IDAT":
            packed += body
        elif kind == b"tRNS" and len(body) >= 2 * channels:
            key = np.frombuffer(body, ">u2", channels)
        elif kind == b"IEND":
            break
        at += 12 + size
    line = 1 + 2 * channels * width
    raw = zlib.decompressobj().decompress(bytes(packed), line * height)
    if len(raw) != line * height:
        raise ValueError(f"the pixels are cut off: {len(raw):,} of {line * height:,} bytes")
    lines = np.frombuffer(raw, np.uint8).reshape(height, line)
    plain = _unfilter(lines[:, 0], lines[:, 1:].reshape(height, width, 2 * channels))
    values: NDArray[Any] = plain.reshape(height, width, channels, 2).astype(np.uint16)
    image: NDArray[np.uint16] = values[..., 0] << np.uint16(8) | values[..., 1]
    out = np.full((height, width, 4), 65535, np.uint16)
    out[..., :3] = image[..., :3] if channels >= 3 else image[..., :1]
    if channels in (2, 4):
        out[..., 3] = image[..., -1]
    elif key is not None:
        out[..., 3] = np.where((image == key).all(axis=-1), 0, 65535)
    return out


def _unfilter(filters: NDArray[np.uint8], given: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """u1[h,w,b] from the filtered bytes of texels and each line's filter."""
    if (filters > 4).any():
        raise ValueError(f"filter {int(filters.max())} is not known")
    height, width, size = given.shape
    # a border of zeros on the left and above
    out = np.zeros((height + 1, width + 1, size), np.int16)
    kinds = filters[:, None]
    rows = np.arange(height)
    for step in range(width + height - 1):
        y = rows[max(0, step - width + 1) : step + 1]
        x = step - y
        left, above, corner = out[y + 1, x], out[y, x + 1], out[y, x]
        guess = left + above - corner
        to_left, to_above, to_corner = np.abs(guess - left), np.abs(guess - above), np.abs(guess - corner)
        paeth = np.where(
            (to_left <= to_above) & (to_left <= to_corner), left, np.where(to_above <= to_corner, above, corner)
        )
        kind = kinds[y]
        added = np.where(
            kind == 0, 0,
            np.where(kind == 1, left, np.where(kind == 2, above, np.where(kind == 3, (left + above) >> 1, paeth))),
        )  # fmt: skip
        out[y + 1, x + 1] = (given[y, x] + added) & 255
    return out[1:, 1:].astype(np.uint8)
