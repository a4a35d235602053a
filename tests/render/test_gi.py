"""Light from surface to surface: known answers, paths alike, nothing where it is not wanted, extreme values."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from engine.app.framing import frame_bounds
from engine.assets.primitives import card, cube, uv_sphere
from engine.assets.scene import LightAsset
from engine.experiments.harness.gi_answers import answers, wall_seen
from engine.math import quat
from engine.math.transform import look_at
from engine.render.camera import Camera
from engine.render.gi.choice import Indirect, indirect_of, lengths_of, size_of
from engine.render.settings import RenderSettings
from tests.support import poison

pytestmark = pytest.mark.gl

FLAT = quat.from_axis_angle((1.0, 0.0, 0.0), -math.pi / 2)  # a card that faces +Z comes to face +Y
PATHS = ("forward", "deferred", "tiled-deferred", "forward-plus")
MATT = {"metallic": 0.0, "roughness": 1.0, "ior": 1.0, "specular": 0.0}
GLOW = {**MATT, "base_color": (0.0, 0.0, 0.0, 1.0), "emissive": (1.0, 1.0, 1.0)}
GREY = {**MATT, "base_color": (0.5, 0.5, 0.5, 1.0)}


def corner(stage, surface, scale: float = 1.0, shift: float = 0.0) -> Camera:
    """A glowing wall, 2 wide and 1 high, that stands on a black floor; the camera sees all of both."""
    stage.dark()
    stage.add(card(4.0), surface(**{**GLOW, "emissive": (0.0, 0.0, 0.0)}), (shift, 0.0, 0.0), scale, FLAT)
    stage.add(card(1.0), surface(**GLOW), (shift, 0.5 * scale, -0.5 * scale), (2.0 * scale, scale, scale))
    eye = np.array([0.0, 2.2, 2.6]) * scale + (shift, 0.0, 0.0)
    return Camera(look_at(eye, np.array([0.0, 0.1, 0.1]) * scale + (shift, 0.0, 0.0)), 0.9, 0.01 * scale)


def indirect(stage, camera: Camera, size: tuple[int, int] = (96, 96), **settings) -> np.ndarray:
    return stage.hdr(size, camera, **{"gi": "one", "view": "indirect", **settings})[..., :3].astype(np.float64)


def pixel_of(camera: Camera, place: tuple[float, float, float], size: int) -> tuple[int, int]:
    p = camera.clip_from_world(1.0) @ np.array([*place, 1.0])
    return int((1.0 - p[1] / p[3]) * size / 2), int((p[0] / p[3] + 1.0) * size / 2)


def test_two_plates(stage, surface) -> None:
    camera = corner(stage, surface)
    seen = indirect(stage, camera, (128, 128), gi_directions=4, gi_steps=48, gi_half=False)
    for d in (0.2, 0.4, 0.8, 1.2):
        y, x = pixel_of(camera, (0.0, 0.0, d - 0.5), 128)
        assert seen[y - 1 : y + 2, x - 1 : x + 2].mean() == pytest.approx(wall_seen(d), abs=0.02), d


@pytest.mark.parametrize("scale", [1e-4, 1e4])
def test_scale_makes_no_difference(stage, surface, scale) -> None:
    usual = indirect(stage, corner(stage, surface))
    scaled = indirect(stage, corner(stage, surface, scale))
    assert usual.max() > 0.3
    assert np.abs(scaled - usual).mean() < 2e-3


def test_far_from_the_origin(stage, surface) -> None:
    usual = indirect(stage, corner(stage, surface))
    assert np.abs(indirect(stage, corner(stage, surface, shift=1e6)) - usual).mean() < 2e-3


def test_a_furnace_stays_one(stage, surface) -> None:
    """Surfaces that glow with a half and reflect a half, in surroundings of 1: all light is 1, with what comes from
    surfaces and what is left to the surroundings as with the surroundings alone."""
    stage.look(kind="uniform", color=(1.0, 1.0, 1.0), sun_illuminance=0.0)
    material = surface(**{**GREY, "emissive": (0.5, 0.5, 0.5)})
    stage.add(card(4.0), material, rotation=FLAT)
    stage.add(card(4.0), material, (0.0, 1.0, -0.5))
    camera = Camera(look_at((0.3, 1.6, 2.2), (0.0, 0.4, -0.2)), 0.8)
    off, on = (stage.hdr((64, 64), camera, gi=gi, gi_bounces=8, gi_half=False)[..., :3] for gi in ("off", "many"))
    assert np.abs(on - off)[4:-4, 4:-4].max() < 0.01
    from_surfaces = indirect(stage, camera, (64, 64), gi="many", gi_bounces=8)
    assert from_surfaces.max() > 0.4


def closed_box(stage, surface, glow: float, albedo: float) -> Camera:
    stage.dark()
    material = surface(
        **{**GREY, "base_color": (albedo,) * 3 + (1.0,), "emissive": (glow,) * 3}, features=("double_sided",)
    )
    stage.add(cube(2.0), material)
    return Camera(look_at((0.0, 0.0, 0.95), (0.0, 0.0, 0.0)), 1.6)


def test_a_closed_box_comes_to_its_limit(stage, surface) -> None:
    """e / (1 - rho): what is not in the picture is as what is."""
    camera = closed_box(stage, surface, 0.25, 0.5)
    seen = stage.hdr((64, 64), camera, gi="many", gi_bounces=12, gi_unseen="seen", gi_radius=10.0)[..., :3]
    assert seen.mean() == pytest.approx(0.5, rel=0.02)
    one = stage.hdr((64, 64), camera, gi="one", gi_unseen="seen", gi_radius=10.0)[..., :3]
    assert one.mean() == pytest.approx(0.375, rel=0.02)


def test_the_report_knows_its_answers(gl_device) -> None:
    found = list(answers(gl_device))
    assert len(found) == 10
    assert not [(a.what, a.truth, a.ours) for a in found if not a.ok]


def test_bounces_never_grow_without_end(stage, surface) -> None:
    camera = closed_box(stage, surface, 0.1, 1.0)
    for boost in (1.0, 4.0):
        seen = stage.hdr((32, 32), camera, gi="many", gi_bounces=16, gi_unseen="seen", gi_boost=boost)[..., :3]
        assert np.isfinite(seen).all()
        assert seen.max() < 0.1 / (1.0 - 0.95) * 1.05


def test_a_second_layer_that_is_empty_changes_nothing(stage, surface) -> None:
    stage.dark()
    stage.add(card(1.0), surface(**{**GREY, "emissive": (0.2, 0.2, 0.2)}))
    stage.lamp(LightAsset("point", intensity=2.0), (0.3, 0.2, 0.8))
    one, two = (stage.hdr((40, 40), gi="one", gi_layers=layers) for layers in (1, 2))
    assert one.max() > 0.2
    assert np.array_equal(one, two)


def test_the_second_layer_is_what_stands_behind(stage, surface) -> None:
    stage.dark()
    stage.add(card(4.0), surface(**{**GREY, "base_color": (0.2, 0.6, 0.2, 1.0)}), (0.0, 0.0, -1.0))
    stage.add(card(0.5), surface(**GREY))
    camera = Camera(look_at((0.0, 0.0, 2.0), (0.0, 0.0, 0.0)), 0.8)
    seen = stage.hdr((32, 32), camera, gi="one", view="layer_color", gi_separation=0.5)
    assert seen[16, 16, :3] == pytest.approx((0.2, 0.6, 0.2), abs=2e-3)
    assert (seen[2, 2, :3] == 0.0).all()
    too_near = stage.hdr((32, 32), camera, gi="one", view="layer_color", gi_separation=1.5)
    assert (too_near[..., :3] == 0.0).all()


def lamp_scene(stage, surface) -> Camera:
    stage.look(kind="uniform", color=(0.2, 0.25, 0.3))
    stage.add(card(3.0), surface(**{**GREY, "base_color": (0.8, 0.3, 0.2, 1.0)}), rotation=FLAT)
    stage.add(uv_sphere(0.4, 12, 24), surface(**GREY), (0.0, 0.4, 0.0))
    stage.lamp(LightAsset("point", intensity=4.0), (0.8, 1.2, 0.8))
    return Camera(look_at((0.0, 1.0, 2.4), (0.0, 0.3, 0.0)), 0.7)


def test_all_paths_and_sample_counts_see_it(stage, surface) -> None:
    camera = lamp_scene(stage, surface)
    bare = stage.hdr((40, 32), camera, path="forward")
    truth = stage.hdr((40, 32), camera, path="forward", gi="many")
    assert np.abs(truth - bare).max() > 0.03
    for path in PATHS[1:]:
        assert np.array_equal(stage.hdr((40, 32), camera, path=path, gi="many"), truth), path
    smooth = stage.hdr((40, 32), camera, path="forward", samples=4, gi="many")
    assert np.abs(smooth - truth).mean() < 0.02


def test_what_is_not_wanted_is_left_out(stage, surface) -> None:
    camera = lamp_scene(stage, surface)
    off = stage.hdr((32, 32), camera)
    for settings in ({"gi_strength": 0.0}, {"gi_strength": 0.0, "force_all": True}):
        assert np.array_equal(stage.hdr((32, 32), camera, gi="many", **settings), off)
    assert not indirect_of(RenderSettings(gi="many", gi_strength=0.0), solid=True).wanted
    assert indirect_of(RenderSettings(gi="one"), solid=False).why_not == "nothing solid"
    assert "shows no light" in indirect_of(RenderSettings(gi="one", view="normal"), solid=True).why_not
    assert indirect_of(RenderSettings(), solid=True) == Indirect()


@pytest.mark.parametrize(
    "settings",
    [
        {"gi_radius": 1e-6}, {"gi_radius": 1e6}, {"gi_separation": 1e-6}, {"gi_separation": 1e6}, {"gi_steps": 1},
        {"gi_half": False}, {"gi_method": "spiral"}, {"gi_unseen": "seen"},
    ],
    ids=str,
)  # fmt: skip
def test_extreme_settings(stage, surface, settings) -> None:
    camera = lamp_scene(stage, surface)
    seen = stage.hdr((33, 17), camera, gi="many", **settings)
    assert np.isfinite(seen).all()
    assert (seen >= 0.0).all()
    bare = stage.hdr((33, 17), camera)
    assert np.abs(seen - bare).max() < 2.0


@pytest.mark.parametrize("size", [(1, 1), (17, 31)])
def test_odd_sizes(stage, surface, size) -> None:
    camera = lamp_scene(stage, surface)
    for settings in ({}, {"gi_half": False}, {"gi": "one"}):
        assert np.isfinite(stage.hdr(size, camera, **{"gi": "many", **settings})).all()


def test_an_empty_scene_stays_what_it_is(stage) -> None:
    stage.look(kind="uniform", color=(0.2, 0.25, 0.3), background="environment")
    camera = frame_bounds(np.full(3, -1.0), np.full(3, 1.0), 1.0)
    assert np.array_equal(stage.hdr((16, 16), camera, gi="many"), stage.hdr((16, 16), camera))


@pytest.mark.parametrize("lens", [{"ymag": 1.2, "znear": 0.1, "zfar": 10.0}, {"znear": 1e-3, "zfar": 1e6}], ids=str)
def test_other_cameras(stage, surface, lens) -> None:
    usual = corner(stage, surface)
    camera = Camera(usual.world_from_camera, 0.9, **lens)
    seen = indirect(stage, camera, (64, 64), gi_directions=2, gi_steps=24, gi_half=False)
    y, x = pixel_of(camera, (0.0, 0.0, -0.1), 64)
    assert seen[y - 1 : y + 2, x - 1 : x + 2].mean() == pytest.approx(wall_seen(0.4), abs=0.03)


def test_lengths_follow_the_scene() -> None:
    assert size_of(np.zeros(3), np.array([3.0, 4.0, 0.0])) == 5.0
    assert size_of(np.zeros(3), np.zeros(3)) == size_of(np.zeros(3), np.full(3, np.inf)) == 1.0
    found = lengths_of(RenderSettings(gi_radius=2.0), 10.0)
    assert found["radius"] == 2.0
    assert found["separation"] == pytest.approx(0.2)


@pytest.mark.parametrize("texture", ["layer0_sent", "layer_depths", "layer_sides"])
def test_bad_numbers_end_where_they_are_read(stage, surface, texture) -> None:
    """What is no number in what the gather and the mirrors read: the picture has none."""
    camera = lamp_scene(stage, surface)
    view = stage.view((24, 20), camera, gi="one", reflections=True)
    clean = poison.shoot(stage.runtime, view, "indirect")
    for value in ("nan", "inf", "huge"):
        shot = poison.shoot(stage.runtime, view, "indirect", (texture, 12, 12, poison.VALUES[value]))
        assert np.isfinite(shot.hdr).all()
    assert np.isfinite(clean.hdr).all()


def test_bad_lights_and_normals(stage, surface) -> None:
    camera = lamp_scene(stage, surface)
    ball = uv_sphere(0.3, 8, 16)
    flat = replace(ball, streams={**ball.streams, "normal": np.zeros_like(ball.streams["normal"])})
    stage.add(flat, surface(**GREY), (-0.7, 0.3, 0.2))
    stage.lamp(LightAsset("point", intensity=1e8), (0.0, 0.05, 0.6))
    stage.lamp(LightAsset("spot", intensity=5.0, inner_angle=0.0, outer_angle=0.0), (0.0, 1.0, 0.0))
    seen = stage.hdr((32, 24), camera, gi="many", reflections=True)
    assert np.isfinite(seen).all()
    assert (seen >= 0.0).all()
