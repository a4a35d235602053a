"""Radiance from files: .hdr (RGBE, own reader), .exr (OpenEXR), DDS cubes, and plain images as sRGB.

RGBE: Ward 1991, "Real Pixels", Graphics Gems II: value = (mantissa + 0.5) * 2^(exponent - 136).
"""

from __future__ import annotations

import math
import re
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.assets.dds import read_dds
from engine.assets.mapping import map_file
from engine.assets.texture import TextureAsset
from engine.core.errors import FormatError, InputError, Place
from importers.settings import ImportSettings

Floats = NDArray[np.float32]

_EXR_MAGIC = b"\x76\x2f\x31\x01"
_SIZE = re.compile(rb"([-+])Y (\d{1,6}) ([-+])X (\d{1,6})\n")
MAX_HEADER = 1 << 16


def probe(data: bytes) -> tuple[str, int, int] | None:
    """("HDR" | "EXR", width, height) where `data` is one of these, else None."""
    if data[:2] == b"#?":
        found = _SIZE.search(data[:MAX_HEADER])
        return ("HDR", int(found.group(4)), int(found.group(2))) if found else None
    if data[:4] == _EXR_MAGIC:
        at = data[:MAX_HEADER].find(b"dataWindow\x00box2i\x00")
        if at >= 0 and len(data) >= at + 37:
            x0, y0, x1, y1 = np.frombuffer(data, "<i4", 4, at + 21).tolist()
            return "EXR", x1 - x0 + 1, y1 - y0 + 1
    return None


def decode(data: bytes, place: str) -> Floats:
    """f4[h,w,3] from the bytes of an .hdr or .exr file, finite and not negative. Raises FormatError."""
    image = _stored(data, place)
    finite = np.nan_to_num(image, nan=0.0, posinf=3.4e38, neginf=0.0)
    return np.maximum(finite, np.float32(0.0))


def bad_texels(data: bytes, place: str) -> int:
    """How many texels of an .hdr or .exr file `decode` mends: not a number, infinite, negative. Raises FormatError."""
    image = _stored(data, place)
    return int(np.count_nonzero(~(np.isfinite(image) & (image >= 0.0)).all(axis=-1)))


def _stored(data: bytes, place: str) -> Floats:
    return _rgbe(data, place) if data[:2] == b"#?" else _exr(data, place)


def load_radiance(path: Path, settings: ImportSettings | None = None) -> Floats:
    """Radiance from a file: f4[h,w,3] (equirectangular), or f4[6,n,n,3] from a DDS cube.

    .hdr and .exr as they are; other images are taken as sRGB. Raises InputError, FormatError.
    """
    if path.suffix.lower() == ".dds":
        return _cube(read_dds(path), str(path))
    from importers.textures.image import decode as decode_image  # it imports this module

    pixels = decode_image(bytes(map_file(path)), str(path), settings or ImportSettings())
    if pixels.dtype == np.float32:
        return pixels
    top = float(np.iinfo(pixels.dtype).max)
    value = pixels[..., :3].astype(np.float32) / np.float32(top)
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4).astype(np.float32)


_CUBE_DTYPES = {"rgba32f": ("<f4", 4), "rgba16f": ("<f2", 4), "rgba8": ("u1", 4), "rgba8-srgb": ("u1", 4)}


def _cube(texture: TextureAsset, file: str) -> Floats:
    if not texture.cube or texture.format not in _CUBE_DTYPES:
        raise FormatError(
            f"is {texture.format} with {texture.layers} layers, expected a cube of rgba8, rgba16f or rgba32f",
            where=file,
        )
    dtype, channels = _CUBE_DTYPES[texture.format]
    shape = (texture.height, texture.width, channels)
    faces = np.stack([np.frombuffer(texture.levels[f][0], dtype).reshape(shape)[..., :3] for f in range(6)])
    linear = faces.astype(np.float32)
    if dtype == "u1":
        linear /= 255.0
        if texture.format.endswith("-srgb"):
            linear = np.where(linear <= 0.04045, linear / 12.92, ((linear + 0.055) / 1.055) ** 2.4).astype(np.float32)
    return linear


def _rgbe(data: bytes, place: str) -> Floats:
    found = _SIZE.search(data[:MAX_HEADER])
    header = data[: found.start()] if found else data[:MAX_HEADER]
    if not found or b"32-bit_rle_xyze" in header:
        raise FormatError("is no RGBE picture: it has no size line, or its colours are XYZE", where=Place(place))
    width, height = int(found.group(4)), int(found.group(2))
    if width < 1 or height < 1 or width * height > 4 * 64 * len(data):
        # run-length coding packs at most 127 texels into 2 bytes per channel
        raise FormatError(f"claims {width}x{height} texels in {len(data)} bytes", where=Place(place))
    exposure = 1.0
    for value in re.findall(rb"^EXPOSURE=\s*([0-9.eE+-]{1,32})\s*$", header, re.MULTILINE):
        try:
            exposure *= float(value)
        except ValueError:
            continue
    try:
        rgbe = _scanlines(data, found.end(), width, height)
    except (IndexError, ValueError) as error:
        raise FormatError(f"the RGBE data is damaged: {error}", where=Place(place)) from error
    scale = np.ldexp(np.float32(1.0), rgbe[..., 3].astype(np.int32) - 136)
    image = (rgbe[..., :3].astype(np.float32) + np.float32(0.5)) * scale[..., None]
    image[rgbe[..., 3] == 0] = 0.0
    if math.isfinite(exposure) and exposure > 0.0:
        image /= np.float32(exposure)
    if found.group(1) == b"+":
        image = image[::-1]
    if found.group(3) == b"-":
        image = image[:, ::-1]
    return np.ascontiguousarray(image)


def _scanlines(data: bytes, at: int, width: int, height: int) -> NDArray[np.uint8]:
    """u1[h,w,4]; both run-length codings, told apart line by line as Radiance does."""
    out = np.empty((height, width, 4), np.uint8)
    for y in range(height):
        if 8 <= width < 32768 and data[at : at + 2] == b"\x02\x02" and data[at + 2] < 128:
            if data[at + 2] << 8 | data[at + 3] != width:
                raise ValueError(f"line {y} has another width")
            line, at = _new_line(data, at + 4, width, y)
            out[y] = line.T
        else:
            at = _old_line(data, at, out[y], y)
    return out


def _new_line(data: bytes, at: int, width: int, y: int) -> tuple[NDArray[np.uint8], int]:
    line = bytearray()
    for channel in range(4):
        end = (channel + 1) * width
        while len(line) < end:
            count = data[at]
            if count > 128:
                line += data[at + 1 : at + 2] * (count - 128)
                at += 2
            else:
                if count == 0:
                    raise ValueError(f"line {y} has an empty run")
                line += data[at + 1 : at + 1 + count]
                at += 1 + count
        if len(line) != end or at > len(data):
            raise ValueError(f"line {y} does not end where it should")
    return np.frombuffer(line, np.uint8).reshape(4, width), at


def _old_line(data: bytes, at: int, out: NDArray[np.uint8], y: int) -> int:
    width = len(out)
    if at + 4 * width <= len(data):
        flat = np.frombuffer(data, np.uint8, 4 * width, at).reshape(width, 4)
        if not (flat[:, :3] == 1).all(1).any():
            out[:] = flat
            return at + 4 * width
    x, shift = 0, 0
    while x < width:
        texel = data[at : at + 4]
        if len(texel) < 4:
            raise ValueError(f"line {y} is cut off")
        at += 4
        if texel[:3] == b"\x01\x01\x01":
            count = texel[3] << shift
            shift += 8
            if x == 0 or x + count > width or shift > 24:
                raise ValueError(f"line {y} has a bad run")
            out[x : x + count] = out[x - 1]
            x += count
        else:
            out[x] = np.frombuffer(texel, np.uint8)
            x += 1
            shift = 0
    return at


def _exr(data: bytes, place: str) -> Floats:
    import OpenEXR  # slow to import, and only .exr needs it

    # OpenEXR reads from a path only.
    with tempfile.TemporaryDirectory(prefix="lucarna-") as folder:
        path = Path(folder) / "image.exr"
        path.write_bytes(data)
        try:
            with OpenEXR.File(str(path), separate_channels=True) as file:
                channels: dict[str, Any] = {name: np.array(c.pixels) for name, c in file.channels().items()}
        except Exception as error:  # OpenEXR raises RuntimeError, ValueError and its own kinds
            raise InputError(f"the EXR is damaged: {error}", where=Place(place), hint="export it again") from error
    names = [n if n in channels else "Y" for n in ("R", "G", "B")]
    if any(n not in channels for n in names):
        raise FormatError(
            f"the EXR has channels {', '.join(sorted(channels))}; R G B or Y are needed", where=Place(place)
        )
    return np.stack([channels[n].astype(np.float32) for n in names], -1)
