"""Encoding: what each role becomes, quality against an independent decoder, and the same bytes on any thread count."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import texture2ddecoder
from numpy.typing import NDArray

from engine.assets.dds import check_texture, read_dds, write_dds
from engine.core.errors import UsageError
from importers.settings import ImportSettings
from importers.textures.blocks import encode_blocks, pad_to_blocks
from importers.textures.encode import ROLES, encode

SETTINGS = ImportSettings()


def picture(w: int, h: int, alpha: bool = False) -> NDArray[np.uint8]:
    """Smooth gradients with some texture, as photographs have."""
    y, x = np.mgrid[0:h, 0:w].astype(np.float64)
    rng = np.random.default_rng(9)
    r = 128 + 90 * np.sin(x / 17) * np.cos(y / 23)
    g = 110 + 80 * np.cos((x + y) / 31)
    b = 90 + 60 * np.sin(y / 11)
    pixels = np.stack([r, g, b, np.full_like(r, 255)], -1)
    pixels[..., :3] += rng.normal(0, 3, (h, w, 1))
    if alpha:
        pixels[..., 3] = 127 + 120 * np.sin(x / 9)
    return np.clip(pixels, 0, 255).astype(np.uint8)


def normals(w: int, h: int) -> NDArray[np.uint8]:
    y, x = np.mgrid[0:h, 0:w].astype(np.float64)
    v = np.stack([0.4 * np.sin(x / 9), 0.4 * np.cos(y / 13), np.ones_like(x)], -1)
    v /= np.linalg.norm(v, axis=-1, keepdims=True)
    out = np.full((h, w, 4), 255, np.uint8)
    out[..., :3] = np.round(v * 127.5 + 127.5)
    return out


def decoded(name: str, data: Any, w: int, h: int) -> NDArray[np.uint8]:
    """rgba by texture2ddecoder, which gives bgra."""
    raw = getattr(texture2ddecoder, f"decode_{name}")(bytes(data), w, h)
    return np.frombuffer(raw, np.uint8).reshape(h, w, 4)[..., [2, 1, 0, 3]]


def psnr(a: Any, b: Any) -> float:
    return float(10 * np.log10(255**2 / max(1e-9, np.mean((a.astype(float) - b.astype(float)) ** 2))))


@pytest.mark.parametrize(
    ("role", "format", "plain"),
    [
        ("color", "bc7-srgb", "rgba8-srgb"), ("emissive", "bc7-srgb", "rgba8-srgb"), ("normal", "bc5", "rg8"),
        ("metal_rough", "bc7", "rgba8"), ("data", "bc7", "rgba8"), ("occlusion", "bc4", "r8"), ("mask", "bc4", "r8"),
        ("hdr", "bc6h", "rgba16f"),
    ],
)  # fmt: skip
@pytest.mark.parametrize(("w", "h"), [(1, 1), (33, 17), (64, 64), (1021, 3)])
def test_roles_and_sizes(role: str, format: str, plain: str, w: int, h: int) -> None:
    pixels: Any = picture(w, h) if role != "hdr" else picture(w, h)[..., :3].astype(np.float32)
    for settings, want in ((SETTINGS, format), (SETTINGS.replace(compress=False), plain)):
        texture = encode(pixels, role, settings)
        check_texture(texture)
        assert (texture.format, texture.width, texture.height) == (want, w, h)
        assert texture.mip_count == max(w, h).bit_length()


def test_unknown_role() -> None:
    assert "color" in ROLES
    with pytest.raises(UsageError, match="did you mean 'color'"):
        encode(picture(4, 4), "colour", SETTINGS)


@pytest.mark.parametrize(("preset", "low"), [("draft", 40.0), ("normal", 40.0), ("high", 43.0), ("final", 43.0)])
def test_colour_quality(preset: str, low: float) -> None:
    pixels = picture(130, 66)
    texture = encode(pixels, "color", SETTINGS, preset=preset)
    assert psnr(decoded("bc7", texture.levels[0][0], 130, 66)[..., :3], pixels[..., :3]) > low


def test_colour_with_alpha_keeps_alpha() -> None:
    pixels = picture(128, 64, alpha=True)
    texture = encode(pixels, "color", SETTINGS)
    back = decoded("bc7", texture.levels[0][0], 128, 64)
    assert psnr(back[..., 3], pixels[..., 3]) > 38
    assert psnr(back[..., :3], pixels[..., :3]) > 36


def test_normal_quality_in_degrees() -> None:
    pixels = normals(129, 65)
    texture = encode(pixels, "normal", SETTINGS)
    back = decoded("bc5", texture.levels[0][0], 129, 65)[..., :2].astype(float) / 127.5 - 1
    z = np.sqrt(np.maximum(0, 1 - (back**2).sum(-1)))
    truth = pixels[..., :3].astype(float) / 127.5 - 1
    truth /= np.linalg.norm(truth, axis=-1, keepdims=True)
    cosine = np.clip(back[..., 0] * truth[..., 0] + back[..., 1] * truth[..., 1] + z * truth[..., 2], -1, 1)
    assert np.degrees(np.arccos(cosine)).mean() < 0.4


def test_mask_quality_and_red_channel() -> None:
    pixels = picture(64, 64)
    texture = encode(pixels, "occlusion", SETTINGS)
    assert psnr(decoded("bc4", texture.levels[0][0], 64, 64)[..., 0], pixels[..., 0]) > 42


def test_every_mip_is_right_on_odd_sizes() -> None:
    pixels = picture(149, 85)
    plain = encode(pixels, "color", SETTINGS.replace(compress=False))
    packed = encode(pixels, "color", SETTINGS)
    for mip in range(3):
        w, h = 149 >> mip, 85 >> mip
        truth = np.frombuffer(plain.levels[0][mip], np.uint8).reshape(h, w, 4)
        assert psnr(decoded("bc7", packed.levels[0][mip], w, h)[..., :3], truth[..., :3]) > 30, mip


def test_hdr_quality() -> None:
    rgb = np.exp2(picture(64, 64)[..., :3].astype(np.float32) / 32 - 4)
    rgb[..., 1:] = rgb[..., :1] * np.array([0.8, 0.6], np.float32)
    texture = encode(rgb, "hdr", SETTINGS)
    # the decoder gives 8 bits, clipped at 1: compare where that says something
    back = decoded("bc6", texture.levels[0][0], 64, 64)[..., :3].astype(float) / 255
    clipped = np.clip(rgb, 0, 1)
    inside = (rgb < 0.9).all(-1)
    assert inside.sum() > 500
    assert np.abs(back - clipped)[inside].mean() < 0.02


@pytest.mark.parametrize("format", ["bc4", "bc5", "bc7", "bc6h"])
def test_threads_do_not_change_a_byte(format: str) -> None:
    channels = {"bc4": 1, "bc5": 2}.get(format, 4)
    pixels: Any = picture(256, 157)[..., :channels]
    if format == "bc6h":
        pixels = (pixels.astype(np.float32) / 64).astype("<f2")
    one = encode_blocks(pixels, format, "veryfast", threads=1)
    assert all(encode_blocks(pixels, format, "veryfast", threads=n) == one for n in (2, 3, 5))


def test_encoding_twice_gives_the_same_file(tmp_path: Path) -> None:
    for name in ("a", "b"):
        write_dds(tmp_path / f"{name}.dds", encode(picture(160, 144), "color", SETTINGS))
    assert (tmp_path / "a.dds").read_bytes() == (tmp_path / "b.dds").read_bytes()
    assert read_dds(tmp_path / "a.dds").format == "bc7-srgb"


def test_padding_repeats_the_edge() -> None:
    padded = pad_to_blocks(np.arange(6, dtype=np.uint8).reshape(2, 3, 1))
    np.testing.assert_array_equal(padded[..., 0], [[0, 1, 2, 2], [3, 4, 5, 5], [3, 4, 5, 5], [3, 4, 5, 5]])


def test_size_limit_halves() -> None:
    for role in ("color", "normal", "mask"):
        texture = encode(picture(100, 40), role, ImportSettings(max_texture_size=32))
        assert (texture.width, texture.height) == (25, 10)


def test_sixteen_bit_input() -> None:
    wide = picture(16, 16).astype(np.uint16) * 257
    plain = SETTINGS.replace(compress=False)
    for role in ("color", "data", "mask", "normal"):
        assert encode(wide, role, plain).levels == encode(picture(16, 16), role, plain).levels
