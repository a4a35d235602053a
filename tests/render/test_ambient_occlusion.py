"""Ambient occlusion: known answers, all paths alike, nothing where it is not wanted, extreme radii and sizes."""

from __future__ import annotations

import math

import numpy as np
import pytest

from engine.app.framing import frame_bounds
from engine.assets.primitives import card, cube, uv_sphere
from engine.assets.scene import LightAsset
from engine.math import quat
from engine.math.transform import look_at
from engine.render.camera import Camera
from engine.render.occlusion import METHODS, radius_of
from engine.render.settings import RenderSettings
from tests.support import poison

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


def test_beside_an_endless_wall_what_is_far_hides_less(stage, surface) -> None:
    """What a wall at distance x hides, with a fall-off of 1 - (d / radius)^2, by quadrature over the hemisphere."""
    stage.look(kind="uniform", color=(1.0, 1.0, 1.0))
    stage.add(card(40.0), surface(), rotation=FLAT)
    stage.add(cube(1.0), surface(), position=(0.0, 10.0, -0.5), scale=(40.0, 20.0, 1.0))
    camera = frame_bounds(np.array([-1, -0.1, -0.2]), np.array([1, 1, 1.8]), 1.0, azimuth=0.0, elevation=50.0)
    seen = visibility(stage, camera, (160, 160), ao_radius=1.0, ao_directions=8, ao_steps=32)
    clip = camera.clip_from_world(1.0)
    u, v = (np.indices((400, 400)).reshape(2, -1) + 0.5) / 400.0
    towards = np.sqrt(u) * np.cos(2.0 * np.pi * v)  # cosine-weighted directions' part towards the wall
    for x in (0.25, 0.5, 0.75):
        distance = np.where(towards > 1e-9, x / np.maximum(towards, 1e-9), np.inf)
        expected = 1.0 - np.mean(np.clip(1.0 - distance**2, 0.0, 1.0))
        p = clip @ np.array([0.0, 0.0, x, 1.0])
        column, row = int((p[0] / p[3] + 1) * 80), int((1 - p[1] / p[3]) * 80)
        assert seen[row, column] == pytest.approx(expected, abs=0.015), x


def light_beside_a_wall(x: np.ndarray) -> np.ndarray:
    """What is left at distance x of an endless wall, with a fall-off over 1 m, by quadrature over the hemisphere."""
    u, v = (np.indices((100, 400)).reshape(2, -1) + 0.5) / np.array([[100.0], [400.0]])
    towards = np.sqrt(u) * np.cos(2.0 * np.pi * v)  # cosine-weighted directions' part towards the wall
    way = np.where(towards > 1e-9, 1.0 / np.maximum(towards, 1e-9), np.inf)
    return np.array([1.0 - np.mean(np.clip(1.0 - (at * way) ** 2, 0.0, 1.0)) for at in x])


@pytest.mark.parametrize("method", METHODS)
def test_sixteen_places_are_enough_beside_a_wall(stage, surface, method) -> None:
    """Of all that stands 0.1 to 1.2 m before it: rmse before any filter (0.06 with hbao), and the bias of the mean."""
    stage.look(kind="uniform", color=(1.0, 1.0, 1.0))
    stage.add(card(40.0), surface(), rotation=FLAT)
    stage.add(cube(1.0), surface(), position=(0.0, 10.0, -0.5), scale=(40.0, 20.0, 1.0))
    camera = frame_bounds(np.array([-1, -0.1, -0.2]), np.array([1, 1, 1.8]), 1.0, azimuth=0.0, elevation=50.0)
    places = {"ao_directions": 2, "ao_steps": 16 if method == "alchemy" else 4}
    view = stage.view((96, 96), camera, ambient_occlusion=method, view="ambient_occlusion", ao_radius=1.0, **places)
    raw = poison.shoot(stage.runtime, view, "ambient_occlusion").outputs["ambient_visibility_raw"][..., 0]
    z = np.linspace(0.1, 1.2, 60)
    ends = np.stack([np.zeros(60), np.zeros(60), z, np.ones(60)], axis=1) @ camera.clip_from_world(1.0).T
    row = ((1.0 - ends[:, 1] / ends[:, 3]) * 48).astype(int)
    off = raw[row, 24:72].astype(np.float64) - light_beside_a_wall(z)[:, None]
    assert np.sqrt(np.mean(off**2)) < (0.06 if method == "hbao" else 0.05)
    assert abs(off.mean()) < 0.05


def open_part(distances, reach: float) -> float:
    """What is left of a hemisphere of light: `distances` to what stands in each direction of `cosine_directions`."""
    return float(1.0 - np.clip(1.0 - (distances / reach) ** 2, 0.0, 1.0).mean())


def cosine_directions(count: int = 20000) -> np.ndarray:
    """f8[n,3] about +Z, as many as their cosine."""
    u = (np.arange(count) + 0.5) / count
    angle = np.arange(count) * 2.399963
    return np.stack([np.sqrt(u) * np.cos(angle), np.sqrt(u) * np.sin(angle), np.sqrt(1.0 - u)], axis=1)


def test_a_ball_hides_the_ground_that_it_stands_on(stage, surface) -> None:
    """By rays from places before it; one that is thought to have no body hides too little."""
    stage.look(kind="uniform", color=(1.0, 1.0, 1.0))
    stage.add(card(10.0), surface(), rotation=FLAT)
    stage.add(uv_sphere(), surface(), position=(0.0, 0.5, 0.0))
    camera = above(1.0, 0.8)
    d = cosine_directions() @ np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]], float)  # about +Y
    clip, off = camera.clip_from_world(1.0), {}
    for thickness in (0.0, 1.0):
        seen = visibility(stage, camera, ao_radius=0.5, ao_thickness=thickness, ao_directions=8, ao_steps=16)
        off[thickness] = []
        for z in (0.3, 0.4, 0.5):
            b = d @ np.array([0.0, -0.5, z])
            inside = b * b - (0.25 + z * z - 0.25)
            near = np.where((inside > 0.0) & (b < 0.0), -b - np.sqrt(np.maximum(inside, 0.0)), np.inf)
            p = clip @ np.array([0.0, 0.0, z, 1.0])
            x, y = int((p[0] / p[3] + 1) * 48), int((1 - p[1] / p[3]) * 48)
            off[thickness].append(seen[y, x] - open_part(near, 0.5))
    assert np.abs(off[1.0]).max() < 0.05
    assert min(off[0.0]) > 0.15


def test_what_stands_before_a_wall_hides_no_more_than_itself(stage, surface) -> None:
    """A bar half a metre before a wall: beside it, light comes past it on both of its sides."""
    stage.look(kind="uniform", color=(1.0, 1.0, 1.0))
    stage.add(card(10.0), surface())
    stage.add(cube(1.0), surface(), position=(0.0, 0.0, 0.5), scale=(0.1, 10.0, 0.1))
    camera = Camera(look_at((0.6, 0.0, 3.0), (0.6, 0.0, 0.0)), 0.5)
    seen = visibility(stage, camera, ao_radius=1.0, ao_thickness=0.1, ao_directions=16, ao_steps=32)
    d, clip = cosine_directions(), camera.clip_from_world(1.0)
    for x in (0.1, 0.3, 0.5):
        low, high = ((np.array([[-0.05], [0.05]]) - x) / d[:, 0]), np.array([[0.45], [0.55]]) / d[:, 2]
        enter, leave = np.maximum(low.min(axis=0), high.min(axis=0)), np.minimum(low.max(axis=0), high.max(axis=0))
        near = np.where((enter < leave) & (leave > 0.0), enter, np.inf)
        p = clip @ np.array([x, 0.0, 0.0, 1.0])
        assert seen[48, int((p[0] / p[3] + 1) * 48)] == pytest.approx(open_part(near, 1.0), abs=0.03), x


def test_light_comes_from_where_it_is_open(stage, surface) -> None:
    """Beside a wall, the ground is lit as ground that is tilted away from it would be."""
    sky = {"kind": "sky", "sun_elevation": 0.3, "sun_azimuth": 1.2, "sun_illuminance": 0.0}
    matt = {"base_color": (1.0, 1.0, 1.0, 1.0), "metallic": 0.0, "roughness": 1.0}
    camera = above(1.0, 1.2)
    tilted = {}
    for side in (-1.0, 1.0):
        stage.look(**sky)
        turned = quat.multiply(quat.from_axis_angle((0.0, 0.0, 1.0), -0.5 * side), FLAT)
        stage.add(card(10.0), surface(**matt), rotation=turned)
        tilted[side] = float(stage.hdr((32, 32), camera)[16, 16].sum())
    stage.look(**sky)
    stage.add(card(10.0), surface(**matt), rotation=FLAT)
    for x in (-1.0, 1.0):
        stage.add(cube(1.0), surface(**matt), position=(x, 0.5, 0.0), scale=(0.4, 1.0, 3.0))
    settings = {"ambient_occlusion": "gtao", "ao_radius": 0.8}
    plain = stage.hdr((96, 96), camera, ao_bent=False, **settings)
    bent = stage.hdr((96, 96), camera, **settings)
    clip = camera.clip_from_world(1.0)
    more = {}
    for side in (-1.0, 1.0):
        at = clip @ np.array([-side * 0.55, 0.0, 0.0, 1.0])  # open towards `side`
        column, row = int((at[0] / at[3] + 1) * 48), int((1 - at[1] / at[3]) * 48)
        more[side] = float(bent[row, column].sum() / plain[row, column].sum())
    assert abs(tilted[1.0] / tilted[-1.0] - 1.0) > 0.05
    assert (more[1.0] > more[-1.0]) == (tilted[1.0] > tilted[-1.0])
    assert abs(more[1.0] - more[-1.0]) > 0.02
    for path in PATHS:
        assert np.array_equal(stage.hdr((96, 96), camera, path=path, **settings), bent), path


def test_bounces_only_add_and_never_more_than_all(stage, surface) -> None:
    """In a white furnace what hides is as bright as what it hides, so some of the light is still missing."""
    camera = above(1.0, 1.2)
    stage.look(kind="uniform", color=(1.0, 1.0, 1.0))
    white = surface(base_color=(0.9, 0.9, 0.9, 1.0), metallic=0.0, roughness=1.0)
    stage.add(card(10.0), white, rotation=FLAT)
    stage.add(cube(1.0), white, position=(0.0, 0.5, 0.0))
    settings = {"ambient_occlusion": "gtao", "ao_radius": 0.8, "ao_bent": False}
    open_to_all = stage.hdr((64, 64), camera)
    once = stage.hdr((64, 64), camera, **settings)
    again = stage.hdr((64, 64), camera, ao_bounces=True, **settings)
    assert (again >= once - 1e-3).all()
    assert (again - once).max() > 0.05
    assert (again <= open_to_all + 1e-3).all()


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
