"""Images that Pillow reads in part only: 16-bit PNG colours, deep TIFF, PSD, DDS and KTX2; EXIF for lone images."""

from __future__ import annotations

import io
import struct
import zlib
from typing import Any

import numpy as np
import pytest
import tifffile
from numpy.typing import NDArray
from PIL import Image

from engine.core.errors import InputError
from importers.settings import ImportSettings
from importers.textures.image import decode, probe

SETTINGS = ImportSettings()
rng = np.random.default_rng(5)


def png16(image: NDArray[np.uint16], filters: list[int], trns: bytes = b"") -> bytes:
    """A PNG of u2[h,w,c] with the given filter a line, by the letter of the specification."""
    height, width, channels = image.shape
    size = 2 * channels
    plain = image.astype(">u2").view(np.uint8).reshape(height, width * size).astype(int)

    def at(y: int, x: int) -> int:
        return int(plain[y, x]) if y >= 0 and x >= 0 else 0

    lines = bytearray()
    for y, kind in enumerate(filters):
        lines.append(kind)
        for x in range(width * size):
            a, b, c = at(y, x - size), at(y - 1, x), at(y - 1, x - size)
            p = a + b - c
            nearest = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
            lines.append((at(y, x) - [0, a, b, (a + b) // 2, nearest][kind]) % 256)

    def chunk(kind: bytes, body: bytes) -> bytes:
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    head = struct.pack(">2I5B", width, height, 16, {1: 0, 2: 4, 3: 2, 4: 6}[channels], 0, 0, 0)
    extra = chunk(b"tRNS", trns) if trns else b""
    body = chunk(b"IHDR", head) + extra + chunk(b"IDAT", zlib.compress(bytes(lines))) + chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + body


@pytest.mark.parametrize("channels", [2, 3, 4])
def test_png_of_sixteen_bits_with_every_filter(channels: int) -> None:
    image = rng.integers(0, 65536, (7, 5, channels), np.uint16)
    data = png16(image, [4, 1, 2, 3, 4, 0, 4])
    pixels = decode(data, "p", SETTINGS)
    assert pixels.dtype == np.uint16
    np.testing.assert_array_equal(pixels[..., 3], image[..., -1] if channels != 3 else 65535)
    np.testing.assert_array_equal(pixels[..., :3], image[..., :3] if channels > 2 else image[..., :1].repeat(3, 2))
    for broken in (data[:-40], data[:60], data[:41] + b"\xff" + data[42:]):
        with pytest.raises(InputError):
            decode(broken, "p", SETTINGS)


def test_png_transparent_color_of_sixteen_bits() -> None:
    image = np.full((2, 2, 3), 1000, np.uint16)
    image[0, 1] = [7, 8, 9]
    pixels = decode(png16(image, [0, 2], struct.pack(">3H", 7, 8, 9)), "p", SETTINGS)
    assert pixels[..., 3].tolist() == [[65535, 0], [65535, 65535]]


@pytest.mark.parametrize(("shape", "dtype"), [((3, 4, 3), "u2"), ((3, 4, 4), "u2"), ((3, 4, 3), "f4"), ((3, 4), "f4")])
@pytest.mark.parametrize("packing", [None, "deflate"])
def test_deep_tiff(shape: tuple[int, ...], dtype: str, packing: str | None) -> None:
    image = (rng.random(shape) * (60000 if dtype == "u2" else 8)).astype(dtype)
    file = io.BytesIO()
    tifffile.imwrite(file, image, compression=packing, photometric="rgb" if len(shape) == 3 else "minisblack")
    pixels = decode(file.getvalue(), "t", SETTINGS)
    assert pixels.dtype == (np.uint16 if dtype == "u2" else np.float32)
    wanted = image if len(shape) == 3 else image[..., None].repeat(3, 2)
    np.testing.assert_array_equal(pixels[..., : wanted.shape[2]], wanted)


def psd(planes: NDArray[Any], mode: int = 3, packed: bool = False, palette: bytes = b"") -> bytes:
    """A PSD of [c,h,w] with nothing but its composite."""
    channels, height, width = planes.shape
    big = planes.astype(planes.dtype.newbyteorder(">"))
    depth = planes.dtype.itemsize * 8
    head = b"8BPS" + struct.pack(">H6xH2I2H", 1, channels, height, width, depth, mode)
    head += struct.pack(">I", len(palette)) + palette + bytes(8)
    if not packed:
        return head + struct.pack(">H", 0) + big.tobytes()
    lines = []
    for line in big.reshape(channels * height, width):
        raw = line.tobytes()
        same = len(set(raw)) == 1
        lines.append(bytes([257 - len(raw), raw[0]]) if same else bytes([len(raw) - 1]) + raw)
    return head + struct.pack(">H", 1) + b"".join(struct.pack(">H", len(x)) for x in lines) + b"".join(lines)


@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize("dtype", ["u1", "u2"])
def test_psd(dtype: str, packed: bool) -> None:
    top = np.iinfo(dtype).max
    planes = rng.integers(0, top, (4, 3, 5)).astype(dtype)
    planes[1] = 9
    pixels = decode(psd(planes, packed=packed), "p", SETTINGS)
    assert pixels.dtype == np.dtype(dtype)
    np.testing.assert_array_equal(pixels, np.moveaxis(planes, 0, -1))
    grey = decode(psd(planes[:1], 1, packed), "p", SETTINGS)
    np.testing.assert_array_equal(grey[..., 2], planes[0])
    assert (grey[..., 3] == top).all()


def test_psd_floats_ink_palette_and_damage() -> None:
    floats = rng.random((3, 2, 2)).astype(np.float32)
    np.testing.assert_array_equal(decode(psd(floats), "p", SETTINGS), np.moveaxis(floats, 0, -1))
    ink = np.array([255, 0, 255, 255], np.uint8).reshape(4, 1, 1)  # full magenta
    assert decode(psd(ink, 4), "p", SETTINGS)[0, 0].tolist() == [255, 0, 255, 255]
    table = np.zeros((3, 256), np.uint8)
    table[:, 4] = [1, 2, 3]
    indexed = decode(psd(np.full((1, 1, 1), 4, np.uint8), 2, palette=table.tobytes()), "p", SETTINGS)
    assert indexed[0, 0].tolist() == [1, 2, 3, 255]
    good = psd(np.zeros((3, 4, 4), np.uint8), packed=True)
    assert (probe(good).format, probe(good).width) == ("PSD", 4)
    for broken in (good[:-1], good[:30], psd(np.zeros((3, 4, 4), np.uint8), 9), good[:12] + b"\0\0" + good[14:]):
        with pytest.raises(InputError):
            decode(broken, "p", SETTINGS)
    huge = good[:14] + struct.pack(">2I", 300000, 300000) + good[22:]
    with pytest.raises(InputError, match="at most"):
        decode(huge, "p", SETTINGS)


def test_lone_images_stand_upright() -> None:
    image = Image.new("RGB", (3, 2), (0, 0, 0))
    image.putpixel((0, 0), (255, 0, 0))
    exif = Image.Exif()
    exif[0x0112] = 6  # to be turned a quarter clockwise
    file = io.BytesIO()
    image.save(file, "PNG", exif=exif)
    assert decode(file.getvalue(), "i", SETTINGS).shape == (2, 3, 4)
    turned = decode(file.getvalue(), "i", SETTINGS, upright=True)
    assert turned.shape == (3, 2, 4)
    assert turned[0, 1].tolist() == [255, 0, 0, 255]


@pytest.mark.parametrize(
    ("format", "mode"), [("TGA", "RGBA"), ("BMP", "RGB"), ("WEBP", "RGBA"), ("TIFF", "RGB"), ("GIF", "P")]
)
def test_everyday_formats(format: str, mode: str) -> None:
    image = Image.new("RGBA", (6, 4), (10, 200, 30, 255))
    file = io.BytesIO()
    image.convert(mode).save(file, format, **({"lossless": True} if format == "WEBP" else {}))
    pixels = decode(file.getvalue(), "i", SETTINGS)
    assert pixels.shape == (4, 6, 4)
    assert np.abs(pixels[2, 3].astype(int) - [10, 200, 30, 255]).max() <= (8 if mode == "P" else 0)


def test_progressive_jpeg() -> None:
    file = io.BytesIO()
    Image.new("RGB", (16, 8), (90, 160, 40)).save(file, "JPEG", progressive=True, quality=95)
    assert np.abs(decode(file.getvalue(), "i", SETTINGS)[4, 9].astype(int) - [90, 160, 40, 255]).max() <= 3
