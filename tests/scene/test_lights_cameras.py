from __future__ import annotations

import math

import numpy as np
import pytest

from engine.assets.scene import CameraAsset, LightAsset
from engine.core.errors import InputError
from engine.core.findings import Findings
from engine.math import quat
from engine.scene import cameras, lights
from engine.scene.scene import Scene


def test_world_rows() -> None:
    scene = Scene()
    turn = quat.from_axis_angle([0, 1, 0], math.pi / 2)
    above = scene.nodes.add("above", translation=[0, 10, 0])
    a = scene.nodes.add("a", above, translation=[1, 2, 3], rotation=turn, scale=[5, 5, 5])
    scene.lights.add(a, LightAsset("spot", (1, 0.5, 0.25), 8.0, 20.0, 0.1, 0.2))
    scene.lights.add(above, LightAsset("directional", intensity=3.0))
    scene.update()
    spot, sun = scene.lights.world()
    assert np.allclose(spot["position"], [1, 12, 3])
    assert np.allclose(spot["direction"], [-1, 0, 0], atol=1e-7), "-Z turned a quarter about +Y"
    assert np.allclose(spot["radiant"], [8, 4, 2])
    assert (spot["type"], spot["range"]) == (2, 20.0)
    assert spot["cos_inner"] == pytest.approx(math.cos(0.1))
    assert spot["cos_outer"] == pytest.approx(math.cos(0.2))
    assert np.allclose(sun["direction"], [0, 0, -1])
    assert (sun["node"], sun["light"]) == (above, 1)
    counts = scene.counts()
    assert (counts.directional, counts.point, counts.spot) == (1, 0, 1)
    assert hash(counts) == hash(scene.counts())


def test_world_is_cached_until_something_changes() -> None:
    scene = Scene()
    node = scene.nodes.add("a")
    light = scene.lights.add(node, LightAsset("point"))
    scene.update()
    first = scene.lights.world()
    scene.update()
    assert scene.lights.world() is first
    scene.nodes.set_translation(node, [1, 0, 0])
    scene.update()
    assert scene.lights.world()["position"][0, 0] == 1
    scene.lights.set(light, intensity=7.0)
    assert scene.lights.world()["radiant"][0, 0] == 7
    scene.nodes.set_visible(node, False)
    scene.update()
    assert len(scene.lights.world()) == 0
    assert scene.counts().point == 0


def test_dark_lights_are_left_out() -> None:
    scene = Scene()
    node = scene.nodes.add("a")
    scene.lights.add(node, LightAsset("point", intensity=0.0))
    scene.lights.add(node, LightAsset("point", color=(0, 0, 0)))
    scene.update()
    assert len(scene.lights.world()) == 0


def test_light_on_a_node_of_no_size_is_finite() -> None:
    scene = Scene()
    scene.lights.add(scene.nodes.add("a", scale=[0, 0, 0]), LightAsset("directional"))
    scene.update()
    assert np.array_equal(scene.lights.world()["direction"], [[0, 0, -1]])


@pytest.mark.parametrize(
    ("given", "fixed"),
    [
        (LightAsset("laser"), {"type": "point"}),
        (LightAsset(intensity=-1.0), {"intensity": 0.0}),
        (LightAsset(intensity=math.nan), {"intensity": 0.0}),
        (LightAsset(intensity=math.inf), {"intensity": lights.MAX_INTENSITY}),
        (LightAsset(color=(-1.0, math.nan, 1e30)), {"color": (0.0, 0.0, lights.MAX_COLOR)}),
        (LightAsset(range=-5.0), {"range": 0.0}),
        (LightAsset(outer_angle=9.0), {"outer_angle": math.pi / 2}),
        (LightAsset(inner_angle=1.0, outer_angle=0.5), {"inner_angle": 0.5, "outer_angle": 0.5}),
    ],
)
def test_light_values_are_mended_and_noted(given: LightAsset, fixed: dict[str, object]) -> None:
    notes = Findings("f")
    light = lights.sanitize(given, notes, "nodes[3].light")
    for name, value in fixed.items():
        assert getattr(light, name) == value
    assert len(notes) >= 1
    assert all(f.where.path == "nodes[3].light" for f in notes)
    again = Findings()
    assert lights.sanitize(light, again) == light
    assert len(again) == 0


def test_good_light_is_untouched() -> None:
    notes = Findings()
    light = LightAsset("spot", (0.1, 0.2, 0.3), 500.0, 3.0, 0.2, 0.9)
    assert lights.sanitize(light, notes) == light
    assert len(notes) == 0


def test_unknown_field_and_row() -> None:
    scene = Scene()
    row = scene.lights.add(scene.nodes.add("a"))
    with pytest.raises(InputError, match="brightness"):
        scene.lights.set(row, brightness=3)
    with pytest.raises(InputError, match="no light row 4"):
        scene.lights.set(4, intensity=3)
    with pytest.raises(InputError, match="no node row 9"):
        scene.lights.add(9)


def test_camera_matrix_ignores_scale() -> None:
    scene = Scene()
    turn = quat.from_axis_angle([0, 1, 0], 0.3)
    node = scene.nodes.add("c", translation=[1, 2, 3], rotation=turn, scale=[3, 4, 5])
    row = scene.cameras.add(node, CameraAsset(yfov=0.5))
    scene.update()
    m = scene.cameras.world_from_camera(row)
    assert np.allclose(m[:3, :3], quat.to_matrix3(turn))
    assert np.allclose(m[:3, 3], [1, 2, 3])
    assert scene.cameras.asset(row) == CameraAsset(yfov=0.5)
    assert scene.cameras.of_node(node) == row
    assert scene.cameras.of_node(node + 1) == -1


@pytest.mark.parametrize(
    ("given", "name", "value"),
    [
        (CameraAsset("fisheye"), "type", "perspective"),
        (CameraAsset(yfov=math.nan), "yfov", CameraAsset().yfov),
        (CameraAsset(yfov=4.0), "yfov", CameraAsset().yfov),
        (CameraAsset(znear=-1.0), "znear", CameraAsset().znear),
        (CameraAsset(znear=1.0, zfar=0.5), "zfar", 0.0),
        (CameraAsset("orthographic", ymag=0.0), "ymag", 1.0),
        (CameraAsset(aspect=-2.0), "aspect", 0.0),
    ],
)
def test_camera_values_are_mended_and_noted(given: CameraAsset, name: str, value: object) -> None:
    notes = Findings()
    assert getattr(cameras.sanitize(given, notes), name) == value
    assert len(notes) == 1


def test_orthographic_may_begin_behind_the_camera() -> None:
    notes = Findings()
    assert cameras.sanitize(CameraAsset("orthographic", znear=-5.0, zfar=5.0), notes).znear == -5.0
    assert len(notes) == 0
