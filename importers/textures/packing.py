"""Separate roughness (or gloss) and metalness images packed as one: G roughness, B metallic."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from importers.settings import ImportSettings
from importers.textures.image import decode
from importers.textures.mips import resample
from importers.textures.png import png_bytes


def pack_metal_rough(rough: bytes | None, metal: bytes | None, gloss: bool, settings: ImportSettings) -> bytes | None:
    """A PNG; a missing one counts as 1 throughout, so that the material's factor decides. `gloss`: turned over.

    None where neither is there. Raises InputError."""
    parts = [None if data is None else _first_channel(data, settings) for data in (rough, metal)]
    sizes = [part.shape for part in parts if part is not None]
    if not sizes:
        return None
    height, width = max(sizes, key=lambda size: size[0] * size[1])
    out = np.full((height, width, 3), 255, np.uint8)
    for channel, part in enumerate(parts, 1):
        if part is not None:
            fitted = part if part.shape == (height, width) else resample(part[..., None], width, height, "box")[..., 0]
            value = 1.0 - fitted if gloss and channel == 1 else fitted
            out[..., channel] = np.rint(np.clip(value, 0.0, 1.0) * 255.0)
    return png_bytes(out)


def _first_channel(data: bytes, settings: ImportSettings) -> NDArray[np.float32]:
    pixels = decode(data, "image", settings)[..., 0]
    if pixels.dtype.kind == "f":
        return np.asarray(pixels, np.float32)
    return np.asarray(pixels, np.float32) / np.float32(np.iinfo(pixels.dtype).max)
