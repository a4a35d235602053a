from __future__ import annotations

import math

import numpy as np
import pytest

from engine.core.errors import InputError
from engine.math import frustum, projection, quat, transform
from engine.scene.culling import visible_instances
from engine.scene.scene import Scene


def make(rng: np.random.Generator, count: int, offset: float = 0.0) -> Scene:
    scene = Scene()
    parents = np.array([rng.integers(-1, i) if i else -1 for i in range(count)])
    translation = rng.normal(size=(count, 3)) * 5
    translation[parents < 0] += offset
    scene.nodes.add_many(
        [""] * count, None, translation, quat.normalize(rng.normal(size=(count, 4))),
        rng.uniform(0.3, 1.5, size=(count, 3)), batch_parents=parents,
    )  # fmt: skip
    nodes = rng.integers(0, count, size=2 * count)
    scene.instances.add_many(
        nodes, 0, 0, 0, rng.normal(size=(2 * count, 3)), rng.uniform(0, 2, size=2 * count).astype(np.float32)
    )
    scene.update()
    return scene


def check_spheres(scene: Scene) -> None:
    table = scene.instances
    for row in table.alive_rows().tolist():
        m = scene.nodes.world_matrix(int(table.node[row]))
        expected = m @ [*table.bounds_center[row], 1.0]
        assert np.allclose(table.world_center[row], expected[:3], rtol=1e-12, atol=1e-9)
        sigma = np.linalg.svd(m[:3, :3], compute_uv=False)[0]
        exact = sigma * table.bounds_radius[row]
        assert exact <= table.world_radius[row] <= exact * math.sqrt(3) * 1.0001
        relative = table.world_center[row] - table.cull_origin
        assert np.allclose(table.cull_spheres[:3, row], relative, rtol=1e-6, atol=1e-6)
        spare = table.cull_spheres[3, row] - table.world_radius[row]
        assert 0.0 <= spare <= 2e-6 * (np.abs(relative).sum() + table.world_radius[row])
    assert (table.cull_spheres[4] == 1.0).all()


@pytest.mark.parametrize("seed", range(4))
def test_spheres_follow_the_nodes(seed: int) -> None:
    rng = np.random.default_rng(seed)
    scene = make(rng, 40)
    check_spheres(scene)
    for _ in range(6):
        rows = rng.choice(40, size=rng.integers(1, 41), replace=False)
        scene.nodes.set_translation(rows, rng.normal(size=(len(rows), 3)))
        if rng.random() < 0.5:
            scene.nodes.set_rotation(rows[:3], rng.normal(size=(len(rows[:3]), 4)))
        scene.update()
        check_spheres(scene)


def test_run_of_nodes_takes_the_fast_path_to_the_same_result() -> None:
    rng = np.random.default_rng(1)
    scene = Scene()
    scene.nodes.add_many([""] * 50)
    rows = scene.nodes.add_many([""] * 50, translations=rng.normal(size=(50, 3)))
    scene.instances.add_many(rows, 0, 0, 0, rng.normal(size=(50, 3)), 1.0)
    scene.update()
    check_spheres(scene)
    scene.nodes.set_translation(slice(0, 100), rng.normal(size=(100, 3)))
    scene.update()
    check_spheres(scene)
    scene.nodes.set_trs(slice(0, 100), [1, 2, 3], rng.normal(size=(100, 4)), [1, 2, 3])
    scene.update()
    check_spheres(scene)


def test_nodes_updated_twice_before_the_instances() -> None:
    scene = make(np.random.default_rng(2), 20)
    scene.nodes.set_translation(3, [1, 1, 1])
    scene.nodes.update()
    scene.nodes.set_rotation(5, [1, 0, 0, 1])
    scene.nodes.update()
    scene.instances.update()
    check_spheres(scene)


def test_removed_rows_are_holes_and_come_back() -> None:
    scene = make(np.random.default_rng(3), 20)
    rev = scene.structure_rev
    scene.instances.remove([4, 7])
    scene.update()
    assert scene.structure_rev > rev
    assert not scene.instances.drawn[[4, 7]].any()
    check_spheres(scene)
    assert scene.instances.add_many([1, 2], 9, 0, 0, np.zeros((2, 3)), 1.0).tolist() == [4, 7]
    scene.update()
    assert scene.instances.drawn[[4, 7]].all()
    check_spheres(scene)


def test_removing_a_node_removes_what_hangs_on_it() -> None:
    scene = Scene()
    a = scene.nodes.add("a")
    b = scene.nodes.add("b", a)
    c = scene.nodes.add("c")
    scene.instances.add_many([a, b, c], 0, 0, 0, np.zeros((3, 3)), 1.0)
    scene.lights.add(b)
    scene.cameras.add(b)
    scene.active_camera = b
    scene.update()
    assert scene.counts().lights == 1
    assert scene.remove(a).tolist() == [a, b]
    scene.update()
    assert scene.instances.drawn.tolist() == [False, False, True]
    counts = scene.counts()
    assert (counts.instances, counts.lights, counts.cameras) == (1, 0, 0)
    assert scene.active_camera == -1
    assert len(scene.lights.world()) == 0


def test_bad_bounds_and_nodes_are_refused() -> None:
    scene = Scene()
    node = scene.nodes.add("a")
    for center, radius in (([math.nan, 0, 0], 1.0), ([0, 0, 0], -1.0), ([0, 0, 0], math.inf)):
        with pytest.raises(InputError, match="finite"):
            scene.instances.add_many(node, 0, 0, 0, center, radius)
    with pytest.raises(InputError, match="no node row 3"):
        scene.instances.add_many([3], 0, 0, 0, [0, 0, 0], 1.0)
    assert len(scene.instances) == 0


def test_columns_of_another_length_are_refused() -> None:
    scene = Scene()
    rows = scene.nodes.add_many(["a", "b", "c"])
    with pytest.raises(InputError, match="another length"):
        scene.instances.add_many(rows, [1, 2], 0, 0, [0, 0, 0], 1.0)
    with pytest.raises(InputError, match="3 bounds"):
        scene.instances.add_many(rows, 0, 0, 0, np.zeros((2, 3)), 1.0)
    assert len(scene.instances) == 0


def test_bounds_and_materials_can_be_changed() -> None:
    scene = Scene()
    rows = scene.instances.add_many(scene.nodes.add_many(["a", "b"]), 0, 0, 5, [0, 0, 0], 1.0)
    scene.update()
    rev = scene.structure_rev
    scene.instances.set_bounds(rows[1], [1, 2, 3], 4.0)
    scene.instances.set_material(rows[1], 6)
    scene.update()
    assert scene.instances.material.tolist() == [5, 6]
    assert scene.structure_rev > rev
    check_spheres(scene)
    with pytest.raises(InputError, match="finite"):
        scene.instances.set_bounds(rows, [0, 0, 0], math.nan)


@pytest.mark.parametrize("offset", [0.0, 1e6, -3e7])
@pytest.mark.parametrize("seed", range(3))
def test_culling_against_float64(seed: int, offset: float) -> None:
    rng = np.random.default_rng(seed)
    scene = make(rng, 300, offset)
    scene.instances.set_visible(rng.choice(600, size=60, replace=False), False)
    scene.nodes.set_visible(rng.choice(300, size=5, replace=False), False)
    scene.update()
    drawn = scene.instances.drawn
    assert 0 < drawn.sum() < 540
    seen = 0
    for _ in range(20):
        eye = rng.normal(size=3) * 15 + offset
        view = transform.inverse_affine(transform.look_at(eye, rng.normal(size=3) * 10 + offset))
        planes = frustum.planes_from_matrix(projection.perspective_reversed(0.7, 1.5, 0.1) @ view)
        got = visible_instances(scene, planes)
        table = scene.instances
        exact = frustum.spheres_visible(planes, table.world_center, table.world_radius) & drawn
        assert (got | ~exact).all(), "a visible sphere was culled"
        grown = frustum.spheres_visible(planes, table.world_center, table.world_radius + 1e-3) & drawn
        assert (grown | ~got).all(), "a sphere well outside was kept"
        seen += int(got.sum())
    assert 0 < seen < 20 * drawn.sum()


def test_culling_an_empty_scene() -> None:
    scene = Scene()
    planes = frustum.planes_from_matrix(projection.perspective_reversed(1.0, 1.0, 0.1))
    assert visible_instances(scene, planes).shape == (0,)
    assert np.array_equal(scene.bounds(), np.zeros((2, 3)))


def test_an_overflowing_node_hides_only_itself() -> None:
    scene = Scene()
    rows = scene.nodes.add_many(["a", "b", "c"], batch_parents=[-1, 0, -1], scales=[[1e200] * 3, [1e200] * 3, [1] * 3])
    scene.nodes.set_translation(rows[1], [1e200, 0, 0])
    scene.nodes.set_translation(rows[2], [0, 0, -5])
    scene.instances.add_many(rows, 0, 0, 0, np.ones((3, 3)), 1.0)
    scene.update()
    planes = frustum.planes_from_matrix(projection.perspective_reversed(1.0, 1.0, 0.1))
    assert visible_instances(scene, planes)[2]
    assert np.isfinite(scene.bounds()).all()


def test_more_instances_than_one_block() -> None:
    count = 20_001
    rng = np.random.default_rng(9)
    scene = Scene()
    rows = scene.nodes.add_many([""] * count, translations=rng.uniform(-50, 50, size=(count, 3)))
    scene.instances.add_many(rows, 0, 0, 0, np.zeros((count, 3)), 1.0)
    scene.update()
    planes = frustum.planes_from_matrix(projection.perspective_reversed(1.0, 1.0, 0.1))
    table = scene.instances
    exact = frustum.spheres_visible(planes, table.world_center, table.world_radius)
    assert (visible_instances(scene, planes) == exact).mean() > 0.9999


def test_bounds_of_drawn_instances() -> None:
    scene = Scene()
    rows = scene.nodes.add_many(["a", "b"], translations=[[0, 0, 0], [10, 0, 0]])
    scene.instances.add_many(rows, 0, 0, 0, [[0, 0, 0], [0, 1, 0]], [1.0, 2.0])
    scene.update()
    assert np.allclose(scene.bounds(), [[-1, -1, -2], [12, 3, 2]], atol=1e-5)
    scene.nodes.set_visible(rows[1], False)
    scene.update()
    assert np.allclose(scene.bounds(), [[-1, -1, -1], [1, 1, 1]], atol=1e-5)
