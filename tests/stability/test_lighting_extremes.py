"""Extremes of what makes light sit: occlusion, light between surfaces, mirrors, shadows and frames over time, each
alone and all together."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from engine.assets.primitives import card, cube, plane, uv_sphere
from engine.assets.scene import LightAsset
from engine.math.transform import look_at
from engine.render.camera import Camera
from engine.render.occlusion import METHODS
from tests.stability.metamorphic import Change, Placer, differing
from tests.stability.rows import covers
from tests.support.stage import DARK, Stage, front_camera, surface

pytestmark = pytest.mark.gl

#: what is switched on -> settings
EFFECTS: dict[str, dict[str, Any]] = {
    "gtao": {"ambient_occlusion": "gtao", "ao_mips": True},
    "alchemy": {"ambient_occlusion": "alchemy"},
    "gi": {"gi": "one"},
    "reflections": {"reflections": True},
    "lamp shadows": {"local_shadows": "all", "local_shadow_size": 256},
    "taa": {"antialias": "taa", "taa_frames": 4},
}
SIZE = (72, 56)
SAME = Change()
ALL: dict[str, Any] = {
    "ambient_occlusion": "gtao", "ao_temporal": True, "ao_mips": True, "gi": "many", "gi_bounces": 2,
    "reflections": True, "local_shadows": "all", "local_shadow_size": 128, "shadow_size": 128, "antialias": "taa",
    "taa_frames": 3, "bloom": 0.2,
}  # fmt: skip
MATT = {"base_color": (0.6, 0.6, 0.6, 1.0), "metallic": 0.0}
CAMERA = Camera(look_at((2.0, 2.0, 3.0), (0.0, 0.3, 0.0)), 0.8, znear=0.02)


def shot(stage: Stage, change: Change = SAME, camera: Camera = CAMERA, **settings: Any) -> np.ndarray:
    """A shiny floor with a ball and a block on it, under a lamp and an even sky; scaled or moved as a whole."""
    p = Placer(stage, change)
    stage.look(kind="uniform", color=(0.4, 0.5, 0.6), sun_illuminance=0.0)
    p.add(plane(4.0), (0.0, 0.0, 0.0), base_color=(0.6, 0.6, 0.6, 1), metallic=0.0, roughness=0.1)
    p.add(uv_sphere(), (-0.6, 0.5, 0.0), base_color=(0.9, 0.3, 0.2, 1), metallic=0.0, roughness=0.3)
    p.add(cube(), (0.5, 0.5, 0.0), (0.0, 1.0, 0.0), 0.5, base_color=(0.3, 0.8, 0.4, 1), metallic=0.0)
    p.lamp(LightAsset("point", intensity=4.0, range=8.0, casts_shadow=True), (0.2, 2.5, 1.5))
    return stage.hdr(SIZE, change.camera(camera), **settings)


@covers("pose.tiny-and-huge")
@pytest.mark.parametrize("scale", [1e-4, 1e4])
@pytest.mark.parametrize("effect", EFFECTS)
def test_scaled_with(stage: Stage, effect: str, scale: float) -> None:
    settings = EFFECTS[effect]
    whole = shot(stage, **settings)
    assert differing(shot(stage, local_shadows="off"), whole) > 0.02, "the effect shows"
    assert differing(whole, shot(stage, Change(scale=scale), **settings)) < 4e-3


@covers("pose.far-from-the-origin")
@pytest.mark.parametrize("effect", EFFECTS)
def test_moved_with(stage: Stage, effect: str) -> None:
    settings = EFFECTS[effect]
    moved = Change(offset=(-1e6, 2e6, 1e6))
    assert differing(shot(stage, **settings), shot(stage, moved, **settings)) < 4e-3


@covers("depth.near-and-far")
@pytest.mark.parametrize("effect", EFFECTS)
def test_a_near_plane_of_a_millimetre_changes_nothing(stage: Stage, effect: str) -> None:
    """And what stands a thousand kilometres behind is there, and is no number less."""
    settings = EFFECTS[effect]
    usual = shot(stage, **settings)
    camera = replace(CAMERA, znear=1e-3, zfar=1e6)
    assert differing(usual, shot(stage, camera=camera, **settings)) < 4e-3
    stage.add(card(1e6), surface(**MATT), (0.0, 0.0, -1e6))
    assert np.isfinite(stage.hdr(SIZE, camera, **settings)).all()


def corner(stage: Stage, **look: Any) -> None:
    stage.look(**{"kind": "sky", "sun_elevation": 0.9, "sun_illuminance": 3.0, **look})
    stage.add(plane(6.0), surface(**MATT))
    stage.add(cube(), surface(**MATT, roughness=0.2), (0.0, 0.5, 0.0))


def live(stage: Stage, size: tuple[int, int], camera: Camera, frames: int = 3, **settings: Any) -> np.ndarray:
    view = replace(stage.view(size, camera, **settings), seconds=0.02)
    for frame in range(frames):
        last = stage.runtime.render(replace(view, cut=frame == 0), hdr=True)
    return np.asarray(last.hdr.read())


@covers("light.all-at-once")
@pytest.mark.parametrize("elevation", [math.pi / 2, 0.0, -math.pi / 2])
def test_a_sun_straight_above_on_the_horizon_and_below(stage: Stage, elevation: float) -> None:
    corner(stage, sun_elevation=elevation)
    got = live(stage, (40, 32), CAMERA, **ALL)
    assert np.isfinite(got).all()
    assert (got >= 0.0).all()
    if elevation > 0.0:
        assert got[..., :3].max() > 0.1


@covers("light.all-at-once")
def test_a_lamp_inside_a_closed_caster_lights_nothing_outside(stage: Stage) -> None:
    stage.dark()
    stage.add(plane(6.0), surface(**MATT))
    stage.add(cube(), surface(**MATT), (0.0, 0.6, 0.0))
    stage.lamp(LightAsset("point", intensity=50.0, range=8.0, casts_shadow=True), (0.0, 0.6, 0.0))
    free = stage.hdr((40, 32), CAMERA, local_shadows="off")
    hidden = live(stage, (40, 32), CAMERA, **ALL)
    assert np.isfinite(hidden).all()
    assert hidden[..., :3].max() < 2e-3 * free[..., :3].max()


@covers("light.all-at-once", "light.empty-scene")
def test_an_empty_scene_is_the_clear_colour_with_all_of_it(stage: Stage) -> None:
    stage.look(**{**DARK, "background_color": (0.25, 0.5, 0.75)})
    got = live(stage, (9, 7), front_camera(), **{**ALL, "bloom": 0.0})
    assert np.abs(got - np.array([0.25, 0.5, 0.75, 1.0])).max() < 1e-3
    got = stage.hdr((9, 7), front_camera(), **{**ALL, "bloom": 0.0, "antialias": "none"})
    assert (got == np.array([0.25, 0.5, 0.75, 1.0], np.float32)).all()


@covers("light.all-at-once", "size.odd")
@pytest.mark.parametrize("size", [(1, 1), (1, 9), (17, 31)])
def test_small_pictures_with_all_of_it(stage: Stage, size: tuple[int, int]) -> None:
    corner(stage)
    got = live(stage, size, CAMERA, **ALL)
    assert got.shape == (size[1], size[0], 4)
    assert np.isfinite(got).all()


@covers("light.all-at-once")
def test_normals_that_are_none(stage: Stage) -> None:
    """Stored normals are whole numbers: of length 0 is all that a bad one can be."""
    corner(stage)
    ball = uv_sphere(0.2, 8, 16)
    bad = np.zeros_like(ball.streams["normal"])
    stage.add(replace(ball, streams={**ball.streams, "normal": bad}), surface(**MATT), (-1.6, 0.3, 0.8))
    got = live(stage, (40, 32), CAMERA, **ALL)
    assert np.isfinite(got).all()
    assert (got >= 0.0).all()


@covers("light.occlusion")
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("fov", [0.3, 1.2, 2.4])
def test_a_plane_is_open_up_to_the_border(stage: Stage, method: str, fov: float) -> None:
    """At the picture's border half of what is around is not seen: that hides nothing."""
    stage.look(kind="uniform", color=(1.0, 1.0, 1.0))
    stage.add(card(400.0), surface())
    camera = Camera(look_at((0.0, 0.6, 0.8), (0.0, 0.0, 0.0)), fov, znear=0.01)
    seen = stage.hdr((64, 48), camera, ambient_occlusion=method, ao_radius=0.4, view="ambient_occlusion")[..., 0]
    assert np.abs(seen - 1.0).max() < (0.02 if method == "alchemy" else 0.01)
