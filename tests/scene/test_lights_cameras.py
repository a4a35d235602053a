from __future__ import annotations

import math

import numpy as np
import pytest

from engine.assets.scene import CameraAsset, LightAsset
from engine.core.errors import InputError
from engine.core.findings import Findings
from engine.math import quat
from engine.scene import cameras, lights
from engine.scene.light_order import canonical_order
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


AREA = LightAsset("rectangle", (1, 0.5, 0.25), 8.0, 20.0, width=2.0, height=0.5, two_sided=True, temperature=3000.0)


def test_area_light_rows_and_their_frame() -> None:
    scene = Scene()
    turn = quat.from_axis_angle([0, 1, 0], math.pi / 2)
    scene.lights.add(scene.nodes.add("a", rotation=turn, scale=[5, 0.1, 5]), AREA)
    scene.lights.add(scene.nodes.add("flat", scale=[0, 0, 0]), LightAsset("disk", profile="x.ies"))
    scene.update()
    area, flat = scene.lights.world()
    assert np.allclose(area["right"], [0, 0, -1], atol=1e-6), "the node's X; its scale changes no size"
    assert area["half_size"].tolist() == [1.0, 0.25]
    assert (area["type"], area["two_sided"], flat["profile"]) == (3, True, -1)
    assert area["radiant"][0] > 8.0 > area["radiant"][2], "3000 K is warm"
    assert np.dot(flat["right"], flat["direction"]) == 0.0
    assert np.linalg.norm(flat["right"]) == pytest.approx(1.0)
    assert (scene.counts().area, scene.counts().lights) == (2, 2)
    assert scene.lights.asset(0) == AREA


@pytest.mark.parametrize(
    ("given", "fixed"),
    [
        (LightAsset("disk", width=-1.0), {"width": 0.0}),
        (LightAsset("disk", height=math.nan), {"height": 0.0}),
        (LightAsset("disk", width=math.inf), {"width": lights.MAX_SIZE}),
        (LightAsset(temperature=3.0), {"temperature": 500.0}),
        (LightAsset(temperature=-3.0), {"temperature": 0.0}),
        (LightAsset(temperature=1e9), {"temperature": 1e6}),
    ],
)
def test_new_light_values_are_mended(given: LightAsset, fixed: dict[str, object]) -> None:
    test_light_values_are_mended_and_noted(given, fixed)


def test_profiles_are_named_once() -> None:
    scene = Scene()
    node = scene.nodes.add("a")
    for path in ("a.ies", "", "b.ies", "a.ies"):
        scene.lights.add(node, LightAsset("spot", profile=path))
    assert scene.lights.profiles == ["a.ies", "b.ies"]
    assert scene.lights.profile.tolist() == [0, -1, 1, 0]
    assert [scene.lights.asset(row).profile for row in range(4)] == ["a.ies", "", "b.ies", "a.ies"]


def test_world_stays_while_only_others_move() -> None:
    scene = Scene()
    lamp, other = scene.nodes.add_many(["lamp", "other"], None, np.zeros((2, 3)), [[0, 0, 0, 1]] * 2, np.ones((2, 3)))
    scene.lights.add(int(lamp), LightAsset("point"))
    scene.update()
    first = scene.lights.world()
    for x in (1.0, 2.0):
        scene.nodes.set_translation(other, [x, 0, 0])
        scene.update()
        assert scene.lights.world() is first
    scene.nodes.set_translation(lamp, [7, 0, 0])
    scene.update()
    assert scene.lights.world()["position"][0, 0] == 7.0


def test_order_depends_on_the_values_alone() -> None:
    rng = np.random.default_rng(1)
    world = np.zeros(300, lights.WORLD_LIGHT)
    world["position"] = rng.integers(-2, 3, (300, 3))  # many share a place
    world["radiant"] = rng.integers(0, 3, (300, 3))
    world["range"] = rng.integers(0, 2, 300)
    shuffled = world[rng.permutation(300)]
    one, two = world[canonical_order(world)], shuffled[canonical_order(shuffled)]
    assert one.tobytes() == two.tobytes()
    assert sorted(canonical_order(world).tolist()) == list(range(300))
    step = np.linalg.norm(np.diff(one["position"], axis=0), axis=1).mean()
    assert step < 0.5 * np.linalg.norm(np.diff(world["position"], axis=0), axis=1).mean(), "neighbours are neighbours"
    assert len(canonical_order(world[:0])) == 0
    far = world[:2].copy()
    far["position"] = [[-1e300, 0, 0], [1e300, 0, 0]]
    assert sorted(canonical_order(far).tolist()) == [0, 1]
