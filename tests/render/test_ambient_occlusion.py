"""Ambient occlusion: known answers, all paths alike, nothing where it is not wanted, extreme radii and sizes."""

from __future__ import annotations

import math

import numpy as np
import pytest

from engine.app.framing import frame_bounds
from engine.assets.primitives import card, cube, uv_sphere
from engine.assets.scene import LightAsset
from engine.render.camera import Camera
from engine.render.occlusion import METHODS, radius_of
from engine.render.settings import RenderSettings

pytestmark = pytest.mark.gl

FLAT = (math.sin(-math.pi / 4), 0.0, 0.0, math.cos(-math.pi / 4))  # a card that faces +Z comes to face +Y
PATHS = ("forward", "deferred", "tiled-deferred", "forward-plus")


def visibility(stage, camera: Camera, size: tuple[int, int] = (96, 96), **settings):
    chosen = {"ambient_occlusion": "gtao", "view": "ambient_occlusion", **settings}
    return stage.hdr(size, camera, **chosen)[..., 0].astype(np.float64)


def above(height: float, half: float) -> Camera:
    """Looks at the origin from 45 degrees above."""
    return frame_bounds(np.full(3, -half), np.full(3, half), 1.0, azimuth=0.0, elevation=45.0)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("scale", [1e-4, 1.0, 1e4])
def test_a_plane_hides_nothing_of_itself(stage, surface, method, scale) -> None:
    stage.look(kind="uniform", color=(1.0, 1.0, 1.0))
    stage.add(card(4.0), surface(), rotation=FLAT, scale=scale)
    seen = visibility(stage, above(scale, 0.5 * scale), ambient_occlusion=method, ao_radius=0.3 * scale)
    assert np.abs(seen[8:-8, 8:-8] - 1.0).max() < 0.02


def test_beside_a_wall(stage, surface) -> None:
    """At a distance d from an endless wall of height h, (1 + d / sqrt(d^2 + h^2)) / 2 of the light is left (form factor
    of a strip and a wall at a right angle)."""
    stage.look(kind="uniform", color=(1.0, 1.0, 1.0))
    stage.add(card(40.0), surface(), rotation=FLAT)
    stage.add(cube(1.0), surface(), position=(0.0, 0.5, -0.5), scale=(40.0, 1.0, 1.0))
    camera = frame_bounds(np.array([-1, -0.1, -1]), np.array([1, 1, 3.0]), 1.0, azimuth=0.0, elevation=55.0)
    seen = visibility(stage, camera, (128, 128), ao_radius=30.0, ao_directions=8, ao_steps=32)
    clip = camera.clip_from_world(1.0)
    for d in (0.3, 0.6, 1.0, 1.5):
        p = clip @ np.array([0.0, 0.0, d, 1.0])
        x, y = int((p[0] / p[3] + 1) * 64), int((1 - p[1] / p[3]) * 64)
        expected = (1.0 + d / math.hypot(d, 1.0)) / 2.0
        assert seen[y, x] == pytest.approx(expected, abs=0.05), d


@pytest.mark.parametrize("method", METHODS)
def test_corners_are_darker_than_the_open(stage, surface, method) -> None:
    stage.look(kind="uniform", color=(1.0, 1.0, 1.0))
    stage.add(card(10.0), surface(), rotation=FLAT)
    stage.add(cube(1.0), surface(), position=(0.0, 0.5, 0.0))
    seen = visibility(stage, above(1.0, 1.2), ambient_occlusion=method, ao_radius=0.8)
    assert seen.min() < 0.75
    assert np.percentile(seen, 90.0) > 0.98


def test_all_paths_and_sample_counts_see_it(stage, surface) -> None:
    stage.look(kind="uniform", color=(1.0, 1.0, 1.0))
    stage.add(card(10.0), surface(), rotation=FLAT)
    stage.add(uv_sphere(), surface(base_color=(0.6, 0.3, 0.2, 1.0), metallic=0.0), position=(0.0, 0.5, 0.0))
    stage.lamp(LightAsset("point", intensity=4.0, range=3.0), (0.8, 1.0, 0.8))
    camera = above(1.0, 0.8)
    bare = stage.hdr((40, 32), camera, path="forward")
    settings = {"ambient_occlusion": "gtao", "ao_radius": 0.5}
    truth = stage.hdr((40, 32), camera, path="forward", **settings)
    assert np.abs(truth - bare).max() > 0.05
    for path in PATHS[1:]:
        assert np.array_equal(stage.hdr((40, 32), camera, path=path, **settings), truth), path
    smooth = stage.hdr((40, 32), camera, path="forward", samples=4, **settings)
    assert np.abs(smooth - truth).mean() < 0.02


def test_what_is_not_wanted_is_left_out(stage, surface) -> None:
    stage.look(kind="uniform", color=(1.0, 1.0, 1.0))
    stage.add(uv_sphere(), surface())
    camera = above(1.0, 0.6)
    off = stage.hdr((32, 32), camera)
    for settings in (
        {"ambient_occlusion": "gtao", "ao_strength": 0.0},
        {"ambient_occlusion": "gtao", "environment_intensity": 1.0, "ao_strength": 0.0, "force_all": True},
    ):
        assert np.array_equal(stage.hdr((32, 32), camera, **settings), off)
    assert "its strength is 0" in str(_left_out(stage, camera, ao_strength=0.0))
    assert "no environment light" in str(_left_out(stage, camera, environment_intensity=0.0))
    stage.look(kind="uniform", color=(1.0, 1.0, 1.0))
    assert "nothing solid" in str(_left_out(stage, camera))


def _left_out(stage, camera: Camera, **settings) -> list[str]:
    view = stage.view((32, 32), camera, ambient_occlusion="gtao", **settings)
    frame = stage.runtime.renderer.render(stage.runtime.scene, view)
    return [item.reason for item in frame.graph.left_out if item.name == "ambient_occlusion"]


@pytest.mark.parametrize("radius", [1e-6, 1e6])
@pytest.mark.parametrize("method", METHODS)
def test_no_radius_is_too_small_or_too_large(stage, surface, method, radius) -> None:
    stage.look(kind="uniform", color=(1.0, 1.0, 1.0))
    stage.add(card(10.0), surface(), rotation=FLAT)
    stage.add(cube(1.0), surface(), position=(0.0, 0.5, 0.0))
    seen = visibility(stage, above(1.0, 1.0), (33, 17), ambient_occlusion=method, ao_radius=radius)
    assert np.isfinite(seen).all()
    assert (seen.min() >= 0.0) & (seen.max() <= 1.0)
    if radius < 1.0:
        assert seen.min() > 0.999  # as near to 1 as truncated half floats are


@pytest.mark.parametrize("size", [(1, 1), (2, 3), (17, 31)])
@pytest.mark.parametrize("half", [False, True])
def test_odd_sizes(stage, surface, size, half) -> None:
    stage.look(kind="uniform", color=(1.0, 1.0, 1.0))
    stage.add(uv_sphere(), surface())
    seen = visibility(stage, above(1.0, 0.6), size, ao_half=half)
    assert np.isfinite(seen).all()
    assert seen.max() <= 1.0


def test_half_size_is_about_the_same(stage, surface) -> None:
    stage.look(kind="uniform", color=(1.0, 1.0, 1.0))
    stage.add(card(10.0), surface(), rotation=FLAT)
    stage.add(cube(1.0), surface(), position=(0.0, 0.5, 0.0))
    camera = above(1.0, 1.2)
    whole = visibility(stage, camera, ao_radius=0.8)
    half = visibility(stage, camera, ao_radius=0.8, ao_half=True)
    assert 0.0 < np.abs(whole - half).mean() < 0.02


def test_the_radius_follows_the_scene() -> None:
    low, high = np.zeros(3), np.array([3.0, 4.0, 0.0])
    assert radius_of(RenderSettings(), low, high) == pytest.approx(0.15)
    assert radius_of(RenderSettings(ao_radius=2.0), low, high) == 2.0
    assert radius_of(RenderSettings(), low, low) == 1.0
    assert radius_of(RenderSettings(), low, np.full(3, np.inf)) == 1.0
