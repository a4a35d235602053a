from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engine.core.errors import InputError
from engine.math import quat, transform
from engine.scene.nodes import NodeTable
from engine.scene.scene import Scene


def reference_world(nodes: NodeTable) -> dict[int, np.ndarray]:
    """Naive recursion over local matrices."""

    def world(row: int) -> np.ndarray:
        local = nodes.local_matrix(row)
        above = int(nodes.parent[row])
        return local if above < 0 else world(above) @ local

    return {row: world(row) for row in nodes.alive_rows().tolist()}


def check(nodes: NodeTable) -> None:
    for row, m in reference_world(nodes).items():
        size = max(1.0, float(np.abs(m).max()))
        assert np.allclose(nodes.world_matrix(row), m, rtol=1e-9, atol=1e-9 * size), row


def random_trs(rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    scale = rng.uniform(0.5, 1.5, size=(count, 3)) * rng.choice([-1, 1], size=(count, 3))
    return rng.normal(size=(count, 3)), quat.normalize(rng.normal(size=(count, 4))), scale


def random_tree(rng: np.random.Generator, count: int) -> NodeTable:
    nodes = NodeTable()
    parents = np.array([rng.integers(-1, i) if i else -1 for i in range(count)])
    nodes.add_many([f"n{i}" for i in range(count)], None, *random_trs(rng, count), batch_parents=parents)
    return nodes


@given(seed=st.integers(0, 2**32 - 1), count=st.integers(1, 60))
@settings(max_examples=40, deadline=None)
def test_random_edits_match_recursion(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    nodes = random_tree(rng, count)
    nodes.update()
    check(nodes)
    for _ in range(8):
        rows = nodes.alive_rows()
        some = rng.choice(rows, size=rng.integers(1, len(rows) + 1), replace=False)
        match rng.integers(0, 7):
            case 0:
                nodes.set_translation(some, rng.normal(size=(len(some), 3)))
            case 1:
                nodes.set_rotation(some, rng.normal(size=(len(some), 4)))
            case 2:
                nodes.set_scale(some, rng.uniform(-1, 1, size=(len(some), 3)))
            case 3:
                nodes.set_trs(some, *random_trs(rng, len(some)))
            case 4:
                nodes.set_matrix(int(some[0]), np.vstack([rng.normal(size=(3, 4)), [0, 0, 0, 1]]))
            case 5 if len(rows) > 1:
                nodes.remove(int(some[0]))
                if nodes.alive_count == 0:
                    nodes.add("again")
            case _:
                below = int(some[0])
                above = int(rng.choice(rows))
                if below == above:
                    nodes.reparent(below, -1)
                else:
                    try:
                        nodes.reparent(below, above)
                    except InputError:
                        nodes.add("new", above, rng.normal(size=3))
        before = nodes.world.copy()
        changed = nodes.update()
        check(nodes)
        same = np.setdiff1d(np.arange(len(before)), changed)
        assert np.array_equal(nodes.world[same[same < len(before)]], before[same[same < len(before)]])


def test_update_reports_exactly_the_touched_subtree() -> None:
    nodes = NodeTable()
    a = nodes.add("a")
    b = nodes.add("b", a)
    c = nodes.add("c", b)
    d = nodes.add("d", a)
    nodes.update()
    nodes.set_translation(b, [1, 2, 3])
    assert nodes.update().tolist() == [b, c]
    assert nodes.changed_linear.tolist() == []
    nodes.set_rotation(b, quat.from_axis_angle([0, 1, 0], 1.0))
    assert nodes.update().tolist() == [b, c]
    assert nodes.changed_linear.tolist() == [b, c]
    assert nodes.world_rev[[b, c]].tolist() == [nodes.transform_rev] * 2
    assert nodes.world_rev[d] < nodes.transform_rev


def test_update_of_untouched_tables_does_nothing() -> None:
    scene = Scene()
    scene.nodes.add("a")
    scene.update()
    rev = scene.transform_rev, scene.nodes.visible_rev, scene.instances.bounds_rev
    assert len(scene.update()) == 0
    assert (scene.transform_rev, scene.nodes.visible_rev, scene.instances.bounds_rev) == rev


@pytest.mark.parametrize("levels", [1000])
def test_deep_chain(levels: int) -> None:
    nodes = NodeTable()
    step = quat.from_axis_angle([0, 0, 1], 2 * math.pi / levels)
    nodes.add_many(
        [""] * levels, None, np.full((levels, 3), [1.0, 0, 0]), np.tile(step, (levels, 1)),
        batch_parents=np.arange(levels) - 1,
    )  # fmt: skip
    assert len(nodes.update()) == levels
    # a regular polygon of 1000 sides of length 1 closes
    assert np.allclose(nodes.world[-1, :, :3], np.eye(3), atol=1e-12)
    assert np.allclose(nodes.world[-1, :, 3], 0.0, atol=1e-9)
    assert np.linalg.norm(nodes.world[levels // 2, :, 3]) == pytest.approx(1 / math.sin(math.pi / levels), rel=1e-4)


def test_a_million_metres_away_nothing_is_lost() -> None:
    nodes = NodeTable()
    far = nodes.add("far", translation=[1e6, -1e6, 1e6])
    near = nodes.add("near", far, translation=[1e-6, 2e-6, 3e-6])
    nodes.update()
    assert np.allclose(nodes.world[near, :, 3] - nodes.world[far, :, 3], [1e-6, 2e-6, 3e-6], atol=3e-10)


@pytest.mark.parametrize("scale", [(0, 0, 0), (1, 0, 1), (-1, 1, 1), (1e-4, 1e-4, 1e-4), (1e300, 1e300, 1e300)])
def test_odd_scales(scale: tuple[float, float, float]) -> None:
    nodes = NodeTable()
    a = nodes.add("a", translation=[1, 2, 3], rotation=quat.from_axis_angle([1, 1, 0], 0.5), scale=scale)
    b = nodes.add("b", a, translation=[1, 1, 1])
    nodes.update()
    check(nodes)
    assert np.isfinite(nodes.world[b]).all()


def test_shear_matrix_is_kept_until_rotation_or_scale_is_set() -> None:
    nodes = NodeTable()
    shear = np.array([[1, 0.5, 0, 4], [0, 1, 0, 5], [0, 0, 1, 6], [0, 0, 0, 1.0]])
    a = nodes.add("a", matrix=shear)
    child = nodes.add("child", a, translation=[0, 1, 0])
    nodes.update()
    assert np.allclose(nodes.world_matrix(a), shear)
    assert np.allclose(nodes.world[child, :, 3], [4.5, 6, 6])
    nodes.set_translation(a, [0, 0, 0])
    nodes.update()
    assert np.allclose(nodes.world[child, :, 3], [0.5, 1, 0])
    assert nodes.has_matrix[a]
    nodes.set_scale(a, [1, 1, 1])
    nodes.update()
    assert not nodes.has_matrix[a]
    check(nodes)


def test_plain_matrix_becomes_trs() -> None:
    nodes = NodeTable()
    m = transform.compose([1, 2, 3], quat.from_axis_angle([0, 1, 0], 0.4), [2, 2, 2])
    a = nodes.add("a", matrix=m)
    nodes.update()
    assert not nodes.has_matrix[a]
    assert np.allclose(nodes.world_matrix(a), m)


def test_visibility_is_inherited() -> None:
    nodes = NodeTable()
    a = nodes.add("a")
    b = nodes.add("b", a)
    c = nodes.add("c", b)
    nodes.update()
    nodes.set_visible(b, False)
    assert len(nodes.update()) == 0, "visibility moves nothing"
    assert nodes.visible_world.tolist() == [True, False, False]
    nodes.set_visible([a, b], [False, True])
    nodes.update()
    assert nodes.visible_world.tolist() == [False, False, False]
    nodes.set_visible(a, True)
    nodes.update()
    assert nodes.visible_world[c]


def test_reparent_refuses_cycles_and_changes_nothing() -> None:
    nodes = NodeTable()
    a = nodes.add("a")
    b = nodes.add("b", a)
    c = nodes.add("c", b)
    for row, parent in ((a, c), (a, a), (b, c)):
        with pytest.raises(InputError, match="cannot hang node"):
            nodes.reparent(row, parent)
    nodes.update()
    assert nodes.parent.tolist() == [-1, a, b]


def test_removing_frees_a_subtree_and_adding_gets_the_rows_back() -> None:
    nodes = random_tree(np.random.default_rng(0), 30)
    nodes.update()
    gone = nodes.remove(3)
    assert not nodes.alive[gone].any()
    rows = nodes.add_many(["x"] * len(gone))
    assert sorted(rows.tolist()) == sorted(gone.tolist())
    assert (nodes.generation[rows] == 1).all()
    nodes.update()
    check(nodes)
    assert np.array_equal(nodes.world[rows], np.tile(np.eye(3, 4), (len(rows), 1, 1)))


def test_growth_keeps_values_and_is_amortised() -> None:
    nodes = NodeTable()
    arrays = set()
    for i in range(3000):
        nodes.add(f"n{i}", -1, [i, 0, 0])
        arrays.add(id(nodes._data["translation"]))
    nodes.update()
    assert np.array_equal(nodes.world[:, 0, 3], np.arange(3000))
    assert len(arrays) < 12


@pytest.mark.parametrize(
    ("call", "match"),
    [
        (lambda n: n.set_translation(0, [math.nan, 0, 0]), "not finite"),
        (lambda n: n.set_scale([0, 1], [[1, 1, 1], [1, math.inf, 1]]), "index 1"),
        (lambda n: n.set_translation([0, 1], np.zeros((3, 3))), "shape"),
        (lambda n: n.set_translation(7, [0, 0, 0]), "no node row 7"),
        (lambda n: n.set_translation(-1, [0, 0, 0]), "no node row -1"),
        (lambda n: n.add("x", 9), "no node row 9"),
        (lambda n: n.add_many(["x", "y"], batch_parents=[1, -1]), "earlier"),
        (lambda n: n.add("x", matrix=np.eye(3)), "shape"),
        (lambda n: n.set_matrix(0, np.full((4, 4), math.nan)), "not finite"),
        (lambda n: n.reparent(0, 5), "no node row 5"),
    ],
)
def test_wrong_input_is_named_and_changes_nothing(call: object, match: str) -> None:
    assert callable(call)
    nodes = NodeTable()
    nodes.add_many(["a", "b"])
    nodes.update()
    before = nodes.world.copy()
    with pytest.raises(InputError, match=match):
        call(nodes)
    assert len(nodes.update()) == 0
    assert len(nodes) == 2
    assert np.array_equal(nodes.world, before)


def test_columns_are_read_only() -> None:
    nodes = NodeTable()
    nodes.add("a")
    with pytest.raises(ValueError, match="read-only"):
        nodes.translation[0] = 1.0


def test_rows_may_be_slices_masks_and_lists() -> None:
    nodes = NodeTable()
    nodes.add_many(["a", "b", "c", "d"])
    nodes.set_translation(slice(1, 3), [[1, 0, 0], [2, 0, 0]])
    nodes.set_translation(np.array([True, False, False, True]), [9, 0, 0])
    assert nodes.translation[:, 0].tolist() == [9, 1, 2, 9]
    nodes.set_translation([3, 0], [[5, 0, 0], [6, 0, 0]])
    nodes.set_translation(slice(0, 4, 2), [7, 0, 0])
    assert nodes.translation[:, 0].tolist() == [7, 1, 7, 5]
    nodes.set_translation([], np.zeros((0, 3)))
    nodes.remove(1)
    with pytest.raises(InputError, match="removed"):
        nodes.set_translation(slice(0, 4), [0, 0, 0])
    with pytest.raises(InputError, match="row 1 was removed"):
        nodes.set_translation([3, 1], [0, 0, 0])


def test_node_views() -> None:
    scene = Scene()
    a = scene.node(scene.nodes.add("a"))
    b = scene.node(scene.nodes.add("b", a.row))
    assert b.parent == a
    assert a.children == [b]
    assert a.parent is None
    b.translation = [1, 2, 3]
    b.scale = [2, 2, 2]
    b.name = "bee"
    scene.update()
    assert np.allclose(b.world @ [1, 0, 0, 1], [3, 2, 3, 1])
    assert scene.find("bee") == b
    assert scene.find("b") is None
    b.parent = None
    assert a.children == []
    scene.remove(b.row)
    assert not b.is_alive
    assert "removed" in repr(b)
    for use in (lambda: b.name, lambda: b.world, lambda: b.children, lambda: setattr(b, "scale", [1, 1, 1])):
        with pytest.raises(InputError, match="removed"):
            use()
    again = scene.node(scene.nodes.add("again"))
    assert again.row == 1
    assert again != b
    with pytest.raises(InputError, match="removed"):
        _ = b.name
