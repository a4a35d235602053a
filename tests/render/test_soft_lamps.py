"""Shadows of lights with a size: as soft as geometry says, hard where they have none, the same by every path."""

from __future__ import annotations

import math

import numpy as np
import pytest

from engine.assets.primitives import card, cube, uv_sphere
from engine.assets.scene import LightAsset
from engine.experiments.shadow_filter import cut_area
from engine.math.transform import look_at
from engine.render.camera import Camera

pytestmark = pytest.mark.gl

DOWN = (math.sin(-math.pi / 4), 0.0, 0.0, math.cos(-math.pi / 4))
SIZE = (96, 48)
RADIUS = 0.25
LAMPS = {
    "point": LightAsset("point", intensity=20.0, radius=RADIUS, casts_shadow=True),
    "spot": LightAsset("spot", intensity=20.0, radius=RADIUS, inner_angle=0.7, outer_angle=0.8, casts_shadow=True),
    "disk": LightAsset("disk", intensity=50.0, width=2 * RADIUS, height=2 * RADIUS, casts_shadow=True),
    "rectangle": LightAsset("rectangle", intensity=50.0, width=2 * RADIUS, height=2 * RADIUS, casts_shadow=True),
}


def edge(stage, surface, lamp: LightAsset, height: float) -> Camera:
    """A card over the half x < 0 of a floor, `height` of the 2 m up to the lamp over its edge; the camera looks down on
    the other half, where it is in the way of nothing."""
    stage.dark()
    stage.add(card(20.0), surface(metallic=0.0), rotation=DOWN)
    stage.add(card(4.0), surface(features=("double_sided",), metallic=0.0), (-2.0, height, 0.0), rotation=DOWN)
    stage.lamp(lamp, (0.0, 2.0, 0.0), DOWN)
    return Camera(look_at((0.5, 1.9, 0.0), (0.5, 0.0, 0.0), (0.0, 0.0, -1.0)), ymag=0.25, znear=0.05, zfar=4.0)


def part_lit(stage, camera: Camera, **settings) -> np.ndarray:
    bright = stage.hdr(SIZE, camera, **{**settings, "local_shadows": "off"})[..., 0].astype(np.float64)
    assert (bright > 1e-4).all()
    return stage.hdr(SIZE, camera, **settings)[..., 0] / bright


@pytest.mark.parametrize("height", [0.5, 1.0])
@pytest.mark.parametrize("kind", LAMPS)
def test_the_penumbra_is_the_light_s(stage, surface, kind, height) -> None:
    """At x, the edge hides all of the light beyond u = -x (2 - h) / h from its middle: of a disk the part that a chord
    cuts off, of a square a strip. Measured on the lit half."""
    camera = edge(stage, surface, LAMPS[kind], height)
    seen = part_lit(stage, camera, local_shadow_size=2048)
    x = (np.arange(SIZE[0]) + 0.5) / SIZE[0]
    u = np.clip(x * (2.0 - height) / height / RADIUS, -1.0, 1.0)
    truth = (1.0 + u) / 2.0 if kind == "rectangle" else cut_area(u)
    assert truth.min() < 0.6
    mean = seen.mean(axis=0)
    assert np.sqrt(np.mean((mean - truth) ** 2)) < 0.05
    assert np.abs(mean - truth).max() < 0.15


def test_without_size_or_wish_the_edge_is_hard(stage, surface) -> None:
    small = LightAsset("point", intensity=20.0, casts_shadow=True)
    camera = edge(stage, surface, small, 0.5)
    hard = part_lit(stage, camera, shadow_filter="pcf")
    assert ((hard > 0.02) & (hard < 0.98)).mean() < 0.05
    camera = edge(stage, surface, LAMPS["point"], 0.5)
    assert np.array_equal(part_lit(stage, camera, shadow_filter="pcf", soft_lamps=False), hard)


def scene(stage, surface) -> Camera:
    stage.dark()
    stage.add(card(20.0), surface(metallic=0.0), rotation=DOWN)
    stage.add(uv_sphere(), surface(base_color=(0.7, 0.3, 0.2, 1.0), metallic=0.0), (0.9, 0.4, 0.4), 0.8)
    stage.add(cube(), surface(metallic=0.0), (-0.4, 0.4, 0.0), 0.5)
    stage.lamp(LAMPS["rectangle"], (0.3, 2.0, 0.2), DOWN)
    stage.lamp(LightAsset("point", (1.0, 0.6, 0.3), 6.0, 6.0, casts_shadow=True, radius=0.1), (1.2, 1.4, 1.2))
    stage.lamp(LightAsset("spot", (0.3, 0.6, 1.0), 6.0, outer_angle=0.9, casts_shadow=True), (-1.2, 1.4, 1.2), DOWN)
    return Camera(look_at((2.5, 3.0, 3.5), (0.0, 0.3, 0.0)), 0.8, znear=0.05)


def test_all_paths_and_the_forced_frame_agree(stage, surface) -> None:
    camera = scene(stage, surface)
    truth = stage.hdr((48, 40), camera, path="forward")
    assert np.abs(truth - stage.hdr((48, 40), camera, path="forward", soft_lamps=False)).max() > 0.05
    for path in ("deferred", "tiled-deferred", "forward-plus"):
        assert np.array_equal(stage.hdr((48, 40), camera, path=path), truth), path
    assert np.array_equal(stage.hdr((48, 40), camera, path="forward", force_all=True), truth)


@pytest.mark.parametrize("kind", ["point", "disk"])
def test_a_floor_and_a_ball_hide_nothing_of_themselves(stage, surface, kind) -> None:
    """A convex body and the floor about it: dark only where the body is in the way or faces away."""
    stage.dark()
    stage.add(card(20.0), surface(metallic=0.0), rotation=DOWN)
    stage.lamp(LAMPS[kind], (0.0, 2.0, 0.0), DOWN)
    stage.add(cube(), surface(metallic=0.0), (30.0, -5.0, 0.0))  # something that casts, elsewhere
    camera = Camera(look_at((0.0, 1.9, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, -1.0)), ymag=1.5, znear=0.05, zfar=4.0)
    assert part_lit(stage, camera).min() > 0.99


def test_lights_that_are_next_to_nothing_and_huge(stage, surface) -> None:
    """Radii from 1e-6 m to 1e6 m: finite, between none and all of the light."""
    for radius in (1e-6, 1e-3, 1e3, 1e6):
        camera = edge(stage, surface, LightAsset("point", intensity=20.0, radius=radius, casts_shadow=True), 0.5)
        seen = part_lit(stage, camera)
        assert np.isfinite(seen).all()
        assert seen.min() >= 0.0
        assert seen.max() <= 1.001
