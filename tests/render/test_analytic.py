"""Pictures whose right answer is known: furnace, grey card, Lambert, inverse square, translation and scale."""

from __future__ import annotations

import math

import numpy as np
import pytest

from engine.app.framing import frame_bounds
from engine.assets.primitives import card, cube, uv_sphere
from engine.assets.scene import LightAsset

pytestmark = pytest.mark.gl


@pytest.mark.parametrize("roughness", [0.0, 0.1, 0.25, 0.5, 0.75, 1.0])
@pytest.mark.parametrize("metallic", [0.0, 1.0])
def test_white_sphere_in_a_uniform_environment_disappears(stage, surface, roughness, metallic) -> None:
    stage.add(uv_sphere(), surface(base_color=(1, 1, 1, 1), metallic=metallic, roughness=roughness))
    picture = stage.hdr(background="environment")
    assert np.abs(picture[..., :3] - 1.0).max() < 2e-3  # a bit more than an fp16 target resolves at 1


def test_furnace_test_can_fail(stage, surface) -> None:
    stage.add(uv_sphere(), surface(base_color=(0.9, 0.9, 0.9, 1), metallic=1.0, roughness=0.5))
    assert np.abs(stage.hdr(background="environment")[..., :3] - 1.0).max() > 0.05


def test_grey_card_is_18_percent(stage, surface) -> None:
    stage.add(card(10.0), surface(base_color=(0.18, 0.18, 0.18, 1), features=("unlit",)))
    camera = frame_bounds(np.full(3, -0.5), np.full(3, 0.5), 1.0, azimuth=0.0, elevation=0.0)
    assert np.abs(stage.hdr(camera=camera)[..., :3] - 0.18).max() < 1e-4
    assert np.unique(stage.ldr(camera=camera)[..., :3]).tolist() == [118]  # round(255 * srgb(0.18))


def test_lambert_under_a_sun(stage, surface) -> None:
    """A diffuse card of albedo 0.18 under pi lux head-on sends out 0.18; at 60 degrees half of it."""
    for elevation, expected in ((0.0, 0.18), (math.radians(60.0), 0.09)):
        stage.look(kind="none", sun_illuminance=math.pi, sun_azimuth=0.0, sun_elevation=elevation)
        stage.add(card(10.0), surface(base_color=(0.18, 0.18, 0.18, 1), metallic=0.0, specular=0.0))
        camera = frame_bounds(np.full(3, -0.5), np.full(3, 0.5), 1.0, azimuth=0.0, elevation=0.0)
        assert stage.hdr(camera=camera)[32, 32, 0] == pytest.approx(expected, rel=2e-3)


def test_point_light_falls_with_the_square_of_the_distance(stage, surface) -> None:
    for distance in (1.0, 2.0, 4.0):
        stage.look(kind="none", sun_illuminance=0.0)
        stage.add(card(100.0), surface(base_color=(0.5, 0.5, 0.5, 1), metallic=0.0, specular=0.0))
        node = stage.runtime.scene.nodes.add("lamp", translation=(0, 0, distance))
        stage.runtime.scene.lights.add(node, LightAsset("point", intensity=math.pi))
        stage.runtime.update()
        camera = frame_bounds(np.full(3, -0.01), np.full(3, 0.01), 1.0, azimuth=0.0, elevation=0.0)
        assert stage.hdr((33, 33), camera)[16, 16, 0] == pytest.approx(0.5 / distance**2, rel=5e-3)


def _two_cubes(stage, surface, offset: tuple[float, float, float], scale: float):
    stage.look(kind="uniform", color=(0.4, 0.5, 0.6), sun_illuminance=2.0)
    for i, color in enumerate([(0.9, 0.2, 0.1, 1), (0.1, 0.3, 0.9, 1)]):
        position = tuple(o + scale * (i * 0.8 - 0.4) for o in offset)
        stage.add(cube(), surface(base_color=color, metallic=0.0, roughness=0.4), position, scale)
    center = np.array(offset)
    camera = frame_bounds(center - 1.2 * scale, center + 1.2 * scale, 1.0)
    return stage.hdr((96, 96), camera)


@pytest.mark.parametrize("offset", [(1e6, 0.0, 0.0), (-1e6, 2e6, 1e6)])
def test_a_scene_far_from_the_origin_looks_the_same(stage, surface, offset) -> None:
    near = _two_cubes(stage, surface, (0.0, 0.0, 0.0), 1.0)
    far = _two_cubes(stage, surface, offset, 1.0)
    differing = (np.abs(near - far)[..., :3].max(axis=-1) > 1e-3).mean()
    assert differing < 1e-3  # a few edge pixels may round the other way


@pytest.mark.parametrize("scale", [1e-4, 1e4])
def test_a_scaled_scene_looks_the_same(stage, surface, scale) -> None:
    one = _two_cubes(stage, surface, (0.0, 0.0, 0.0), 1.0)
    other = _two_cubes(stage, surface, (0.0, 0.0, 0.0), scale)
    assert (np.abs(one - other)[..., :3].max(axis=-1) > 1e-3).mean() < 1e-3


def test_nearer_surface_wins_in_both_draw_orders(stage, surface) -> None:
    """Two cards 1 mm apart, seen from 100 m: reversed depth keeps them apart."""
    for order in ((0.001, 0.0), (0.0, 0.001)):
        stage.look(kind="none", sun_illuminance=0.0)
        for z in order:
            color = (0, 1, 0, 1) if z > 0 else (1, 0, 0, 1)
            stage.add(card(40.0), surface(base_color=color, features=("unlit",)), (0.0, 0.0, z))
        camera = frame_bounds(np.full(3, -1.0), np.full(3, 1.0), 1.0, azimuth=0.0, elevation=0.0)
        camera.world_from_camera[:3, 3] = (0, 0, 100.0)
        camera.znear = 0.01
        picture = stage.hdr(camera=camera)
        assert (picture[24:40, 24:40, 1] == 1.0).all()


def test_blended_surfaces_are_sorted(stage, surface) -> None:
    """Half-transparent red in front of blue over black: 0.5 red + 0.25 blue, whatever the order of creation."""
    for order in ((0.5, -0.5), (-0.5, 0.5)):
        stage.look(kind="none", sun_illuminance=0.0, background="color", background_color=(0, 0, 0))
        for z in order:
            color = (1, 0, 0, 0.5) if z > 0 else (0, 0, 1, 0.5)
            stage.add(card(40.0), surface("transparent", base_color=color, features=("unlit",)), (0.0, 0.0, z))
        camera = frame_bounds(np.full(3, -1.0), np.full(3, 1.0), 1.0, azimuth=0.0, elevation=0.0)
        assert stage.hdr(camera=camera)[32, 32, :3] == pytest.approx((0.5, 0.0, 0.25), abs=1e-3)


def test_mirrored_node_keeps_its_outside(stage, surface) -> None:
    stage.look(kind="none", sun_illuminance=math.pi, sun_azimuth=0.0, sun_elevation=0.0)
    material = surface(base_color=(0.5, 0.5, 0.5, 1), metallic=0.0, specular=0.0)
    node = stage.add(cube(), material)
    camera = frame_bounds(np.full(3, -0.5), np.full(3, 0.5), 1.0, azimuth=0.0, elevation=0.0)
    plain = stage.hdr(camera=camera)
    stage.runtime.scene.nodes.set_scale([node], [(-1.0, 1.0, 1.0)])
    stage.runtime.update()
    assert np.abs(stage.hdr(camera=camera) - plain).max() < 1e-3
    assert plain[32, 32, 0] == pytest.approx(0.5, rel=5e-3)


def test_a_double_sided_glass_body_shows_its_far_side_through_the_near_one(stage, surface) -> None:
    """Half-covering white over black: the far face gives 0.5, the near one 0.5 + 0.5 * 0.5."""
    stage.look(kind="none", sun_illuminance=0.0, background="color", background_color=(0, 0, 0))
    glass = surface("transparent", ("unlit", "double_sided"), base_color=(1, 1, 1, 0.5))
    stage.add(uv_sphere(), glass)
    assert stage.hdr()[32, 32, 0] == pytest.approx(0.75, abs=1e-3)
