"""PSD and PSB: the flat composite, at 8, 16 and 32 bits; grey, RGB, CMYK and indexed.

Layers are not looked at: the composite is there where the file was saved with maximum compatibility.
Source: Adobe Photoshop File Formats Specification (Adobe, 2019), "Image Data Section".
"""

from __future__ import annotations

import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

MAGIC = b"8BPS"
MODES = {0: "bitmap", 1: "grey", 2: "indexed", 3: "RGB", 4: "CMYK", 7: "multichannel", 8: "duotone", 9: "Lab"}


def probe(data: bytes) -> tuple[str, int, int] | None:
    """(mode, width, height), or None where this is no PSD."""
    if data[:4] != MAGIC or len(data) < 26:
        return None
    height, width = struct.unpack_from(">2I", data, 14)
    return MODES.get(struct.unpack_from(">H", data, 24)[0], "?"), width, height


def decode_psd(data: bytes) -> NDArray[Any]:
    """u1 or u2[h,w,4], or f4[h,w,3] from 32-bit files. Raises ValueError, struct.error, IndexError."""
    version, channels, height, width, depth, mode = _header(data)
    if mode not in (1, 2, 3, 4, 8) or depth not in (8, 16, 32):
        raise ValueError(f"{MODES.get(mode, mode)} with {depth} bits is not supported; save it as RGB")
    at = 26
    palette = b""
    for section in range(3):
        wide = version == 2 and section == 2
        (size,) = struct.unpack_from(">Q" if wide else ">I", data, at)
        at += 8 if wide else 4
        if section == 0:
            palette = data[at : at + size]
        at += size
    (packing,) = struct.unpack_from(">H", data, at)
    at += 2
    line = width * depth // 8
    if packing == 0:
        planes = np.frombuffer(data, np.uint8, channels * height * line, at)
    elif packing == 1:
        planes = _unpack_bits(data, at, channels * height, line, version)
    else:
        raise ValueError(f"packing {packing} of the composite is not supported; save the file again")
    dtype = {8: ">u1", 16: ">u2", 32: ">f4"}[depth]
    image = planes.view(dtype).reshape(channels, height, width)
    return _to_rgba(image, mode, depth, palette)


def _header(data: bytes) -> tuple[int, int, int, int, int, int]:
    (version,) = struct.unpack_from(">H", data, 4)
    channels, height, width, depth, mode = struct.unpack_from(">H2I2H", data, 12)
    if version not in (1, 2) or not 1 <= channels <= 56:
        raise ValueError(f"version {version} with {channels} channels is not possible")
    return version, channels, height, width, depth, mode


def _unpack_bits(data: bytes, at: int, lines: int, size: int, version: int) -> NDArray[np.uint8]:
    """PackBits, line by line: a count below 128 is so many bytes and one more, above it a run."""
    kind = ">u4" if version == 2 else ">u2"
    lengths = np.frombuffer(data, kind, lines, at).tolist()
    at += lines * int(kind[2])
    out = bytearray()
    for number, length in enumerate(lengths, 1):
        end = at + length
        while at < end:
            count = data[at]
            if count < 128:
                out += data[at + 1 : at + 2 + count]
                at += 2 + count
            else:
                if count > 128:
                    out += data[at + 1 : at + 2] * (257 - count)
                at += 2 if count > 128 else 1
        if len(out) != number * size:
            raise ValueError(f"line {number} of the composite is damaged")
    return np.frombuffer(bytes(out), np.uint8)


def _to_rgba(image: NDArray[Any], mode: int, depth: int, palette: bytes) -> NDArray[Any]:
    native = image.astype(image.dtype.newbyteorder("="))
    if mode == 2:
        table = np.frombuffer(palette, np.uint8, 768).reshape(3, 256)
        native = table[:, native[0]]
    colors = {1: 1, 8: 1, 2: 3, 3: 3, 4: 4}[mode]
    if len(native) < colors:
        raise ValueError(f"{len(native)} channels are too few for {MODES[mode]}")
    top: Any = 1.0 if depth == 32 else np.iinfo(native.dtype).max
    if mode == 4:
        # stored inverted: full ink is 0
        ink = native[:4].astype(np.float64) / top
        rgb = (ink[:3] * ink[3] * top).astype(native.dtype)
    else:
        rgb = native[:colors] if colors == 3 else np.repeat(native[:1], 3, axis=0)
    if depth == 32:
        finite = np.nan_to_num(np.moveaxis(rgb, 0, -1).astype(np.float32), nan=0.0, posinf=3.4e38, neginf=0.0)
        return np.asarray(np.maximum(finite, np.float32(0.0)))
    out = np.full((*native.shape[1:], 4), top, native.dtype)
    out[..., :3] = np.moveaxis(rgb, 0, -1)
    if mode != 2 and len(native) > colors:
        out[..., 3] = native[colors]
    return out
