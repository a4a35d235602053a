"""Skinned meshes: the picture follows the joints, the bounds hold the pose, the CPU's twin agrees."""

from __future__ import annotations

import numpy as np
import pytest

from engine.animation.reach import joint_reach
from engine.app.posed import posed_positions
from engine.assets.mesh import Skeleton
from engine.assets.primitives import card, cube
from engine.scene.culling import visible_instances


def _hang(stage, mesh, joints: list[int]) -> int:
    """Put `mesh` on two joints, half and half where weights say so; returns its node."""
    node = stage.add(mesh)
    skeleton = mesh.skeleton
    reach = joint_reach(
        mesh.streams["position"], mesh.streams["joints"], mesh.streams["weights"], skeleton.inverse_bind
    )
    stage.runtime.scene.skins.add(node, joints, skeleton.inverse_bind, reach)
    stage.runtime.update()
    return node


def _skinned(mesh, weight_of_second: np.ndarray):
    count = mesh.vertex_count
    second = np.rint(weight_of_second * 65535).astype("<u2")
    weights = np.zeros((count, 4), "<u2")
    weights[:, 0], weights[:, 1] = 65535 - second, second
    joints = np.zeros((count, 4), "<u2")
    joints[:, 1] = 1
    mesh.streams |= {"joints": joints, "weights": weights}
    mesh.skeleton = Skeleton(["a", "b"], np.array([-1, 0], np.int32), np.tile(np.eye(4, dtype="<f4"), (2, 1, 1)))
    return mesh


@pytest.mark.gl
def test_a_mesh_on_one_moved_joint_is_the_mesh_moved(stage) -> None:
    nodes = stage.runtime.scene.nodes
    joints = [nodes.add("a", translation=(0.3, -0.2, 0.1)), nodes.add("b")]
    _hang(stage, _skinned(cube(), np.zeros(24)), joints)
    view = stage.view()
    skinned = stage.hdr(camera=view.camera)
    stage.look(kind="uniform", sun_illuminance=0.0)
    stage.add(cube(), None, (0.3, -0.2, 0.1))
    assert np.abs(skinned - stage.hdr(camera=view.camera)).max() < 1e-3


@pytest.mark.gl
def test_half_weights_stretch_half_way(stage) -> None:
    """A card whose right edge follows a joint 1 m to the right covers 1.5 m; its node's own place does not count."""
    stage.look(kind="none", sun_illuminance=0.0, background="color", background_color=(0, 0, 0))
    nodes = stage.runtime.scene.nodes
    joints = [nodes.add("a"), nodes.add("b", translation=(1.0, 0.0, 0.0))]
    mesh = card()
    right = (np.asarray(mesh.streams["position"])[:, 0] > 0) * 0.5
    node = _hang(stage, _skinned(mesh, right), joints)
    nodes.set_translation([node], [(5.0, 5.0, 5.0)])
    stage.runtime.update()
    row = int(np.flatnonzero(stage.runtime.scene.instances.node == node)[0])
    posed = posed_positions(stage.runtime.scene, stage.runtime.residency, row)
    assert posed[:, 0].min() == pytest.approx(-0.5, abs=1e-4)
    assert posed[:, 0].max() == pytest.approx(1.0, abs=1e-4)


def test_bounds_hold_the_pose(null_stage) -> None:
    nodes = null_stage.runtime.scene.nodes
    joints = [nodes.add("a"), nodes.add("b")]
    rng = np.random.default_rng(3)
    mesh = _skinned(cube(), rng.uniform(size=24))
    node = _hang(null_stage, mesh, joints)
    table = null_stage.runtime.scene.instances
    row = int(np.flatnonzero(table.node == node)[0])
    for _ in range(20):
        nodes.set_translation(joints, rng.normal(scale=3.0, size=(2, 3)))
        nodes.set_rotation(joints, (q := rng.normal(size=(2, 4))) / np.linalg.norm(q, axis=1, keepdims=True))
        null_stage.runtime.scene.update()
        posed = posed_positions(null_stage.runtime.scene, null_stage.runtime.residency, row)
        distance = np.linalg.norm(posed - table.world_center[row], axis=1)
        assert distance.max() <= table.world_radius[row] * (1 + 1e-6)
        # a frustum plane just beyond the sphere culls it, one through it does not
        for offset, expected in ((1.01, False), (0.9, True)):
            normal = np.array([1.0, 0.0, 0.0])
            d = -(table.world_center[row, 0] + offset * table.world_radius[row])
            planes = np.tile(np.array([*normal, d]), (6, 1))
            assert visible_instances(null_stage.runtime.scene, planes)[row] == expected


@pytest.mark.gl
def test_a_skinned_mesh_far_from_the_origin_looks_the_same(stage) -> None:
    pictures = []
    for offset in (0.0, 1e6):
        stage.look(kind="uniform", sun_illuminance=2.0)
        nodes = stage.runtime.scene.nodes
        joints = [nodes.add("a", translation=(offset, 0, 0)), nodes.add("b", translation=(offset + 0.5, 0.2, 0))]
        _hang(stage, _skinned(cube(), np.linspace(0, 1, 24)), joints)
        view = stage.view()
        view.camera.world_from_camera[:3, 3] = (offset, 0.0, 4.0)
        pictures.append(stage.hdr(camera=view.camera))
    assert (np.abs(pictures[0] - pictures[1]).max(axis=-1) > 1e-3).mean() < 1e-3


def test_removing_a_joint_removes_the_skin(null_stage) -> None:
    nodes = null_stage.runtime.scene.nodes
    joints = [nodes.add("a"), nodes.add("b")]
    _hang(null_stage, _skinned(cube(), np.zeros(24)), joints)
    null_stage.runtime.scene.remove([joints[1]])
    null_stage.runtime.scene.update()
    assert len(null_stage.runtime.scene.skins) == 0
    null_stage.runtime.render(null_stage.view())


def test_a_skin_that_follows_its_node_moves_with_it(null_stage) -> None:
    """Bound where its node stood at x = 1; the node went to x = 3, so every vertex goes along by 2."""
    scene = null_stage.runtime.scene
    joints = [scene.nodes.add("a"), scene.nodes.add("b")]
    mesh = _skinned(cube(), np.zeros(24))
    node = null_stage.add(mesh)
    bind_world = np.eye(4)
    bind_world[0, 3] = 1.0
    scene.skins.add(node, joints, mesh.skeleton.inverse_bind, [1.0, 1.0], bind_world)
    scene.nodes.set_translation([node], [(3.0, 0.0, 0.0)])
    scene.update()
    row = int(np.flatnonzero(scene.instances.node == node)[0])
    posed = posed_positions(scene, null_stage.runtime.residency, row)
    assert posed[:, 0].min() == pytest.approx(1.5, abs=1e-4)
    assert scene.skins.palette(np.zeros(3))[0, 0, 3] == pytest.approx(2.0)
