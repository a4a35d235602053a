"""Decoding: every mode becomes the promised array, limits hold before decoding, damage gives our errors only."""

from __future__ import annotations

import io
import random
import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from engine.core.errors import InputError, LucarnaError
from importers.settings import ImportSettings
from importers.textures import hdr
from importers.textures.image import decode, probe

SETTINGS = ImportSettings()


def saved(image: Image.Image, format: str = "PNG", **options: object) -> bytes:
    out = io.BytesIO()
    image.save(out, format, **options)
    return out.getvalue()


def test_modes_become_rgba8() -> None:
    rgb = Image.new("RGB", (3, 2), (10, 20, 30))
    for image, want in (
        (rgb, (10, 20, 30, 255)),
        (Image.new("RGBA", (3, 2), (1, 2, 3, 0)), (1, 2, 3, 0)),
        (Image.new("L", (3, 2), 7), (7, 7, 7, 255)),
        (Image.new("LA", (3, 2), (7, 9)), (7, 7, 7, 9)),
        (rgb.quantize(4), (10, 20, 30, 255)),
        (Image.new("1", (3, 2), 1), (255, 255, 255, 255)),
    ):
        pixels = decode(saved(image), "i", SETTINGS)
        assert (pixels.shape, pixels.dtype) == ((2, 3, 4), np.uint8)
        assert tuple(pixels[1, 2]) == want
    cmyk = decode(saved(Image.new("CMYK", (8, 8), (0, 255, 0, 0)), "JPEG", quality=100), "i", SETTINGS)
    assert cmyk[0, 0, 0] > 200
    assert cmyk[0, 0, 1] < 60


def test_palette_with_transparency() -> None:
    image = Image.new("P", (2, 2), 1)
    image.putpalette([0, 0, 0, 9, 8, 7])
    pixels = decode(saved(image, transparency=1), "i", SETTINGS)
    assert tuple(pixels[0, 0]) == (9, 8, 7, 0)


def test_sixteen_bits_stay() -> None:
    grey = np.array([[0, 1000], [40000, 65535]], np.uint16)
    pixels = decode(saved(Image.fromarray(grey)), "i", SETTINGS)
    assert pixels.dtype == np.uint16
    np.testing.assert_array_equal(pixels[..., 1], grey)
    assert (pixels[..., 3] == 65535).all()


def test_file_says_nothing_about_colour_or_turning() -> None:
    plain = Image.new("RGB", (4, 2), (100, 150, 200))
    gamma = saved(plain)
    chunk = b"gAMA" + struct.pack(">I", 100000)
    gamma = gamma[:33] + struct.pack(">I", 4) + chunk + struct.pack(">I", zlib.crc32(chunk)) + gamma[33:]
    np.testing.assert_array_equal(decode(gamma, "i", SETTINGS), decode(saved(plain), "i", SETTINGS))
    exif = Image.Exif()
    exif[0x0112] = 6
    assert decode(saved(plain, "JPEG", exif=exif), "i", SETTINGS).shape == (2, 4, 4)


def test_probe_reads_the_header() -> None:
    info = probe(saved(Image.new("RGB", (4, 2))))
    assert (info.format, info.width, info.height, info.mode) == ("PNG", 4, 2, "RGB")


def test_pixel_budget_comes_before_decoding(shared_assets: Path) -> None:
    with pytest.raises(InputError, match="at most 16 pixels"):
        decode(saved(Image.new("RGB", (5, 4))), "i", SETTINGS.replace(max_image_pixels=16))
    bomb = (shared_assets / "malformed" / "bomb_claim.png").read_bytes()
    with pytest.raises(InputError):
        decode(bomb, "bomb", SETTINGS)


def test_damaged_images_raise_only_our_errors() -> None:
    picture = Image.fromarray(np.random.default_rng(1).integers(0, 255, (16, 16, 3), np.uint8))
    rng = random.Random(3)
    for format in ("PNG", "JPEG", "TGA", "BMP", "WEBP", "GIF", "TIFF"):
        good = saved(picture, format)
        for trial in range(40):
            bad = bytearray(good)
            for _ in range(3):
                bad[rng.randrange(len(bad))] = rng.randrange(256)
            if trial % 3 == 0:
                del bad[rng.randrange(len(bad)) :]
            try:
                decode(bytes(bad), "i", SETTINGS.replace(max_image_pixels=1 << 20))
            except LucarnaError:
                continue
    for junk in (b"", b"\x00" * 40, b"%!PS-Adobe-3.0 EPSF-3.0\n", b"\xabKTX 20\xbb\r\n\x1a\n"):
        with pytest.raises(InputError):
            decode(junk, "i", SETTINGS)


def rgbe(lines: bytes, size: bytes = b"-Y 2 +X 8\n", header: bytes = b"FORMAT=32-bit_rle_rgbe\n") -> bytes:
    return b"#?RADIANCE\n" + header + b"\n" + size + lines


TEXELS = bytes([128, 64, 0, 129]) * 8 + bytes([0, 0, 0, 0]) * 8
VALUE = [(m + 0.5) * 2.0 ** (129 - 136) for m in (128, 64, 0)]


def test_rgbe_flat_and_both_run_lengths() -> None:
    flat = hdr.decode(rgbe(TEXELS), "i")
    assert flat.shape == (2, 8, 3)
    np.testing.assert_allclose(flat[0, 3], VALUE)
    assert (flat[1] == 0).all()
    new = b"".join(
        bytes([2, 2, 0, 8]) + b"".join(bytes([128 + 5, v, 3, v, v, v]) for v in line)
        for line in ((128, 64, 0, 129), (0, 0, 0, 0))
    )
    np.testing.assert_array_equal(hdr.decode(rgbe(new), "i"), flat)
    old = bytes([128, 64, 0, 129, 1, 1, 1, 7, 0, 0, 0, 0, 1, 1, 1, 7])
    np.testing.assert_array_equal(hdr.decode(rgbe(old), "i"), flat)


def test_rgbe_order_and_exposure() -> None:
    np.testing.assert_allclose(hdr.decode(rgbe(TEXELS, b"+Y 2 +X 8\n"), "i")[1, 0], VALUE)
    half = hdr.decode(rgbe(TEXELS, header=b"FORMAT=32-bit_rle_rgbe\nEXPOSURE=2.0\n"), "i")
    np.testing.assert_allclose(half[0, 0], np.array(VALUE) / 2)


def test_damaged_rgbe_raises_only_our_errors() -> None:
    good = rgbe(b"".join(bytes([2, 2, 0, 8]) + bytes([136, 9]) * 4 for _ in range(2)))
    rng = random.Random(4)
    for _ in range(400):
        bad = bytearray(good)
        bad[rng.randrange(len(bad))] = rng.randrange(256)
        try:
            decode(bytes(bad), "i", SETTINGS)
        except LucarnaError:
            continue
    with pytest.raises(InputError, match="claims"):
        decode(rgbe(b"", b"-Y 9999 +X 9999\n"), "i", SETTINGS)


def test_exr(tmp_path: Path) -> None:
    import OpenEXR

    rgb = np.random.default_rng(0).random((4, 6, 3)).astype(np.float32) * 50
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, {"RGB": rgb}).write(str(tmp_path / "a.exr"))
    data = (tmp_path / "a.exr").read_bytes()
    np.testing.assert_array_equal(decode(data, "i", SETTINGS), rgb)
    assert probe(data).format == "EXR"
    with pytest.raises(InputError):
        decode(data, "i", SETTINGS.replace(max_image_pixels=20))
    with pytest.raises(InputError):
        decode(data[:200], "i", SETTINGS)


def test_radiance_of_plain_images_is_linear(tmp_path: Path) -> None:
    (tmp_path / "a.png").write_bytes(saved(Image.new("RGB", (2, 1), (188, 255, 0))))
    np.testing.assert_allclose(hdr.load_radiance(tmp_path / "a.png")[0, 0], [0.503, 1.0, 0.0], atol=1e-3)
