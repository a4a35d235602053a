"""Shadows of point and spot lights: where geometry puts them, the same by every path, nothing where none are wanted."""

from __future__ import annotations

import math

import numpy as np
import pytest

from engine.assets.primitives import card, cube, uv_sphere
from engine.assets.scene import LightAsset
from engine.math import quat
from engine.math.transform import look_at
from engine.render.camera import Camera

pytestmark = pytest.mark.gl

PATHS = ("forward", "deferred", "tiled-deferred", "forward-plus")
DOWN = (math.sin(-math.pi / 4), 0.0, 0.0, math.cos(-math.pi / 4))  # -Z comes to point along -Y; a card comes to face +Y
SPOT = LightAsset("spot", intensity=20.0, inner_angle=0.7, outer_angle=0.8, casts_shadow=True)
POINT = LightAsset("point", intensity=20.0, casts_shadow=True)
WIDE = LightAsset("spot", intensity=20.0, inner_angle=1.2, outer_angle=1.4, casts_shadow=True)
LAMPS = {"spot": SPOT, "point": POINT}


def down(height: float = 6.0, half: float = 2.0) -> Camera:
    """Looks straight down on the square of that half width; x to the right, -z up; orthographic."""
    pose = look_at((0.0, height, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, -1.0))
    return Camera(pose, ymag=half, znear=0.1, zfar=2.0 * height)


def room(stage, surface, lamp: LightAsset, at=(0.0, 2.0, 0.0), scale: float = 1.0, move=(0.0, 0.0, 0.0)) -> int:
    """A floor, a square of half width 0.3 a metre above it, a lamp over both; the square's node."""
    stage.dark()
    move = np.asarray(move)
    stage.add(card(20.0), surface(metallic=0.0), move, rotation=DOWN, scale=scale)
    above = move + np.array([0.0, scale, 0.0])
    node = stage.add(card(0.6), surface(features=("double_sided",), metallic=0.0), above, rotation=DOWN, scale=scale)
    stage.lamp(lamp, np.asarray(at) * scale + move, DOWN)
    return node


def lit(stage, camera: Camera, size=(96, 96), **settings):
    """What is left of the light: f8[h,w], with shadows over without."""
    chosen = {"shadow_filter": "none", **settings}
    bright = stage.hdr(size, camera, **{**chosen, "local_shadows": "off"})[..., 0].astype(np.float64)
    with_shadows = stage.hdr(size, camera, **chosen)[..., 0].astype(np.float64)
    return np.where(bright > 1e-6, with_shadows / np.maximum(bright, 1e-6), np.nan)


@pytest.mark.parametrize("lamp", [SPOT, POINT, WIDE], ids=["spot", "point", "wide spot"])
@pytest.mark.parametrize("at", [(0.0, 2.0, 0.0), (0.35, 2.0, -0.2)])
def test_the_edge_is_where_rays_put_it(stage, surface, lamp, at) -> None:
    """Projected from the lamp, the square's corner (x, 1, z) lies at lamp + 2 ((x, z) - lamp) on the floor. The square
    itself, seen from above, hides the floor under it; so only what is outside of it is looked at."""
    room(stage, surface, lamp, at)
    n, half = 192, 1.0
    seen = lit(stage, down(half=half), (n, n))
    axis = (np.arange(n) + 0.5) / n * 2 * half - half
    x, z = np.meshgrid(axis, axis)
    shadow = np.ones((n, n), bool)
    beside = np.full((n, n), np.inf)
    for p, c in ((x, at[0]), (z, at[2])):
        low, high = 2 * -0.3 - c, 2 * 0.3 - c
        shadow &= (p > low) & (p < high)
        beside = np.minimum(beside, np.minimum(np.abs(p - low), np.abs(p - high)))
    floor = np.maximum(np.abs(x), np.abs(z)) > 0.33
    texel = 2.0 * 2.0 * math.tan(0.82) / 512  # at the floor; half the map's half at the least
    sure = floor & (beside > 1.5 * texel + 2 * half / n) & np.isfinite(seen)
    assert (sure & shadow).sum() > 1000
    assert (sure & ~shadow).sum() > 1000
    assert ((seen > 0.5) == ~shadow)[sure].all()


@pytest.mark.parametrize("kind", LAMPS)
@pytest.mark.parametrize("filter", ["none", "pcf", "vogel8", "evsm4", "msm"])
def test_no_acne_and_no_gap(stage, surface, kind, filter) -> None:
    """A floor and a wall hide nothing of themselves; a box on the floor darkens it right up to its foot."""
    stage.dark()
    stage.add(card(20.0), surface(metallic=0.0), rotation=DOWN)
    stage.lamp(LAMPS[kind], (0.0, 2.0, 0.0), DOWN)
    open_floor = lit(stage, down(half=3.0), (64, 64), shadow_filter=filter)
    assert np.nanmin(open_floor) > 0.99
    stage.add(cube(), surface(metallic=0.0), (0.7, 0.25, 0.0), 0.5)
    seen = lit(stage, down(half=1.5), (96, 96), shadow_filter=filter)
    foot = seen[48, int((0.95 + 0.05 + 1.5) / 3.0 * 96) : int((1.0 + 1.5) / 3.0 * 96) + 2]
    assert np.nanmax(foot) < 0.05
    assert np.nanmin(seen[:, :50]) > 0.99


def test_all_paths_and_the_forced_frame_agree(stage, surface) -> None:
    room(stage, surface, SPOT)
    stage.add(uv_sphere(), surface(base_color=(0.7, 0.3, 0.2, 1.0), metallic=0.0), (0.9, 0.4, 0.4), 0.8)
    stage.add(card(0.8), surface("transparent", base_color=(0.2, 0.4, 0.9, 0.5)), (-0.6, 0.3, 0.6), rotation=DOWN)
    stage.lamp(LightAsset("point", (1.0, 0.6, 0.3), 6.0, 6.0, casts_shadow=True), (1.2, 1.4, 1.2))
    stage.lamp(LightAsset("point", (0.2, 0.6, 1.0), 2.0, 6.0), (-1.2, 1.0, 1.2))
    camera = Camera(look_at((2.5, 3.0, 3.5), (0.0, 0.3, 0.0)), 0.8, znear=0.05)
    for filter in ("pcf", "msm", "vogel8"):
        truth = stage.hdr((48, 40), camera, path="forward", shadow_filter=filter)
        assert np.abs(truth - stage.hdr((48, 40), camera, path="forward", local_shadows="off")).max() > 0.1
        for path in PATHS[1:]:
            assert np.array_equal(stage.hdr((48, 40), camera, path=path, shadow_filter=filter), truth), path
    assert np.array_equal(stage.hdr((48, 40), camera, path="forward", shadow_filter="vogel8", force_all=True), truth)
    smooth = stage.hdr((48, 40), camera, path="forward-plus", samples=4, shadow_filter="vogel8")
    assert np.abs(smooth - truth).mean() < 0.02


def left_out(stage, camera: Camera, **settings) -> list[str]:
    frame = stage.runtime.renderer.render(stage.runtime.scene, stage.view((24, 24), camera, **settings))
    return [item.reason for item in frame.graph.left_out if item.name == "local_shadows"]


def test_nothing_in_the_frame_where_no_light_casts(stage, surface) -> None:
    quiet = LightAsset("spot", intensity=20.0, inner_angle=0.7, outer_angle=0.8)
    room(stage, surface, quiet)
    camera = down()
    assert "no local light that casts" in left_out(stage, camera)[0]
    bare = stage.hdr((32, 32), camera)
    assert np.array_equal(stage.hdr((32, 32), camera, force_all=True), bare)
    assert not left_out(stage, camera, local_shadows="all")
    assert np.abs(stage.hdr((32, 32), camera, local_shadows="all") - bare).max() > 0.1
    stage.runtime.scene.lights.set(0, casts_shadow=True)
    assert not left_out(stage, camera)
    assert left_out(stage, camera, local_shadows="off")
    assert np.array_equal(stage.hdr((32, 32), camera, local_shadows="off"), bare)
    stage.dark()
    stage.lamp(SPOT)
    assert left_out(stage, camera)  # nothing that casts
    assert not stage.hdr((8, 8), camera)[..., :3].any()


def test_a_lamp_inside_a_body_lights_nothing_outside(stage, surface) -> None:
    room(stage, surface, POINT)
    stage.add(uv_sphere(), surface(metallic=0.0), (0.0, 2.0, 0.0), 0.4)
    assert stage.hdr((48, 48), down(1.6), shadow_filter="pcf")[:, :, 0].max() == 0.0


def test_a_lamp_behind_the_camera_casts_into_the_view(stage, surface) -> None:
    room(stage, surface, SPOT, at=(0.0, 4.0, 0.0))
    camera = Camera(look_at((0.0, 0.9, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, -1.0)), 1.0, znear=0.05)
    seen = lit(stage, camera)
    assert np.nanmin(seen[48, 30:66]) < 0.01  # right under the square
    assert np.nanmax(seen[48, 30:66]) < 0.01


@pytest.mark.parametrize("kind", LAMPS)
def test_far_from_the_origin_and_at_any_scale(stage, surface, kind) -> None:
    room(stage, surface, LAMPS[kind])
    here = lit(stage, down())
    move = np.array([1e6, -1e6, 2e6])
    room(stage, surface, LAMPS[kind], move=move)
    pose = look_at(move + np.array([0.0, 6.0, 0.0]), move, (0.0, 0.0, -1.0))
    there = lit(stage, Camera(pose, ymag=2.0, znear=0.1, zfar=12.0))
    assert np.nanmean(np.abs(here - there)) < 1e-3
    for scale in (1e-3, 1e3):
        room(stage, surface, LAMPS[kind], scale=scale)
        stage.runtime.scene.lights.set(0, intensity=20.0 * scale * scale)
        camera = down(6.0 * scale, 2.0 * scale)
        camera = Camera(camera.world_from_camera, ymag=2.0 * scale, znear=0.1 * scale, zfar=12.0 * scale)
        assert np.nanmean(np.abs(here - lit(stage, camera))) < 2e-3, scale


@pytest.mark.parametrize("filter", ["pcf", "vogel8", "evsm4", "msm"])
def test_faces_of_a_point_light_meet_without_a_seam(stage, surface, filter) -> None:
    """A wall of a closed box, on which five of the six views meet: lit all over."""
    stage.dark()
    stage.add(cube(), surface(features=("double_sided",), metallic=0.0), (0.0, 0.0, 0.0), 4.0)
    stage.lamp(POINT, (-1.0, 0.2, -0.3))
    camera = Camera(look_at((1.9, 0.0, 0.0), (0.0, 0.0, 0.0)), ymag=1.85, znear=0.01, zfar=5.0)
    seen = lit(stage, camera, (128, 128), shadow_filter=filter, shadow_softness=3.0)
    assert np.isfinite(seen).all()
    assert seen.min() > 0.995


def test_too_many_lights_are_told_of(stage, surface) -> None:
    room(stage, surface, SPOT)
    for i in range(6):
        stage.lamp(LightAsset("point", intensity=1.0 + i, range=3.0, casts_shadow=True), (0.3 * i - 1.0, 1.0, 1.0))
    renderer, camera = stage.runtime.renderer, down()
    stage.hdr((16, 16), camera, local_shadow_lights=3)
    assert "4 of 7 lights" in str(renderer.light_findings.items[0])
    assert len({tile.position.tobytes() for tile in renderer.rows.local_shadows.tiles}) == 3
    stage.hdr((16, 16), camera, local_shadow_size=64)  # four tiles of 32: the spot and none of six faces
    assert "no room" in str(renderer.light_findings.items[0])
    assert len(renderer.rows.local_shadows.tiles) == 1
    stage.hdr((16, 16), camera)
    assert not len(renderer.light_findings)
    assert len(renderer.rows.local_shadows.tiles) == 1 + 6 * 6


@pytest.mark.parametrize("kind", LAMPS)
@pytest.mark.parametrize("filter", ["pcf", "vogel8", "evsm4", "msm"])
def test_no_dark_line_where_walls_meet(stage, surface, kind, filter) -> None:
    """A floor and two walls, a lamp before them: nothing hides anything, up to the corner itself."""
    stage.dark()
    wall = surface(features=("double_sided",), metallic=0.0)
    stage.add(card(4.0), wall, rotation=DOWN)
    stage.add(card(4.0), wall, (0.0, 2.0, -2.0))
    stage.add(card(4.0), wall, (-2.0, 2.0, 0.0), rotation=(0.0, math.sin(math.pi / 4), 0.0, math.cos(math.pi / 4)))
    pose = look_at((0.3, 1.6, 0.4), (-1.2, 0.5, -1.3))
    stage.lamp(LAMPS[kind], (0.3, 1.6, 0.4), quat.from_matrix3(pose[:3, :3]))
    seen = lit(stage, Camera(look_at((0.6, 1.9, 0.8), (-2.0, 0.0, -2.0)), 0.6, znear=0.05), shadow_filter=filter,
               local_shadow_size=1024)  # fmt: skip
    assert (seen < 0.9).mean() < 2e-3
