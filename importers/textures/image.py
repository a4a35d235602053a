"""Image files -> pixels. The header is read and the size checked before anything is decoded.

Nothing in the file decides its colour space: no gAMA, iCCP or EXIF is looked at; the role the image is used for does
(encode.py). EXIF orientation is ignored for textures, whose coordinates were made for the stored pixels; lone images
are turned upright (`upright`).

    .hdr .exr         hdr.py        .psd .psb                psd.py
    .dds .ktx2        pixels.py, ktx2.py (mip 0, layer 0)    16-bit colour .png   png16.py
    deep .tif         tifffile      everything else          Pillow
"""

from __future__ import annotations

import io
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageOps

from engine.assets.dds import MAGIC as DDS_MAGIC
from engine.assets.dds import parse_dds
from engine.assets.texture import TextureAsset
from engine.core.errors import InputError, LucarnaError, Place
from importers.settings import ImportSettings
from importers.textures import hdr, ktx2, png16, psd
from importers.textures.pixels import rgba_pixels

#: what Pillow may open: no plugin that starts a program (EPS) or reads other files
FORMATS = ("PNG", "JPEG", "WEBP", "TGA", "BMP", "DIB", "GIF", "TIFF", "PPM", "PCX", "SGI", "DDS", "JPEG2000", "QOI",
           "AVIF", "ICO")  # fmt: skip

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
    flat = psd.probe(data)
    if flat:
        return ImageInfo("PSD", flat[1], flat[2], flat[0])
    if ktx2.is_ktx2(data):
        header = ktx2.read_header(data, place)
        return ImageInfo("KTX2", header.width, header.height, header.format_name)
    if data[:4] == DDS_MAGIC:
        texture = parse_dds(memoryview(data), place)
        return ImageInfo("DDS", texture.width, texture.height, texture.format)
    deep = _deep_size(data)
    if deep:
        return ImageInfo("TIFF", *deep)
    with _open(data, place) as image:
        return ImageInfo(image.format or "?", image.width, image.height, image.mode)


def decode(data: bytes, place: str, settings: ImportSettings, *, upright: bool = False) -> Pixels:
    """The pixels, row 0 at the top: u1[h,w,4], u2[h,w,4] from 16-bit files, f4[h,w,3] from float ones.

    Straight alpha, opaque where the file has none; grey is spread over r, g and b. Raises InputError when it is no
    image, is damaged, or has more pixels than `settings.max_image_pixels`.
    """
    radiance = hdr.probe(data)
    if radiance:
        _check_size(radiance[1], radiance[2], place, settings)
        return hdr.decode(data, place)
    texture = stored_texture(data, place, settings)
    if texture is not None and texture.format != "bc6h":
        return rgba_pixels(texture)
    special = psd.probe(data)
    if special:
        _check_size(special[1], special[2], place, settings)
        return _guarded(psd.decode_psd, data, place)
    if png16.is_deep_color(data):
        info = probe(data, place)
        _check_size(info.width, info.height, place, settings)
        return _guarded(png16.decode_png16, data, place)
    deep = _deep_size(data)
    if deep:
        _check_size(deep[0], deep[1], place, settings)
        return _guarded(_deep_tiff, data, place)
    with _open(data, place) as image:
        _check_size(image.width, image.height, place, settings)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # what Pillow finds odd and still reads is no matter here
                image.load()
                return _to_rgba(ImageOps.exif_transpose(image) if upright else image)
        except Exception as error:  # Pillow's plugins raise anything on damaged files (SyntaxError, struct.error, ...)
            raise InputError(f"the image is damaged: {error}", where=Place(place), hint="export it again") from error


def stored_texture(data: bytes, place: str, settings: ImportSettings) -> TextureAsset | None:
    """The whole texture of a .dds or .ktx2 file, mips and layers as stored; None for other files.

    Raises InputError, FormatError."""
    if ktx2.is_ktx2(data):
        header = ktx2.read_header(data, place)
        _check_size(header.width, header.height, place, settings)
        return ktx2.read_ktx2(data, place, settings.max_decoded_bytes)
    if data[:4] == DDS_MAGIC:
        texture = parse_dds(memoryview(data), place)
        _check_size(texture.width, texture.height, place, settings)
        return texture
    return None


def _guarded(read: Callable[[bytes], Pixels], data: bytes, place: str) -> Pixels:
    """Our own readers' and tifffile's ways to fail, as InputError."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return read(data)
    except LucarnaError:
        raise
    except Exception as error:  # zlib, struct, index and value errors of damaged files, and tifffile's own
        raise InputError(f"the image is damaged: {error}", where=Place(place), hint="export it again") from error


def _deep_size(data: bytes) -> tuple[int, int, str] | None:
    """(width, height, sample type) of a TIFF with more than Pillow gives: 16 or 32 bits, floats; else None."""
    if data[:4] not in (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"):
        return None
    import logging

    import tifffile  # for TIFF only

    logging.getLogger("tifffile").disabled = True  # what it finds odd and still reads is no matter here

    try:
        with tifffile.TiffFile(io.BytesIO(data)) as file:
            page: Any = file.pages[0]
            # what tifffile unpacks by itself: none, deflate, PackBits
            plain = int(page.compression) in (1, 8, 32946, 32773)
            deep = plain and page.dtype is not None and (page.dtype.kind == "f" or page.dtype.itemsize > 1)
            return (int(page.imagewidth), int(page.imagelength), str(page.dtype)) if deep else None
    except Exception:  # whatever tifffile cannot read may still be Pillow's; it has the last word
        return None


def _deep_tiff(data: bytes) -> Pixels:
    import tifffile

    with tifffile.TiffFile(io.BytesIO(data)) as file:
        page: Any = file.pages[0]
        image = np.asarray(page.asarray())
        if page.planarconfig == 2 and image.ndim == 3:
            image = np.moveaxis(image, 0, -1)
    image = image.reshape(*image.shape[:2], -1)
    channels = image.shape[2]
    if image.dtype.kind == "f":
        wide = image[..., :3] if channels >= 3 else np.repeat(image[..., :1], 3, axis=2)
        finite = np.nan_to_num(wide.astype(np.float32), nan=0.0, posinf=3.4e38, neginf=0.0)
        return np.maximum(finite, np.float32(0.0))
    if image.dtype == np.uint32:
        image = (image >> np.uint32(16)).astype(np.uint16)
    if image.dtype != np.uint16:
        raise ValueError(f"a TIFF of {image.dtype} is not supported")
    out = np.full((*image.shape[:2], 4), 65535, np.uint16)
    out[..., :3] = image[..., :3] if channels >= 3 else image[..., :1]
    if channels in (2, 4):
        out[..., 3] = image[..., -1]
    return out


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
        hint = "use PNG, JPEG, TGA, BMP, TIFF, WebP, PSD, DDS, KTX2, HDR or EXR"
        raise InputError("is no image that can be read", where=Place(place), hint=hint) from error


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
        grey = np.nan_to_num(np.asarray(image), nan=0.0, posinf=3.4e38, neginf=0.0)
        return np.repeat(np.maximum(grey, np.float32(0.0))[..., None], 3, axis=2)
    # Pillow makes RGBA of every other mode: palettes with transparency, LA, CMYK (naively), 1-bit.
    return np.array(image if image.mode == "RGBA" else image.convert("RGBA"))
