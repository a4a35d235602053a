"""Lights in the editor: scattered, repeated, outlined, given in other units, saved with their profiles."""

from __future__ import annotations

import copy
import math
from pathlib import Path

import numpy as np
import pytest
from edited_stage import document, state

from editor.camera_controls import OrbitCamera
from editor.commands import lights, structure
from editor.light_outlines import outline, pixels_of
from editor.panels.inspector_light import FIELDS, OF_KIND, UNIT_DOCS
from editor.saving import _carry_profiles, edited_scene
from engine.assets.scene import LightAsset, NodeAsset, SceneAsset
from engine.core.errors import InputError
from engine.math.photometry import UNITS
from engine.scene.arrays import ArraySettings, repeat_node
from engine.scene.lights import LIGHT_TYPES
from engine.scene.scatter import ScatterSettings
from engine.scene.scene import Scene

CAMERA = OrbitCamera((0.0, 0.0, 0.0), 0.3, -0.2, distance=8.0)


def test_scattering_is_one_entry_that_undo_takes_back_bit_by_bit(monkeypatch: pytest.MonkeyPatch) -> None:
    doc = document()
    low, high = np.array([-1.0, 0.0, 2.0]), np.array([3.0, 1.0, 4.0])
    monkeypatch.setattr(type(doc), "bounds", lambda self, rows=(): (low, high))
    before = state(doc)
    lights.scatter(doc, ScatterSettings(count=50, kind="disk", seed=3))
    scene = doc.runtime.scene
    assert scene.lights.alive_count == 51
    assert [e.describe() for e in doc.history.entries] == ["Scatter 50 lights"]
    (top,) = doc.selection
    assert len(doc.children_of(top)) == 50
    inside = scene.nodes.world[doc.children_of(top), :, 3]
    assert ((inside >= low - 1e-9) & (inside <= high + 1e-9)).all()
    after = state(doc)
    doc.history.undo()
    assert state(doc) == before
    doc.history.redo()
    assert state(doc) == after
    assert sum(n.light is not None for n in edited_scene(doc.runtime, doc.overrides).nodes) == 51


def grid(x: int, y: int, z: int, **values: object) -> ArraySettings:
    return ArraySettings(shape="grid", count_x=x, count_y=y, count_z=z, **values)


def test_an_array_repeats_what_is_below_and_steps_in_the_world() -> None:
    doc = document()
    before = state(doc)
    scene = doc.runtime.scene
    start = scene.nodes.world_matrix(3)[:3, 3].copy()
    lights.array(doc, (3,), grid(3, 1, 2, step=(0.5, 0.0, -2.0)))
    assert len(doc.selection) == 6
    places = np.array([scene.nodes.world_matrix(row)[:3, 3] for row in doc.selection]) - start
    wanted = [[0.5 * i, 0.0, -2.0 * k] for i in range(3) for k in range(2)]
    assert np.abs(places - wanted).max() < 1e-9, "its parent is turned and scaled"
    assert scene.lights.alive_count == 6
    doc.history.undo()
    assert state(doc) == before
    with pytest.raises(InputError, match="an array of"):
        lights.array(doc, (1,), grid(1000, 100, 1))
    lights.array(doc, (3,), grid(1, 1, 1))
    assert len(doc.history.entries) == 0, "one of one is nothing new"


def test_a_skewed_node_in_an_array_keeps_its_shear() -> None:
    doc = document()
    nodes = doc.runtime.scene.nodes
    linear = nodes.world_matrix(5)[:3, :3].copy()
    lights.array(doc, (5,), grid(2, 1, 1, step=(4.0, 0.0, 0.0)))
    new = doc.selection[1]
    assert np.array_equal(nodes.world_matrix(new)[:3, :3], linear)
    assert nodes.world_matrix(new)[0, 3] == pytest.approx(nodes.world_matrix(5)[0, 3] + 4.0)


@pytest.mark.parametrize("kind", LIGHT_TYPES)
@pytest.mark.parametrize("reach", [0.0, 3.0, 1e-6, 1e6])
def test_outlines_are_finite_and_as_large_as_the_light(kind: str, reach: float) -> None:
    doc = document()
    light = LightAsset(kind, range=reach, inner_angle=0.2, outer_angle=0.6, width=2.0, height=1.0, two_sided=True)
    structure.add_light(doc, np.diag([5.0, 5.0, 0.0, 1.0]), light)  # its node's scale changes nothing
    row = int(np.flatnonzero(doc.runtime.scene.lights.node == doc.primary)[0])
    ends = outline(doc, row, CAMERA)
    assert np.isfinite(ends).all()
    assert np.isfinite(pixels_of(ends, CAMERA, 640, 360)).all()
    far = np.linalg.norm(ends, axis=-1).max()
    if kind in ("point", "spot") and reach:
        assert far == pytest.approx(reach, rel=1e-6)
    if kind == "rectangle":
        assert np.abs(ends[:4, :, :2]).reshape(-1, 2).max(axis=0).tolist() == [1.0, 0.5]


def test_segments_behind_the_camera_end_at_its_near_plane() -> None:
    toward = CAMERA.rotation()[:, 2]
    through = np.array([[CAMERA.eye() - 4.0 * toward, CAMERA.eye() + 4.0 * toward]])
    behind = np.array([[CAMERA.eye() + toward, CAMERA.eye() + 4.0 * toward]])
    assert len(pixels_of(np.concatenate([through, behind]), CAMERA, 100, 100)) == 1
    assert len(pixels_of(np.zeros((0, 2, 3)), CAMERA, 100, 100)) == 0


def test_every_kind_has_its_fields_and_units() -> None:
    assert set(OF_KIND) == set(LIGHT_TYPES) == set(UNITS)
    assert {f for fields in OF_KIND.values() for f in fields} - {"profile"} <= set(FIELDS)
    assert {unit for units in UNITS.values() for unit in units} == set(UNIT_DOCS)
    assert FIELDS["outer_angle"].default == math.pi / 4


def test_profiles_from_elsewhere_are_carried_along(tmp_path: Path) -> None:
    (tmp_path / "far").mkdir()
    (tmp_path / "far" / "lamp.ies").write_text("x", encoding="utf-8")
    nodes = [
        NodeAsset("a", light=LightAsset("point", profile=str(tmp_path / "far" / "lamp.ies"))),
        NodeAsset("b", light=LightAsset("point", profile="own.ies")),
        NodeAsset("c", light=LightAsset("point")),
    ]
    asset = SceneAsset("s", nodes)
    assert _carry_profiles(asset, tmp_path) == [tmp_path / "lamp.ies"]
    assert [n.light.profile for n in asset.nodes if n.light] == ["lamp.ies", "own.ies", ""]


def test_a_ring_is_the_same_from_both_doors(tmp_path: Path) -> None:
    settings = ArraySettings(shape="ring", count=5, radius=2.0, arc=180.0, axis="z")
    doc = document()
    lights.array(doc, (3,), settings)
    places = [doc.runtime.scene.nodes.world_matrix(row) for row in doc.selection]
    asset = copy.deepcopy(document().runtime.asset)
    assert repeat_node(asset, 3, settings) == 4
    scene = Scene.from_asset(asset)
    others = [scene.nodes.world_matrix(int(scene.row_of_node[i])) for i in (3, *range(8, 12))]
    assert np.allclose(places, others, atol=1e-9)
    names = [doc.runtime.scene.nodes.name[row] for row in doc.selection]
    assert (
        names == [asset.nodes[i].name for i in (3, *range(8, 12))] == ["lamp", "lamp 2", "lamp 3", "lamp 4", "lamp 5"]
    )
    middle = (places[0][:3, 3] + places[4][:3, 3]) / 2.0
    assert np.allclose(np.linalg.norm(np.array(places)[:, :3, 3] - middle, axis=1), 2.0)


def test_a_box_of_ones_own(monkeypatch: pytest.MonkeyPatch) -> None:
    doc = document()
    monkeypatch.setattr(type(doc), "bounds", lambda self, rows=(): (np.zeros(3), np.ones(3)))
    lights.scatter(doc, ScatterSettings(count=9, box=True, box_low=(5, 5, 5), box_high=(4, 5, 6)))
    inside = doc.runtime.scene.nodes.world[doc.children_of(doc.selection[0]), :, 3]
    assert ((inside >= (4, 5, 5)) & (inside <= (5, 5, 6))).all()
