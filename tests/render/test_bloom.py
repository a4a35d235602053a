"""Bloom keeps the sum of light and what is constant, is as wide at every resolution, and is nothing where it is off."""

from __future__ import annotations

import numpy as np
import pytest

from engine.assets.primitives import card
from engine.assets.scene import LightAsset
from engine.math.glare import halos
from engine.render.bloom import level_sizes, level_weights
from tests.support.stage import front_camera

pytestmark = pytest.mark.gl

PATHS = ("forward", "deferred", "tiled-deferred", "forward-plus")
ON = {"bloom": 0.5, "bloom_radius": 0.1}


def spark(stage, surface, size: tuple[int, int], at: tuple[float, float] = (0.0, 0.0), pixels: float = 1.0) -> None:
    """A square of so many pixels of light 1000 in the dark, as `front_camera` sees it."""
    stage.dark()
    bright = surface(base_color=(0.0, 0.0, 0.0, 1.0), specular=0.0, emissive=(1.0, 1.0, 1.0), emissive_strength=1000.0)
    stage.add(card(1.0), bright, position=(*at, 0.0), scale=pixels / size[1])


def shot(stage, size: tuple[int, int], **settings):
    return stage.hdr(size, front_camera(0.5, size[0] / size[1]), **settings)[..., :3].astype(np.float64)


@pytest.mark.parametrize(("size", "tolerance"), [((64, 48), 1e-3), ((33, 47), 4e-3), ((80, 7), 8e-3)])
@pytest.mark.parametrize("at", [(0.0, 0.0), (0.3, 0.3)])
def test_the_sum_of_light_stays(stage, surface, size, tolerance, at) -> None:
    spark(stage, surface, size, at, pixels=3.0)
    bare = shot(stage, size)
    assert bare.max() > 100.0
    lit = shot(stage, size, bloom=0.5, bloom_radius=0.3)
    assert lit.max() < 0.95 * bare.max()
    assert lit.sum() == pytest.approx(bare.sum(), rel=tolerance)


def test_what_is_constant_stays(stage) -> None:
    stage.look(kind="uniform", color=(0.7, 0.7, 0.7))
    for size in ((40, 30), (1, 1), (2, 1), (31, 17), (9, 64)):
        bare = shot(stage, size)
        assert bare.min() > 0.5
        for calm in (False, True):
            lit = shot(stage, size, bloom=1.0, bloom_radius=0.3, bloom_calm=calm)
            assert np.abs(lit / bare - 1.0).max() < 1e-3, size


def test_as_the_sum_of_gaussians(stage, surface) -> None:
    """Against the same halos in float64: as near as a few splines are to a Gaussian; symmetric to the bit."""
    size = (96, 96)
    spark(stage, surface, size, pixels=6.0)
    bare = shot(stage, size)
    lit = shot(stage, size, **ON)
    truth = 0.5 * bare + 0.5 * halos(bare, 0.1)
    assert np.abs(bare - bare[::-1]).max() == np.abs(bare - bare[:, ::-1]).max() == 0.0
    for turned in (lit[::-1], lit[:, ::-1], lit.transpose(1, 0, 2)):
        assert np.allclose(lit, turned, rtol=2e-3, atol=1e-4)
    # a spline's tails are shorter than a Gaussian's: so much of the light that was moved is elsewhere
    assert np.abs(lit - truth).sum() < 0.15 * np.abs(bare - truth).sum()


@pytest.mark.parametrize("height", [48, 67, 96, 144])
def test_as_wide_at_every_resolution(stage, surface, height) -> None:
    """The variance of what is scattered: the mean of the halos' variances, in picture heights."""
    size, radius = (height, height), 0.05
    spark(stage, surface, size, pixels=height / 12.0)
    bare, lit = shot(stage, size)[..., 0], shot(stage, size, bloom=1.0, bloom_radius=radius)[..., 0]
    y = (np.arange(height) + 0.5)[:, None] / height - 0.5
    spread = (lit * y**2).sum() / lit.sum() - (bare * y**2).sum() / bare.sum()
    assert spread == pytest.approx(np.mean((radius * 0.5 ** np.arange(6)) ** 2), rel=0.05)


def test_halvings() -> None:
    assert level_sizes(5, 1, 3) == [(5, 1), (3, 1), (2, 1), (1, 1)]
    for size in ((1, 1), (2, 1), (7, 3), (1920, 1080)):
        for radius in (0.0, 1e-9, 0.1, 1.0):
            weights = level_weights(radius, *size)
            assert weights.min() >= 0.0
            assert weights.sum() == pytest.approx(1.0)
            assert len(weights) - 1 <= max(0, max(size) - 1).bit_length()
    variances = 2.0 / 3.0 * (4.0 ** np.arange(9) - 1.0)
    found = level_weights(0.03, 1920, 1080)
    assert found @ variances[: len(found)] == pytest.approx(np.mean((32.4 * 0.5 ** np.arange(6)) ** 2))


def test_all_paths_and_sample_counts(stage, surface) -> None:
    spark(stage, surface, (40, 32), pixels=4.0)
    stage.lamp(LightAsset("point", intensity=4.0, range=3.0), (0.2, 0.0, 1.0))
    truth = shot(stage, (40, 32), path="forward", **ON)
    for path in PATHS[1:]:
        assert np.array_equal(shot(stage, (40, 32), path=path, **ON), truth), path
    smooth = shot(stage, (40, 32), path="forward", samples=4, **ON)
    assert smooth.sum() == pytest.approx(shot(stage, (40, 32), path="forward", samples=4).sum(), rel=1e-3)


def test_off_is_nothing(stage, surface) -> None:
    spark(stage, surface, (33, 20), pixels=3.0)
    camera = front_camera(0.5, 33 / 20)
    off = stage.ldr((33, 20), camera)
    forced = {"force_all": True}
    assert np.array_equal(stage.ldr((33, 20), camera, **forced), off)
    assert np.array_equal(shot(stage, (33, 20), **forced), shot(stage, (33, 20)))
    for settings, why in (
        ({}, "bloom is 0"),
        ({"bloom": 0.5, "view": "normal"}, "values as they are"),
        ({"bloom": 0.5, "bloom_radius": 0.0}, "smaller than a pixel"),
    ):
        frame = stage.runtime.renderer.render(stage.runtime.scene, stage.view((33, 20), camera, **settings))
        assert why in next(item.reason for item in frame.graph.left_out if item.name == "bloom")
    on = {"bloom": 0.3}
    assert np.array_equal(stage.ldr((33, 20), camera, **on, **forced), stage.ldr((33, 20), camera, **on))


def test_calm_loses_light_of_single_pixels(stage, surface) -> None:
    spark(stage, surface, (32, 32), pixels=2.0)
    whole, calm = (shot(stage, (32, 32), bloom_calm=calm, **ON) for calm in (False, True))
    assert 0.5 < calm.sum() / whole.sum() < 0.95


def test_the_brightest_picture_stays_finite(stage, surface) -> None:
    stage.look(kind="uniform", color=(1e6, 1e6, 1e6))
    lit = shot(stage, (24, 24), **ON)
    assert np.isfinite(lit).all()
    assert lit.min() > 1e4
