"""Mips: linear light, exact averages at any size, unit normals, alpha coverage."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from importers.settings import ImportSettings
from importers.textures.encode import encode
from importers.textures.mips import chain, keep_coverage, normal_chain, resample

PLAIN = ImportSettings(compress=False)


@pytest.mark.parametrize("preset", ["normal", "high"])
def test_checker_averages_in_linear_light(preset: str) -> None:
    checker = np.zeros((64, 64, 4), np.uint8)
    checker[(np.indices((64, 64)).sum(0) % 2) == 1] = 255
    checker[..., 3] = 255
    texture = encode(checker, "color", PLAIN, preset=preset)
    mip = np.frombuffer(texture.levels[0][1], np.uint8).reshape(32, 32, 4)
    assert abs(int(mip[16, 16, 0]) - 188) <= 1
    data = np.frombuffer(encode(checker, "data", PLAIN, preset=preset).levels[0][1], np.uint8).reshape(32, 32, 4)
    assert abs(int(data[16, 16, 0]) - 128) <= 1


@pytest.mark.parametrize("kind", ["box", "kaiser"])
@pytest.mark.parametrize(("w", "h"), [(8191, 3), (1, 1), (1, 7), (5, 5), (64, 48), (33, 2)])
def test_any_size_keeps_constants_and_ends_at_one(kind: str, w: int, h: int) -> None:
    levels = chain(np.full((h, w, 3), 0.7, np.float32), kind)
    assert levels[-1].shape[:2] == (1, 1)
    assert len(levels) == max(w, h).bit_length()
    for level in levels:
        np.testing.assert_allclose(level, 0.7, rtol=2e-6)


@pytest.mark.parametrize(("w", "h"), [(8, 8), (7, 5), (13, 4)])
def test_box_keeps_the_mean(w: int, h: int) -> None:
    image = np.random.default_rng(0).random((h, w, 2)).astype(np.float32)
    small = resample(image, max(1, w // 2), max(1, h // 2), "box")
    np.testing.assert_allclose(small.mean((0, 1)), image.mean((0, 1)), rtol=1e-5)


def test_box_weighs_partial_texels_exactly() -> None:
    row = np.arange(5, dtype=np.float32).reshape(1, 5, 1)
    # two output texels of 2.5 inputs each: (0 + 1 + 2/2) / 2.5 and (2/2 + 3 + 4) / 2.5
    np.testing.assert_allclose(resample(row, 2, 1, "box").ravel(), [0.8, 3.2], rtol=1e-6)


def test_kaiser_keeps_what_fits_and_drops_what_aliases() -> None:
    x = (np.arange(128) + 0.5) / 128 * 2 * np.pi
    slow = np.cos(4 * x).astype(np.float32).reshape(1, -1, 1)
    fast = np.cos(60 * x).astype(np.float32).reshape(1, -1, 1)

    def amplitude(image: np.ndarray[Any, Any], kind: str) -> float:
        return float(resample(image, 64, 1, kind, wrap=True).std() * np.sqrt(2.0))

    assert amplitude(slow, "box") == pytest.approx(np.cos(4 * np.pi / 128), abs=1e-4)
    assert amplitude(slow, "kaiser") == pytest.approx(1.0, abs=4e-3)
    assert amplitude(fast, "kaiser") < 0.5 * amplitude(fast, "box")


def test_normals_stay_unit_and_cancelling_ones_point_up() -> None:
    vectors = np.random.default_rng(1).standard_normal((16, 12, 3)).astype(np.float32)
    for level in normal_chain(vectors):
        np.testing.assert_allclose(np.linalg.norm(level, axis=-1), 1.0, atol=1e-5)
    opposite = np.array([[[1, 0, 0], [-1, 0, 0]]], np.float32)
    np.testing.assert_array_equal(normal_chain(opposite)[-1], [[[0, 0, 1]]])


def leaf(size: int = 256) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    noise = np.random.default_rng(5).random((size, size, 1)).astype(np.float32)
    smooth = resample(resample(noise, size // 4, size // 4, "box"), size, size, "box")[..., 0]
    pixels = np.zeros((size, size, 4), np.uint8)
    pixels[..., 1] = 180
    pixels[..., 3] = np.where(smooth > np.quantile(smooth, 0.8), 255, 0)
    return pixels


def test_alpha_coverage_is_kept() -> None:
    pixels = leaf()
    wanted = (pixels[..., 3] >= 128).mean()
    for cutoff, low, high in ((0.5, wanted - 0.04, wanted + 0.04), (None, 0.0, wanted - 0.08)):
        texture = encode(pixels, "color", PLAIN, alpha_cutoff=cutoff)
        for mip in (3, 4, 5):
            alpha = np.frombuffer(texture.levels[0][mip], np.uint8).reshape(-1, 4)[:, 3]
            assert low <= (alpha >= 128).mean() <= high, (cutoff, mip)


def test_coverage_of_opaque_and_clear_images_is_left_alone() -> None:
    for alpha in (0.0, 1.0):
        levels = chain(np.full((8, 8, 4), alpha, np.float32), "box")
        assert keep_coverage(levels, 0.5) is levels


def test_invisible_texels_do_not_bleed_into_colour() -> None:
    pixels = np.zeros((4, 4, 4), np.uint8)
    pixels[:, ::2] = (200, 100, 50, 255)  # the others are black and clear
    mip = np.frombuffer(encode(pixels, "color", PLAIN).levels[0][1], np.uint8).reshape(-1, 4)
    assert np.abs(mip[0, :3].astype(int) - (200, 100, 50)).max() <= 1
    assert abs(int(mip[0, 3]) - 128) <= 1
