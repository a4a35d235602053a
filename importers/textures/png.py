"""PNG files from pixels: lossless, and the same bytes for the same pixels."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
from numpy.typing import NDArray


def png_bytes(pixels: NDArray[Any]) -> bytes:
    """A PNG of u1, u2 or f4 [h,w,c]: 16 bits become 8, rounded; floats are linear light and encoded as sRGB.

    Alpha is left out where it is opaque throughout."""
    from PIL import Image

    if pixels.dtype.kind == "f":
        from engine.math.color import to_u1

        pixels = to_u1(pixels)
    elif pixels.dtype == np.uint16:
        pixels = ((pixels.astype(np.uint32) * 255 + 32767) // 65535).astype(np.uint8)
    if pixels.shape[2] == 4 and bool((pixels[..., 3] == 255).all()):
        pixels = pixels[..., :3]
    file = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(pixels)).save(file, "PNG", compress_level=6)
    return file.getvalue()
