"""Pixel layouts of old DDS files, and their conversion where the GPU has no equal format.

legacy_pixels(flags, fourcc, bits, masks) -> Pixels     what the header means
convert(pixels, image, w, h, d) -> bytes | view         our format; a view where nothing needs doing
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.assets import dds_wide
from engine.assets.texture import level_size

_ALPHA, _ALPHA_ONLY, _FOURCC, _RGB, _LUMINANCE, _SIGNED = 0x1, 0x2, 0x4, 0x40, 0x20000, 0x80000


@dataclass(frozen=True, slots=True)
class Pixels:
    """`format`: what they become. `source`: "" as they are, `mask` (`bits` wide, r g b a masks), `bc2`, or one of
    dds_wide.py, of which integers have the channels of `format`."""

    format: str
    source: str = ""
    bits: int = 0
    masks: tuple[int, int, int, int] = (0, 0, 0, 0)
    note: str = ""

    @property
    def wide(self) -> bool:
        return self.source not in ("", "mask", "bc2")

    @property
    def channels(self) -> int:
        return len(self.format) - len(self.format.lstrip("rgba"))

    @property
    def stored_name(self) -> str:
        return f"{self.bits}-bit" if self.source.endswith("mask") else self.source or self.format

    def stored_size(self, width: int, height: int, depth: int) -> int:
        """Bytes of one image in the file."""
        if self.source == "mask":
            return width * height * depth * (self.bits // 8)
        if self.wide:
            return dds_wide.stored_size(self.source, self.channels, self.bits, width, height, depth)
        return level_size("bc3" if self.source == "bc2" else self.format, width, height, depth)


_CODES = {
    b"DXT1": Pixels("bc1"),
    b"DXT2": Pixels("rgba8", "bc2", note="premultiplied"),
    b"DXT3": Pixels("rgba8", "bc2"),
    b"DXT4": Pixels("bc3", note="premultiplied"),
    b"DXT5": Pixels("bc3"),
    b"RXGB": Pixels("bc3", note="rxgb"),
    b"BC4S": Pixels("r16f", "bc4s"),
    b"BC5S": Pixels("rg16f", "bc5s"),
    b"ATI1": Pixels("bc4"),
    b"BC4U": Pixels("bc4"),
    b"ATI2": Pixels("bc5"),
    b"BC5U": Pixels("bc5"),
}
#: signed masks of Direct3D 9 (bits, r, g, b, a): V8U8, Q8W8V8U8, V16U16
_SIGNED_MASKS = {
    (16, 0xFF, 0xFF00, 0, 0): Pixels("rg16f", "snorm8"),
    (32, 0xFF, 0xFF00, 0xFF0000, 0xFF000000): Pixels("rgba16f", "snorm8"),
    (32, 0xFFFF, 0xFFFF0000, 0, 0): Pixels("rg16f", "snorm16"),
}
#: D3DFORMAT numbers in the fourCC field
_D3DFMT_WIDE = {36: Pixels("rgba16f", "unorm16"), 110: Pixels("rgba16f", "snorm16")}
_D3DFMT = {111: "r16f", 112: "rg16f", 113: "rgba16f", 114: "r32f", 115: "rg32f", 116: "rgba32f"}


def legacy_pixels(flags: int, fourcc: bytes, bits: int, masks: tuple[int, ...]) -> Pixels | None:
    """What a header without DX10 part means, or None when we have nothing for it."""
    if flags & _FOURCC:
        number = int.from_bytes(fourcc, "little")
        code = _D3DFMT.get(number)
        return Pixels(code) if code else _D3DFMT_WIDE.get(number) or _CODES.get(fourcc)
    if bits not in (8, 16, 24, 32) or any(mask >> bits for mask in masks):
        return None
    r, g, b, a = masks
    if flags & _SIGNED:
        return _SIGNED_MASKS.get((bits, r, g, b, a))
    if flags & _LUMINANCE:
        if bits == 16 and r == 0xFFFF:
            return Pixels("r32f", "unorm16", note="luminance")
        if bits == 8 and r in (0, 0xFF) and not flags & _ALPHA:
            return Pixels("r8", note="luminance")
        if r > 0xFF or not r:
            return None  # 16-bit luminance would lose half of its bits
        return Pixels("rgba8", "mask", bits, (r, r, r, a if flags & _ALPHA else 0), "luminance")
    if flags & _RGB:
        alpha = a if flags & _ALPHA else 0
        if bits == 32 and (r, g, b, alpha) == (0xFF, 0xFF00, 0xFF0000, 0xFF000000):
            return Pixels("rgba8")
        if bits == 8 and (r, g, b) in ((0xFF, 0, 0), (0xFF, 0xFF, 0xFF)) and not alpha:
            return Pixels("r8")
        masks = (r, g, b, alpha)
        if _readable(masks):
            return Pixels("rgba8", "mask", bits, masks)
        return Pixels("rgba16f", "wide-mask", bits, masks) if bits != 24 and _readable(masks, 0xFFFF) else None
    if flags & _ALPHA_ONLY and bits == 8:
        return Pixels("rgba8", "mask", 8, (0, 0, 0, 0xFF), "alpha")
    return None


def _readable(masks: tuple[int, int, int, int], most: int = 0xFF) -> bool:
    """Each mask is one run of bits up to `most`, and there is any colour."""
    for mask in masks:
        low = mask & -mask
        if mask and (mask // low > most or (mask // low) & (mask // low + 1)):
            return False
    return any(masks[:3])


def convert(pixels: Pixels, image: memoryview, width: int, height: int, depth: int) -> bytes | memoryview:
    """One stored image in the format `pixels.format`, rows top to bottom, tightly packed."""
    if pixels.source == "bc2":
        size = pixels.stored_size(width, height, 1)
        return b"".join(_bc2(image[i * size : (i + 1) * size], width, height).tobytes() for i in range(depth))
    if pixels.source == "mask":
        return _masked(image, pixels.bits, pixels.masks).tobytes()
    if pixels.wide:
        size = pixels.stored_size(width, height, 1)
        slices = [
            dds_wide.widen(
                pixels.source,
                image[i * size : (i + 1) * size],
                pixels.channels,
                pixels.masks,
                pixels.bits,
                width,
                height,
            )
            for i in range(depth)
        ]
        return b"".join(dds_wide.packed(values, pixels.format) for values in slices)
    return image


def _masked(image: memoryview, bits: int, masks: tuple[int, int, int, int]) -> NDArray[np.uint8]:
    """u1[n,4]; an absent alpha is 255, an absent colour 0 (white where only alpha is stored)."""
    raw = np.frombuffer(image, np.uint8)
    if bits == 24:
        parts = raw.reshape(-1, 3).astype(np.uint32)
        words: NDArray[Any] = parts[:, 0] | parts[:, 1] << 8 | parts[:, 2] << 16
    else:
        words = raw.view(f"<u{bits // 8}")
    out = np.full((len(words), 4), 255, np.uint8)
    for channel, mask in enumerate(masks):
        if mask:
            low = mask & -mask
            top = mask // low
            value = (words & words.dtype.type(mask)) // words.dtype.type(low)
            out[:, channel] = value if top == 255 else (value.astype(np.uint32) * 255 + top // 2) // top
        elif channel < 3 and any(masks[:3]):
            out[:, channel] = 0
    return out


def _bc2(image: memoryview, width: int, height: int) -> NDArray[np.uint8]:
    """BC2: 4-bit alpha and a BC1 colour block that always has four colours (Direct3D 10 functional specification)."""
    columns, rows = -(-width // 4), -(-height // 4)
    blocks = np.frombuffer(image, np.dtype([("alpha", "<u8"), ("ends", "<u2", 2), ("picks", "<u4")]))
    texel = np.arange(16, dtype=np.uint64)
    alpha = (blocks["alpha"][:, None] >> (4 * texel) & np.uint64(15)).astype(np.uint8) * np.uint8(17)
    ends = blocks["ends"].astype(np.int32)
    r, g, b = ends >> 11, ends >> 5 & 63, ends & 31
    rgb = np.stack([r << 3 | r >> 2, g << 2 | g >> 4, b << 3 | b >> 2], -1)
    first, second = rgb[:, 0], rgb[:, 1]
    palette = np.stack([first, second, (2 * first + second + 1) // 3, (first + 2 * second + 1) // 3], 1)
    picks = (blocks["picks"][:, None] >> (2 * texel.astype(np.uint32)) & 3).astype(np.intp)
    out = np.empty((len(blocks), 16, 4), np.uint8)
    out[..., :3] = np.take_along_axis(palette, picks[..., None], 1)
    out[..., 3] = alpha
    tiles = out.reshape(rows, columns, 4, 4, 4).swapaxes(1, 2)
    return np.ascontiguousarray(tiles.reshape(rows * 4, columns * 4, 4)[:height, :width])
