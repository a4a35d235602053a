"""Image files -> pixels. The header is read and the size checked before anything is decoded.

Nothing in the file decides its colour space: no gAMA, iCCP or EXIF is looked at; the role the image is used for does
(encode.py). EXIF orientation is ignored too, since texture coordinates were made for the stored pixels.
"""

from __future__ import annotations

import io
import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from engine.core.errors import InputError, Place
from importers.settings import ImportSettings
from importers.textures import hdr

#: what Pillow may open: no plugin that starts a program (EPS) or reads other files
FORMATS = ("PNG", "JPEG", "WEBP", "TGA", "BMP", "DIB", "GIF", "TIFF", "PPM", "PCX", "SGI", "DDS", "JPEG2000", "QOI")

Pixels = NDArray[Any]


@dataclass(frozen=True, slots=True)
class ImageInfo:
    """What the header says. `mode` is Pillow's, or `float` for .hdr and .exr."""

    format: str
    width: int
    height: int
    mode: str


def probe(data: bytes, place: str = "image") -> ImageInfo:
    """Read the header only. Raises InputError when it is no image that we know."""
    radiance = hdr.probe(data)
    if radiance:
        return ImageInfo(radiance[0], radiance[1], radiance[2], "float")
    with _open(data, place) as image:
        return ImageInfo(image.format or "?", image.width, image.height, image.mode)


def decode(data: bytes, place: str, settings: ImportSettings) -> Pixels:
    """The pixels, row 0 at the top: u1[h,w,4], u2[h,w,4] from 16-bit files, f4[h,w,3] from .hdr and .exr.

    Straight alpha, opaque where the file has none; grey is spread over r, g and b. Raises InputError when it is no
    image, is damaged, or has more pixels than `settings.max_image_pixels`.
    """
    radiance = hdr.probe(data)
    if radiance:
        _check_size(radiance[1], radiance[2], place, settings)
        return hdr.decode(data, place)
    with _open(data, place) as image:
        _check_size(image.width, image.height, place, settings)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # what Pillow finds odd and still reads is no matter here
                image.load()
                return _to_rgba(image)
        except Exception as error:  # Pillow's plugins raise anything on damaged files (SyntaxError, struct.error, ...)
            raise InputError(f"the image is damaged: {error}", where=Place(place), hint="export it again") from error


def _open(data: bytes, place: str) -> Image.Image:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # DecompressionBombWarning: _check_size is stricter
            limit, Image.MAX_IMAGE_PIXELS = Image.MAX_IMAGE_PIXELS, None
            try:
                return Image.open(io.BytesIO(data), formats=FORMATS)
            finally:
                Image.MAX_IMAGE_PIXELS = limit
    except Exception as error:  # as in decode
        kind = "a KTX2 texture" if data[1:7] == b"KTX 20" else "no image that can be read"
        hint = "use PNG, JPEG, TGA, WebP, DDS, HDR or EXR"
        raise InputError(f"is {kind}", where=Place(place), hint=hint) from error


def _check_size(width: int, height: int, place: str, settings: ImportSettings) -> None:
    if width < 1 or height < 1 or width * height > settings.max_image_pixels:
        raise InputError(
            f"the image is {width}x{height}; at most {settings.max_image_pixels} pixels are decoded",
            where=Place(place),
            hint="scale it down, or raise max_image_pixels",
        )


def _to_rgba(image: Image.Image) -> Pixels:
    if image.mode.startswith("I;16") or image.mode == "I":
        grey = np.asarray(image)
        if grey.dtype != np.uint16:
            grey = np.clip(grey, 0, 65535).astype(np.uint16)
        out = np.full((*grey.shape, 4), 65535, np.uint16)
        out[..., :3] = grey[..., None]
        return out
    if image.mode == "F":
        raise ValueError("a float TIFF is not supported; use .exr or .hdr")
    # Pillow makes RGBA of every other mode: palettes with transparency, LA, CMYK (naively), 1-bit.
    return np.array(image if image.mode == "RGBA" else image.convert("RGBA"))
