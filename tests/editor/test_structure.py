"""Structural edits and their exact undo, on real tables."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from edited_stage import act, document, state, without_view
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from editor.commands import structure
from editor.document import Document
from editor.saving import edited_scene
from engine.assets.scene import CameraAsset, LightAsset, MeshRef
from engine.core.errors import InputError
from engine.scene.scene import Scene

EDITS: dict[str, Callable[[Document], None]] = {
    "empty": lambda d: structure.add_empty(d, np.eye(4)),
    "light": lambda d: structure.add_light(d, np.eye(4), LightAsset("point"), 1),
    "camera": lambda d: structure.add_camera(d, np.eye(4), CameraAsset(), 1),
    "delete mesh": lambda d: structure.delete(d, (2,)),
    "delete tree": lambda d: structure.delete(d, (1, 2)),
    "delete bone": lambda d: structure.delete(d, (6,)),
    "delete all": lambda d: structure.delete(d, (0, 4)),
    "duplicate": lambda d: structure.duplicate(d, (1, 7)),
    "duplicate skewed": lambda d: structure.duplicate(d, (5,)),
    "group": lambda d: structure.group(d, (2, 5)),
    "reparent": lambda d: structure.reparent(d, (2,), 5),
    "to top": lambda d: structure.reparent(d, (2, 3), -1),
}


@pytest.mark.parametrize("name", EDITS)
def test_undo_restores_every_bit_and_redo_brings_it_back(name: str) -> None:
    doc = document()
    doc.select(2)
    before = state(doc)
    EDITS[name](doc)
    after = state(doc)
    assert after != before
    assert len(doc.history.entries) == 1
    doc.history.undo()
    assert state(doc) == before
    doc.history.redo()
    assert state(doc) == after
    doc.history.undo()
    assert state(doc) == before


def test_a_duplicate_carries_everything() -> None:
    doc = document()
    structure.duplicate(doc, (1,))
    scene = doc.runtime.scene
    (copy,) = doc.selection
    assert scene.nodes.name[copy] == "arm 2"
    box, lamp = doc.children_of(copy)
    assert [scene.nodes.name[r] for r in (box, lamp)] == ["box", "lamp"]
    parts = np.flatnonzero(scene.instances.node == box)
    assert scene.instances.material[parts].tolist() == [0, 1]
    assert scene.instances.drawn[parts].all()
    assert scene.lights.asset(int(np.flatnonzero(scene.lights.node == lamp)[0])).intensity == 3.0
    assert scene.sources[box].mesh == MeshRef("a.lmesh", 0, "box", ["red.material.toml"])
    assert np.array_equal(scene.nodes.world_matrix(copy), scene.nodes.world_matrix(1))


def test_a_duplicate_hangs_on_its_own_joints_where_they_are_duplicated_too() -> None:
    doc = document()
    scene = doc.runtime.scene
    skin, joint = int(scene.skins.node[0]), int(scene.skins.joint[0])
    structure.duplicate(doc, (skin,))
    assert scene.skins.joint.tolist() == [joint, joint]
    doc.history.undo()
    structure.duplicate(doc, (joint, skin))
    bone, copy = doc.selection
    assert scene.skins.node.tolist() == [skin, copy]
    assert scene.skins.joint.tolist() == [joint, bone]
    nodes = edited_scene(doc.runtime, doc.overrides).nodes
    names = {n.name: [nodes[j].name for j in n.joints] for n in nodes if n.joints}
    assert names == {"skin": ["bone"], "skin 2": ["bone 2"]}


def test_hanging_elsewhere_keeps_the_place_in_the_world() -> None:
    doc = document()
    nodes = doc.runtime.scene.nodes
    before = nodes.world_matrix(2)
    for parent in (5, -1, 1):
        structure.reparent(doc, (2,), parent)
        assert int(nodes.parent[2]) == parent
        assert nodes.world_matrix(2) == pytest.approx(before, abs=1e-12)


def test_a_node_cannot_hang_below_itself() -> None:
    doc = document()
    before = state(doc)
    with pytest.raises(InputError, match="part of it"):
        structure.reparent(doc, (1,), 2)
    assert state(doc) == before
    assert doc.history.entries == ()


def test_a_group_stands_in_the_middle_and_moves_nothing() -> None:
    doc = document()
    nodes = doc.runtime.scene.nodes
    before = {r: nodes.world_matrix(r) for r in (2, 3)}
    structure.group(doc, (2, 3))
    (new,) = doc.selection
    assert doc.children_of(new) == [2, 3]
    assert int(nodes.parent[new]) == 1
    middle = 0.5 * (before[2][:3, 3] + before[3][:3, 3])
    assert nodes.world_matrix(new)[:3, 3] == pytest.approx(middle)
    for row, matrix in before.items():
        assert nodes.world_matrix(row) == pytest.approx(matrix, abs=1e-12)


def test_what_is_saved_is_what_was_made() -> None:
    doc = document()
    structure.duplicate(doc, (2,))
    structure.delete(doc, (3,))
    structure.add_light(doc, np.eye(4), LightAsset("point", intensity=7.0))
    doc.edit("nodes", "translation", (1,), ((9.0, 0.0, 0.0),))
    doc.edit("nodes", "translation", (doc.selection[0],), ((0.0, 5.0, 0.0),))
    doc.runtime.scene.nodes.set_translation([6], [(4.0, 4.0, 4.0)])  # as a clip poses it: no edit
    asset = edited_scene(doc.runtime, doc.overrides)
    by_name = {n.name: n for n in asset.nodes}
    assert set(by_name) == {"root", "arm", "box", "box 2", "eye", "skewed", "bone", "skin", "Point light"}
    assert by_name["arm"].translation == (9.0, 0.0, 0.0)
    assert by_name["bone"].translation == (0.0, 0.0, 0.0)
    assert by_name["box 2"].mesh == by_name["box"].mesh
    light = by_name["Point light"].light
    assert light is not None
    assert (light.intensity, by_name["Point light"].translation) == (7.0, (0.0, 5.0, 0.0))
    assert by_name["skewed"].matrix == doc.runtime.asset.nodes[5].matrix
    assert [asset.nodes[j].name for j in by_name["skin"].joints] == ["bone"]
    again = Scene.from_asset(asset)
    assert not again.findings.items


def test_a_mesh_whose_joint_was_deleted_is_saved_rigid() -> None:
    doc = document()
    structure.delete(doc, (6,))
    asset = edited_scene(doc.runtime, doc.overrides)
    assert next(n for n in asset.nodes if n.name == "skin").joints == []


def test_a_row_used_again_does_not_take_over_old_edits() -> None:
    doc = document()
    structure.delete(doc, (2,))
    structure.add_empty(doc, np.eye(4))
    assert doc.selection == (2,), "the row is used again"
    doc.edit("nodes", "translation", (2,), ((7.0, 7.0, 7.0),))
    while doc.history.undo() is not None:
        pass
    asset = edited_scene(doc.runtime, doc.overrides)
    assert asset.nodes[2].translation == (0.1, 0.2, 0.3)


step = st.tuples(st.sampled_from(["structure", "move", "name", "light", "undo", "redo", "hide"]), st.integers(0, 10**6))


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.lists(step, max_size=25))
def test_any_sequence_of_edits_undoes_to_the_exact_start(steps: list[tuple[str, int]]) -> None:
    doc = document()
    start = state(doc)
    for kind, seed in steps:
        act(doc, kind, seed)
    doc.history.end_gesture()
    end, count = state(doc), len(doc.history.entries)
    doc.history.go_to(0)
    assert without_view(state(doc)) == without_view(start)
    doc.history.go_to(count)
    assert without_view(state(doc)) == without_view(end)
