"""The gizmo's arithmetic against known answers."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from edited_stage import document

from editor import gizmo
from editor.camera_controls import OrbitCamera, project
from engine.math import quat, transform


def held(*rows: int, local: bool = False) -> tuple[Any, gizmo.Grip]:
    doc = document()
    doc.selection = rows
    grip = gizmo.begin(doc, local=local)
    assert grip is not None
    return doc, grip


def shift(x: float, y: float, z: float) -> Any:
    return transform.compose((x, y, z), (0.0, 0.0, 0.0, 1.0), (1.0, 1.0, 1.0))


def apply(doc: Any, grip: gizmo.Grip, values: list[Any]) -> None:
    doc.edit("nodes", "local", grip.rows, values)


def test_moving_in_the_world_below_a_turned_and_scaled_parent() -> None:
    doc, grip = held(2)
    nodes = doc.runtime.scene.nodes
    before, rotation, scale = nodes.world_matrix(2), nodes.rotation[2].copy(), nodes.scale[2].copy()
    apply(doc, grip, gizmo.moved(grip, shift(0.0, 1.0, 0.0), "move"))
    after = nodes.world_matrix(2)
    assert after[:3, 3] - before[:3, 3] == pytest.approx([0.0, 1.0, 0.0], abs=1e-12)
    assert nodes.rotation[2].tobytes() == rotation.tobytes(), "moving touches nothing else"
    assert nodes.scale[2].tobytes() == scale.tobytes()


def test_a_parent_and_its_child_move_once() -> None:
    doc, grip = held(2, 1)
    assert grip.rows == (1,)
    nodes = doc.runtime.scene.nodes
    before = nodes.world_matrix(2)[:3, 3].copy()
    apply(doc, grip, gizmo.moved(grip, shift(2.0, 0.0, 0.0), "move"))
    assert nodes.world_matrix(2)[:3, 3] - before == pytest.approx([2.0, 0.0, 0.0])


def test_many_turn_round_their_middle() -> None:
    doc, grip = held(4, 0)
    nodes = doc.runtime.scene.nodes
    doc.edit("nodes", "translation", (4,), ((2.0, 0.0, 0.0),))
    grip = gizmo.begin(doc, local=False)
    assert grip is not None
    assert grip.pivot[:3, 3].tolist() == [1.0, 0.0, 0.0]
    half = transform.compose((0, 0, 0), quat.from_axis_angle((0.0, 1.0, 0.0), math.pi), (1, 1, 1))
    delta = shift(1, 0, 0) @ half @ shift(-1, 0, 0)
    apply(doc, grip, gizmo.moved(grip, delta, "rotate"))
    assert nodes.translation[4] == pytest.approx([0.0, 0.0, 0.0], abs=1e-12)
    assert nodes.translation[0] == pytest.approx([2.0, 0.0, 0.0], abs=1e-12)
    assert nodes.scale[4].tolist() == [1.0, 1.0, 1.0]
    assert np.abs(nodes.rotation[4]) == pytest.approx([0.0, 1.0, 0.0, 0.0], abs=1e-12)


def test_turning_a_single_node_leaves_its_place_bit_for_bit() -> None:
    doc, grip = held(1, local=True)
    nodes = doc.runtime.scene.nodes
    place = nodes.translation[1].copy()
    at = grip.pivot[:3, 3]
    turn = np.eye(4)
    turn[:3, :3] = quat.to_matrix3(quat.from_axis_angle((0.0, 0.0, 1.0), 0.3))
    turn[:3, 3] = at - turn[:3, :3] @ at
    apply(doc, grip, gizmo.moved(grip, turn, "rotate"))
    assert nodes.translation[1] == pytest.approx(place, abs=1e-12)


def test_scaling_alone_multiplies_exactly() -> None:
    doc, grip = held(1, local=True)
    apply(doc, grip, gizmo.scaled_alone(grip, (2.0, 1.0, 0.5)))
    nodes = doc.runtime.scene.nodes
    assert nodes.scale[1].tolist() == [2.0, 2.0, 0.25]
    assert nodes.translation[1].tolist() == [1.0, 2.0, 3.0]
    values = gizmo.scaled_alone(grip, (0.0, 1.0, 1.0))
    assert values[0][2][0] == pytest.approx(1e-6), "a scale of nothing could not be undone by hand"


def test_scaling_together_keeps_the_middle() -> None:
    doc, grip = held(0, 4)
    doc.edit("nodes", "translation", (4,), ((2.0, 0.0, 0.0),))
    grip = gizmo.begin(doc, local=False)
    assert grip is not None
    apply(doc, grip, gizmo.moved(grip, gizmo.scaling(grip, (3.0, 3.0, 3.0)), "scale"))
    nodes = doc.runtime.scene.nodes
    assert nodes.translation[0] == pytest.approx([-2.0, 0.0, 0.0])
    assert nodes.translation[4] == pytest.approx([4.0, 0.0, 0.0])
    assert nodes.scale[4] == pytest.approx([3.0, 3.0, 3.0])


def test_a_sheared_node_keeps_its_shear() -> None:
    doc, grip = held(5)
    nodes = doc.runtime.scene.nodes
    linear = nodes.local_matrix(5)[:3, :3]
    apply(doc, grip, gizmo.moved(grip, shift(0.0, 0.0, 1.0), "move"))
    assert nodes.local_matrix(5)[:3, :3].tolist() == linear.tolist()
    assert nodes.local_matrix(5)[:3, 3] == pytest.approx([0.1, 0.2, 1.3])


def test_locked_nodes_are_not_held() -> None:
    doc = document()
    doc.selection = (2, 4)
    doc.locked = {2}
    grip = gizmo.begin(doc, local=False)
    assert grip is not None
    assert grip.rows == (4,)
    doc.locked.add(4)
    assert gizmo.begin(doc, local=False) is None


@pytest.mark.parametrize("orthographic", [False, True])
def test_the_widget_s_camera_is_the_viewport_s(orthographic: bool) -> None:
    camera = OrbitCamera((1e6, 2.0, -3.0), yaw=0.4, pitch=-0.3, distance=7.0, orthographic=orthographic)
    points = np.array([[1e6, 2.0, -3.0], [1e6 + 1.0, 2.5, -2.0]])
    view, clip = gizmo.camera_matrices(camera, 1.5)
    eye = np.concatenate([points - camera.eye(), np.ones((2, 1))], axis=1)
    ndc = eye @ (clip @ view).T
    ndc = ndc[:, :3] / ndc[:, 3:]
    pixels, _depth = project(camera, points, 300.0, 200.0)
    assert (ndc[:, 0] + 1.0) * 150.0 == pytest.approx(pixels[:, 0], abs=1e-4)
    assert (1.0 - ndc[:, 1]) * 100.0 == pytest.approx(pixels[:, 1], abs=1e-4)
    assert (np.abs(ndc[:, 2]) < 1.0).all()


def test_the_snap_step_follows_what_is_seen() -> None:
    assert gizmo.snap_step(OrbitCamera(distance=5.0)) == pytest.approx(0.1)
    assert gizmo.snap_step(OrbitCamera(distance=200.0)) == pytest.approx(10.0)
