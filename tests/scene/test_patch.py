"""ScenePatch: the difference of two states of the tables, put back bit by bit, also as text."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from engine.assets.scene import LightAsset, MeshRef, NodeAsset, SceneAsset
from engine.scene.patch import difference, put, remember, side_from_plain, side_to_plain
from engine.scene.scene import Scene


@pytest.fixture
def scene() -> Scene:
    nodes = [NodeAsset(f"n{i}", i - 1, (0.1 * i, 0.0, 0.0), mesh=MeshRef("a.lmesh", 0)) for i in range(6)]
    nodes[3].light = LightAsset("spot")
    made = Scene.from_asset(SceneAsset("s", nodes))
    made.instances.add_many(range(6), 0, 0, 0, (0.0, 0.0, 0.0), 1.0)
    made.skins.add(5, [2, 3], np.broadcast_to(np.eye(4), (2, 4, 4)), [1.0, 1.0])
    made.update()
    return made


def bits(scene: Scene) -> Any:
    state = remember(scene)
    return (
        {n: (t.count, t.free, {c: v.tobytes() for c, v in t.columns.items()}) for n, t in state.tables.items()},
        state.names, {n: v.tobytes() for n, v in state.skins.items()}, state.sources, state.row_of_node.tolist(),
        scene.nodes.world[scene.nodes.alive].tobytes(), scene.instances.world_center.tobytes(),
    )  # fmt: skip


def test_nothing_changed_is_an_empty_patch(scene: Scene) -> None:
    patch = difference(scene, remember(scene))
    assert not patch.changes
    assert all(len(rows.rows) == 0 for rows in patch.after.tables.values())


def test_only_what_differs_is_kept(scene: Scene) -> None:
    before = remember(scene)
    scene.nodes.set_translation([2], [(9.0, 9.0, 9.0)])
    patch = difference(scene, before)
    assert patch.changes
    assert patch.after.tables["nodes"].rows.tolist() == [2]
    assert len(patch.after.tables["instances"].rows) == 0


def test_minus_zero_is_another_value(scene: Scene) -> None:
    before = remember(scene)
    scene.nodes.set_translation([2], [(-0.0, 0.0, 0.0)])
    scene.nodes.set_translation([3], [(-0.0, 0.0, 0.0)])
    start = difference(scene, before)
    assert start.changes
    put(scene, start.before)
    assert not np.signbit(scene.nodes.translation[3][0])


@pytest.mark.parametrize("as_text", [False, True])
def test_removal_comes_back_whole(scene: Scene, as_text: bool) -> None:
    start, before = bits(scene), remember(scene)
    generation = scene.nodes.generation.copy()
    scene.remove([2])
    gone = bits(scene)
    patch = difference(scene, before)
    sides = (patch.before, patch.after)
    if as_text:
        texts = [json.loads(json.dumps(side_to_plain(side))) for side in sides]
        sides = (side_from_plain(texts[0], scene), side_from_plain(texts[1], scene))
    put(scene, sides[0])
    assert bits(scene) == start
    assert scene.nodes.generation.tolist() == generation.tolist(), "views and clips of the nodes are good again"
    assert len(scene.skins) == 1
    put(scene, sides[1])
    assert bits(scene) == gone


def test_growth_over_the_capacity_and_back(scene: Scene) -> None:
    start, before = bits(scene), remember(scene)
    rows = scene.nodes.add_many([f"x{i}" for i in range(500)], np.zeros(500, int))
    scene.instances.add_many(rows, 1, 0, 0, (0.0, 0.0, 0.0), 2.0)
    scene.update()
    grown = bits(scene)
    patch = difference(scene, before)
    put(scene, patch.before)
    assert bits(scene) == start
    assert len(scene.nodes) == len(scene.nodes.name) == 6
    put(scene, patch.after)
    assert bits(scene) == grown


def test_rows_are_given_out_as_before_the_change(scene: Scene) -> None:
    before = remember(scene)
    scene.remove([4])
    put(scene, difference(scene, before).before)
    assert scene.nodes.add("fresh") == 6


def test_another_node_in_a_row_that_undo_took_away_is_not_taken_for_the_one_that_was_there(scene: Scene) -> None:
    for removed in (False, True):  # a row at the end of the table, a freed one
        if removed:
            scene.remove([4])
        before = remember(scene)
        row = scene.nodes.add("first")
        patch = difference(scene, before)
        first = int(scene.nodes.generation[row])
        put(scene, patch.before)
        put(scene, patch.after)
        assert scene.nodes.generation[row] == first, "redo brings the same one"
        put(scene, patch.before)
        assert scene.nodes.add("second") == row
        assert scene.nodes.generation[row] != first


def test_revisions_only_rise(scene: Scene) -> None:
    before, revision = remember(scene), scene.structure_rev
    scene.remove([4])
    patch = difference(scene, before)
    seen = [revision, scene.structure_rev]
    for side in (patch.before, patch.after, patch.before):
        put(scene, side)
        seen.append(scene.structure_rev)
    assert seen == sorted(set(seen)), "whoever keeps something by revision makes it anew"


def test_a_new_light_profile_survives_undo_redo_and_a_journal(scene: Scene) -> None:
    before = remember(scene)
    scene.lights.set(0, profile="lamp.ies", width=2.0)
    patch = difference(scene, before)
    put(scene, patch.before)
    assert scene.lights.asset(0).profile == ""
    fresh = Scene.from_asset(scene.to_asset())
    fresh.instances.add_many(range(6), 0, 0, 0, (0.0, 0.0, 0.0), 1.0)
    put(fresh, side_from_plain(json.loads(json.dumps(side_to_plain(patch.after))), fresh))
    assert (fresh.lights.asset(0).profile, fresh.lights.asset(0).width) == ("lamp.ies", 2.0)
