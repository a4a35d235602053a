"""The floor that only shadows are seen of: dark where the light of the sun is missing, and nothing at all elsewhere."""

from __future__ import annotations

import math

import numpy as np
import pytest

from engine.assets.primitives import card, cube, uv_sphere
from engine.assets.scene import LightAsset
from engine.math import quat
from engine.math.transform import look_at
from engine.render.camera import Camera
from engine.render.lighting import PATHS
from engine.render.shadows.floor import ShadowFloor

pytestmark = pytest.mark.gl

#: 45 degrees high in -X: the shadow of a cube of 1 m lies beside it, to x = 1.5
SUN = {"sun_illuminance": 2.0, "sun_azimuth": -math.pi / 2, "sun_elevation": math.pi / 4}
BACKGROUND = (0.4, 0.3, 0.2)
SIZE = (96, 96)


def from_above() -> Camera:
    return Camera(look_at((0.0, 9.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, -1.0)), znear=0.1, zfar=30.0, ymag=3.0)


def pixel(x: float, z: float) -> tuple[int, int]:
    return int((z / 3 * 0.5 + 0.5) * SIZE[1]), int((x / 3 * 0.5 + 0.5) * SIZE[0])


def set_up(stage, surface, **environment) -> None:
    stage.look(**{"kind": "none", "background": "color", "background_color": BACKGROUND, **SUN, **environment})
    stage.add(cube(1.0), surface(base_color=(0.5, 0.5, 0.5, 1), metallic=0.0))


@pytest.mark.parametrize("samples", [1, 4])
def test_inside_is_dark_and_outside_is_the_background_to_the_bit(stage, surface, samples) -> None:
    set_up(stage, surface)
    plain = stage.hdr(SIZE, from_above(), samples=samples)
    floor = stage.hdr(SIZE, from_above(), samples=samples, shadow_floor=0.75)
    inside, outside = pixel(1.0, 0.0), pixel(-1.5, 0.0)
    np.testing.assert_allclose(floor[inside][:3], 0.25 * np.array(BACKGROUND), rtol=2e-3)
    assert (floor[outside] == plain[outside]).all()
    changed = (floor != plain).any(axis=-1)
    _rows, columns = np.nonzero(changed)
    x = (columns + 0.5) / SIZE[0] * 6 - 3
    assert changed[inside]
    assert x.min() > 0.4
    assert x.max() < 1.65
    assert (floor[pixel(0.0, 0.0)] == plain[pixel(0.0, 0.0)]).all(), "what stands on it hides it"


def test_light_from_all_around_fills_the_shadow(stage, surface) -> None:
    """A floor gets pi of an environment of 1, and 2 cos 45 degrees of the sun."""
    set_up(stage, surface, kind="uniform", color=(1.0, 1.0, 1.0))
    floor = stage.hdr(SIZE, from_above(), shadow_floor=1.0)
    share = math.pi / (math.pi + 2.0 * math.cos(math.pi / 4))
    np.testing.assert_allclose(floor[pixel(1.0, 0.0)][:3], share * np.array(BACKGROUND), rtol=5e-3)


def test_all_paths_draw_one_floor_with_the_shadows_of_lamps(stage, surface) -> None:
    set_up(stage, surface, sun_illuminance=0.0)
    stage.lamp(LightAsset("point", (1.0, 1.0, 1.0), 30.0, 12.0), (-2.0, 2.0, 0.0))
    settings = {"local_shadows": "all", "shadow_floor": 1.0}
    pictures = [stage.hdr(SIZE, from_above(), path=path, **settings) for path in PATHS]
    plain = stage.hdr(SIZE, from_above(), path="forward", local_shadows="all")
    assert (pictures[0][pixel(1.0, 0.0)][:3] < 0.1 * np.array(BACKGROUND)).all()
    assert (pictures[0][pixel(-1.5, 1.5)] == plain[pixel(-1.5, 1.5)]).all()
    for other in pictures[1:]:
        assert (other == pictures[0]).all()


def test_from_below_and_without_shadows_there_is_no_floor(stage, surface) -> None:
    set_up(stage, surface)
    below = Camera(look_at((0.0, -4.0, 0.1), (0.0, 0.0, 0.0), (0.0, 0.0, -1.0)), 0.9, 0.1)
    assert (stage.hdr(SIZE, below, shadow_floor=1.0) == stage.hdr(SIZE, below)).all()
    off = stage.runtime.render(stage.view(SIZE, from_above(), shadow_floor=1.0, shadows=False))
    assert "shadow_floor" in {item.name for item in off.graph.left_out}


def test_it_lies_at_the_lowest_vertex_also_of_what_is_turned(stage, surface) -> None:
    set_up(stage, surface)
    scene, floor = stage.runtime.scene, ShadowFloor(stage.runtime.residency)
    assert floor.height(scene) == pytest.approx(-0.5)
    stage.add(uv_sphere(0.5), surface(), (0.0, -2.0, 0.0), 1.0, quat.from_axis_angle((1.0, 0.0, 1.0), 0.6))
    assert floor.height(scene) == pytest.approx(-2.5, abs=0.01)
    stage.look(kind="none")
    assert floor.height(stage.runtime.scene) == 0.0


@pytest.mark.parametrize("half", [False, True])
def test_it_is_dark_where_things_stand_on_it(stage, surface, half) -> None:
    """As a floor that is seen is, of the light of surroundings alone; and in the open it is not there at all."""
    occlusion = {"samples": 1, "ambient_occlusion": "gtao", "ao_radius": 0.6, "ao_directions": 4, "ao_half": half}
    camera = Camera(look_at((0.0, 2.5, 4.0), (0.0, -0.3, 0.0)), 0.7)
    set_up(stage, surface, kind="uniform", color=(1.0, 1.0, 1.0), sun_illuminance=0.0)
    plain = stage.hdr(SIZE, camera, **occlusion)
    ours = stage.hdr(SIZE, camera, shadow_floor=1.0, **occlusion)
    gone = stage.hdr(SIZE, camera, shadow_floor=1.0, samples=1)
    assert (gone == stage.hdr(SIZE, camera, samples=1)).all()
    ground = (plain == plain[0, 0]).all(axis=-1)
    assert (ours[~ground] == plain[~ground]).all(), "it hides no light from what stands on it"
    left = (ours[..., 0] / plain[..., 0]).astype(np.float64)
    assert (left[-4:] == 1.0).all()
    assert left[ground].min() < 0.75
    flat = quat.from_axis_angle((1.0, 0.0, 0.0), -math.pi / 2)
    stage.add(card(20.0), surface(), (0.0, -0.5, 0.0), rotation=flat)
    seen = stage.hdr(SIZE, camera, view="ambient_occlusion", **occlusion)[..., 0].astype(np.float64)
    near = ground & (left < 1.0)
    assert near.sum() > 300
    assert np.abs(left - seen)[near].mean() < 0.02
