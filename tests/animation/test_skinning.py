"""Skinning, morphing and posing on the CPU, against what can be said without a computer."""

from __future__ import annotations

import numpy as np
import pytest

from engine.animation import morph, skinning
from engine.animation.pose import BIND_WORLD, pose_meshes, pose_nodes
from engine.assets.clip import Channel, ClipAsset
from engine.assets.mesh import MeshAsset, MorphTarget, Skeleton, Submesh
from engine.assets.scene import MeshRef, NodeAsset
from engine.math import quat
from engine.math.transform import compose

ONE = np.ones(3)


def turn(
    axis: tuple[float, float, float], degrees: float, translation: tuple[float, float, float] = (0, 0, 0)
) -> np.ndarray:
    return compose(np.array(translation, float), quat.from_axis_angle(axis, np.radians(degrees)), ONE)


def test_one_joint_is_a_plain_transform() -> None:
    world, bind = turn((0, 0, 1), 90, (5, 0, 0)), turn((0, 0, 1), 0, (1, 0, 0))
    matrices = skinning.joint_matrices(world[None], np.linalg.inv(bind)[None])
    for blend in (skinning.vertex_matrices, skinning.vertex_matrices_dual_quaternion):
        m = blend([[0, 0, 0, 0]], [[1.0, 0, 0, 0]], matrices)
        # the point one unit along the joint's x: after the turn one unit along y
        np.testing.assert_allclose(skinning.transform_points(m, [[2.0, 0, 0]]), [[5, 1, 0]], atol=1e-12)
        np.testing.assert_allclose(skinning.transform_normals(m, [[1.0, 0, 0]]), [[0, 1, 0]], atol=1e-12)


def test_linear_blending_collapses_a_twist_and_dual_quaternions_do_not() -> None:
    matrices = np.stack([turn((1, 0, 0), 0), turn((1, 0, 0), 180)])
    joints, weights = [[0, 1]], [[0.5, 0.5]]
    linear = skinning.transform_points(skinning.vertex_matrices(joints, weights, matrices), [[2.0, 1, 0]])
    np.testing.assert_allclose(linear, [[2, 0, 0]], atol=1e-12)  # the candy wrapper
    matrices[1] = turn((1, 0, 0), 90)
    m = skinning.vertex_matrices_dual_quaternion(joints, weights, matrices)
    half = np.sqrt(0.5)
    np.testing.assert_allclose(skinning.transform_points(m, [[2.0, 1, 0]]), [[2, half, half]], atol=1e-12)


def test_dual_quaternions_blend_translations_linearly_without_rotation() -> None:
    matrices = np.stack([turn((0, 0, 1), 0, (1, 0, 0)), turn((0, 0, 1), 0, (0, 3, 0))])
    m = skinning.vertex_matrices_dual_quaternion([[0, 1]], [[0.25, 0.75]], matrices)
    np.testing.assert_allclose(skinning.transform_points(m, [[0.0, 0, 0]]), [[0.25, 2.25, 0]], atol=1e-12)


def test_dual_quaternions_take_the_shorter_way_and_blend_scale() -> None:
    # 350 degrees and -10 degrees are one rotation by quaternions of opposite sign
    matrices = np.stack([turn((0, 0, 1), 350), turn((0, 0, 1), 10)])
    m = skinning.vertex_matrices_dual_quaternion([[0, 1]], [[0.5, 0.5]], matrices)
    np.testing.assert_allclose(m[0], np.eye(4), atol=1e-12)
    scaled = np.stack([np.eye(4), np.diag([3.0, 3, 3, 1])])
    m = skinning.vertex_matrices_dual_quaternion([[0, 1]], [[0.5, 0.5]], scaled)
    np.testing.assert_allclose(m[0], np.diag([2.0, 2, 2, 1]), atol=1e-12)


def test_normals_stay_outward_under_mirrors_and_uneven_scale() -> None:
    m = np.diag([-1.0, 1, 1, 1])
    np.testing.assert_allclose(skinning.transform_normals(m, [[1.0, 0, 0]]), [[-1, 0, 0]])
    n = skinning.transform_normals(np.diag([2.0, 1, 1, 1]), [[1.0, 1, 0]])
    np.testing.assert_allclose(n, [np.array([0.5, 1, 0]) / np.sqrt(1.25)])


def test_morphed_adds_weighted_offsets() -> None:
    targets = [
        MorphTarget("a", {"position": np.array([[1, 0, 0], [0, 0, 0]], "<f4")}),
        MorphTarget("b", {"position": np.array([[0, 2, 0], [0, 0, 4]], "<f4"), "normal": np.ones((2, 3), "<f4")}),
    ]
    base = np.zeros((2, 3))
    np.testing.assert_allclose(morph.morphed(base, targets, [0.5, -1.0]), [[0.5, -2, 0], [0, 0, -4]])
    np.testing.assert_allclose(morph.morphed(base, targets, [1.0, 0.25], "normal"), np.full((2, 3), 0.25))
    np.testing.assert_allclose(morph.morphed(base, targets, [1.0]), [[1, 0, 0], [0, 0, 0]])
    assert not base.any()


@pytest.mark.parametrize(("time", "weights"), [(-1.0, (0, 1)), (0.5, (0.5, 0.5)), (1.5, (0.75, 1)), (9.0, (0.5, 2))])
def test_weights_are_sampled(time: float, weights: tuple[float, float]) -> None:
    times, values = np.array([0, 1, 2], "<f4"), np.array([[0, 1], [1, 0], [0.5, 2]], "<f4")
    channel = Channel(0, "weights", "linear", times, values)
    np.testing.assert_allclose(morph.sample_weights(channel, time), weights)


def mesh(points: list[tuple[float, float, float]], **extra: np.ndarray) -> MeshAsset:
    position = np.array(points, "<f4")
    normal = np.tile(np.array([0, 0, 32767, 0], "<i2"), (len(points), 1))
    indices = np.arange(len(points), dtype="<u4")
    return MeshAsset("m", {"position": position, "normal": normal} | extra, indices, [Submesh(0, len(points))])


def test_a_posed_scene() -> None:
    corners = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)]
    nodes = [
        NodeAsset("root", translation=(0, 0, 2)),
        NodeAsset("mirror", 0, scale=(-1, 1, 1), mesh=MeshRef("", 0)),
        NodeAsset("hidden", 0, visible=False),
        NodeAsset("below", 2, mesh=MeshRef("", 0)),
    ]
    clip = ClipAsset(
        "c", [Channel(0, "translation", "linear", np.array([0, 1], "<f4"), np.array([[0, 0, 2], [4, 0, 2]], "<f4"))]
    )
    pose = pose_nodes(nodes, clip, 0.5)
    assert pose.visible.tolist() == [True, True, False, False]
    (part,) = pose_meshes(nodes, [mesh(corners)], pose)
    np.testing.assert_allclose(part.positions, [[2, 0, 2], [1, 0, 2], [2, 1, 2]])
    assert part.triangles[0].tolist() == [[0, 2, 1]]  # turned round, so that it still faces +Z
    np.testing.assert_allclose(part.normals, [[0, 0, 1]] * 3)
    assert len(list(pose_meshes(nodes, [mesh(corners)], pose, hidden=True))) == 2


def test_a_skinned_mesh_follows_its_joints_alone_unless_it_is_bound_to_its_node() -> None:
    streams = {
        "joints": np.zeros((3, 4), "<u2"),
        "weights": np.tile(np.array([65535, 0, 0, 0], "<u2"), (3, 1)),
    }
    skinned = mesh([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)], **streams)
    skinned.skeleton = Skeleton(["j"], np.array([-1], "<i4"), np.eye(4, dtype="<f4")[None])
    nodes = [NodeAsset("joint", translation=(0, 7, 0)), NodeAsset("skin", translation=(5, 0, 0), joints=[0])]
    nodes[1].mesh = MeshRef("", 0)
    (part,) = pose_meshes(nodes, [skinned], pose_nodes(nodes))
    np.testing.assert_allclose(part.positions[0], [0, 7, 0])
    nodes[1].extras[BIND_WORLD] = turn((0, 0, 1), 0, (3, 0, 0)).T.reshape(-1).tolist()
    (part,) = pose_meshes(nodes, [skinned], pose_nodes(nodes))
    np.testing.assert_allclose(part.positions[0], [2, 7, 0])  # moved by 5 - 3 with its node
