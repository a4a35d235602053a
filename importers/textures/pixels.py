"""Textures back to pixels: any format of ours, one image at a time. Blocks are decoded by Pillow.

level_pixels(texture, layer, level) -> u1 or f4 [h,w,c] as stored
texture_picture(file, normal)       -> PNG bytes of mip 0, normals with their z rebuilt
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.assets.dds import read_dds
from engine.assets.texture import FORMATS, TextureAsset, mip_extent
from engine.core.errors import FormatError

#: format -> (Pillow's number of the block format, its mode, channels that mean something)
_BLOCKS = {
    "bc1": (1, "RGBA", 4),
    "bc3": (3, "RGBA", 4),
    "bc4": (4, "L", 1),
    "bc5": (5, "RGB", 2),
    "bc7": (7, "RGBA", 4),
}


def level_pixels(texture: TextureAsset, layer: int = 0, level: int = 0) -> NDArray[Any]:
    """u1[h,w,c] or f4[h,w,c] of one image (the first slice of a volume), c = 1, 2 or 4, as stored (sRGB stays so).

    Raises FormatError for BC6H, which nothing here decodes."""
    width, height = mip_extent(texture.width, level), mip_extent(texture.height, level)
    base = texture.format.removesuffix("-srgb")
    data = bytes(texture.levels[layer][level])
    if base in _BLOCKS:
        from PIL import Image

        number, mode, channels = _BLOCKS[base]
        wide, high = -(-width // 4) * 4, -(-height // 4) * 4
        blocks = data[: wide * high // 16 * FORMATS[base][1]]
        image = np.asarray(Image.frombytes(mode, (wide, high), blocks, "bcn", (number, base.upper())))
        image = image.reshape(high, wide, -1)[:height, :width, :channels]
        return np.ascontiguousarray(image)
    if base == "bc6h":
        raise FormatError("BC6H cannot be decoded here", hint="use the source image, or convert without compression")
    kind = {"8": "u1", "16f": "<f2", "32f": "<f4"}[base.lstrip("rgba")]
    channels = len(base) - len(base.lstrip("rgba"))
    size = width * height * channels
    array: NDArray[Any] = np.frombuffer(data, kind, size).reshape(height, width, channels)
    return array if kind == "u1" else array.astype(np.float32)


def rgba_pixels(texture: TextureAsset, layer: int = 0, level: int = 0) -> NDArray[Any]:
    """The same as u1[h,w,4] (grey spread over r, g, b; two channels as r and g) or f4[h,w,3] of floats."""
    found = level_pixels(texture, layer, level)
    height, width, channels = found.shape
    if found.dtype != np.uint8:
        return found[..., :3] if channels >= 3 else np.repeat(found[..., :1], 3, axis=2)
    out = np.full((height, width, 4), 255, np.uint8)
    if channels == 2:
        out[..., :2], out[..., 2] = found, 0
    else:
        out[..., : max(channels, 3)] = found
    return out


def texture_picture(file: Path, normal: bool = False) -> bytes:
    """Mip 0 of a .dds as a PNG file. `normal`: two channels are x and y of unit vectors. Raises InputError."""
    from importers.textures.png import png_bytes

    texture = read_dds(file)
    found = level_pixels(texture)
    if normal and found.shape[2] == 2:
        xy = found.astype(np.float64) / 127.5 - 1.0
        z = np.sqrt(np.maximum(1.0 - (xy * xy).sum(axis=2), 0.0))
        blue = np.rint((z + 1.0) * 127.5).astype(np.uint8)
        return png_bytes(np.concatenate([found, blue[..., None]], axis=2))
    return png_bytes(rgba_pixels(texture))
