"""Skins at their limits: very many joints, flat and absurd ones, weights that sum to nothing."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.animation.morph import target_reach
from engine.animation.reach import joint_reach
from engine.assets.mesh import MeshAsset, MorphTarget, Skeleton
from engine.assets.primitives import cube, uv_sphere
from engine.math import quat
from tests.stability.rows import covers
from tests.support.stage import Stage, front_camera, surface

pytestmark = pytest.mark.gl

SIZE = (40, 24)
CAMERA = front_camera(1.0, SIZE[0] / SIZE[1])


def skinned(mesh: MeshAsset, joint: int, count: int, weight: int = 65535) -> MeshAsset:
    """The mesh hung with `weight` on one of `count` joints, bound where it lies."""
    joints = np.zeros((mesh.vertex_count, 4), "<u2")
    weights = np.zeros((mesh.vertex_count, 4), "<u2")
    joints[:, 0], weights[:, 0] = joint, weight
    mesh.streams |= {"joints": joints, "weights": weights}
    names = [f"j{i}" for i in range(count)]
    parents = np.arange(-1, count - 1, dtype=np.int32)
    mesh.skeleton = Skeleton(names, parents, np.tile(np.eye(4, dtype="<f4"), (count, 1, 1)))
    return mesh


def hang(stage: Stage, mesh: MeshAsset, joints: list[int]) -> int:
    node = stage.add(mesh, surface(base_color=(0.7, 0.5, 0.3, 1), roughness=0.5))
    assert mesh.skeleton is not None
    streams, bind = mesh.streams, mesh.skeleton.inverse_bind
    reach = joint_reach(streams["position"], streams["joints"], streams["weights"], bind)
    stage.runtime.scene.skins.add(node, joints, bind, reach)
    stage.runtime.update()
    return node


def lit(stage: Stage) -> None:
    stage.look(kind="uniform", color=(0.5, 0.5, 0.5), sun_illuminance=2.0, background="color")


def picture(stage: Stage) -> NDArray[np.float32]:
    got = stage.hdr(SIZE, CAMERA)
    assert np.isfinite(got).all()
    assert got.min() >= 0.0
    assert got.max() <= 32000.0
    return got


@covers("size.many-bones")
def test_the_last_of_8192_joints_moves_its_mesh(stage: Stage) -> None:
    count = 8192
    lit(stage)
    nodes = stage.runtime.scene.nodes
    places = np.zeros((count, 3))
    places[-1] = (0.4, 0.2, 0.0)
    rows = nodes.add_many([f"j{i}" for i in range(count)], None, places)
    hang(stage, skinned(cube(), count - 1, count), rows.tolist())
    got = picture(stage)
    lit(stage)
    stage.add(cube(), surface(base_color=(0.7, 0.5, 0.3, 1), roughness=0.5), (0.4, 0.2, 0.0))
    assert np.abs(got - picture(stage)).max() < 2e-3


@covers("pose.bad-bone", "pose.singular-scale")
def test_absurd_and_flat_joints_spoil_only_what_hangs_on_them(stage: Stage) -> None:
    """Joints at 1e300 m, of scale 0 or 1e200: what does not hang on them is bit-equal, everything is finite."""
    lit(stage)
    stage.add(uv_sphere(), surface(base_color=(0.6, 0.5, 0.4, 1)), (0.9, 0.0, 0.0))
    expected = picture(stage)[:, SIZE[0] // 2 :]
    nodes = stage.runtime.scene.nodes
    joint = nodes.add("joint", -1, (-0.9, 0.0, 0.0))
    hang(stage, skinned(cube(0.5), 0, 1), [joint])
    assert (picture(stage)[:, SIZE[0] // 2 :] == expected).all()
    for place, scale in itertools.product([(-0.9, 0, 0), (-3e38, 0, 0), (-1e300, 0, 0)], [0.0, 1e-30, 1.0, 1e200]):
        nodes.set_trs([joint], [place], [(0, 0, 0, 1)], [(scale, scale, scale)])
        got = picture(stage)
        if scale < 1e100:
            assert (got[:, SIZE[0] // 2 :] == expected).all(), f"joint at {place}, scale {scale}"


@covers("pose.morphs")
def test_absurd_morph_weights_spoil_only_their_mesh(stage: Stage) -> None:
    """What is not finite counts as 0; what is merely huge may fill the picture with its own mesh, finite."""
    lit(stage)
    stage.add(uv_sphere(), surface(base_color=(0.6, 0.5, 0.4, 1)), (0.9, 0.0, 0.0))
    mesh = cube(0.5)
    away = np.broadcast_to(np.float32([-0.2, 0.0, 0.0]), (mesh.vertex_count, 3)).copy()
    mesh.morphs.append(MorphTarget("away", {"position": away}))
    node = stage.add(mesh, surface(base_color=(0.7, 0.5, 0.3, 1), roughness=0.5), (-0.9, 0.0, 0.0))
    stage.runtime.scene.morphs.add(node, ["away"], target_reach(mesh.morphs))
    stage.runtime.update()
    rest = picture(stage)
    for weight in (np.nan, np.inf, -np.inf, 0.0):
        stage.runtime.scene.morphs.set_node(node, [weight])
        stage.runtime.update()
        assert (picture(stage) == rest).all(), f"weight {weight}"
    for weight in (1.0, 1e4, 1e30, 1e300):
        stage.runtime.scene.morphs.set_node(node, [weight])
        stage.runtime.update()
        got = picture(stage)
        assert (got[:, SIZE[0] // 2 :] == rest[:, SIZE[0] // 2 :]).all(), f"weight {weight}"
        assert (got != rest).any(), f"weight {weight}"


@covers("pose.skin-weights", "pose.singular-scale")
@pytest.mark.parametrize("weight", [0, 1, 32768])
@pytest.mark.parametrize("bind", [0.0, 1e-20, 1.0])
def test_weights_and_bind_poses_that_should_not_be(stage: Stage, weight: int, bind: float) -> None:
    """Import mends weights; a file of ours that says otherwise still gives a finite picture, and a finite bound."""
    lit(stage)
    mesh = skinned(uv_sphere(), 0, 1, weight)
    assert mesh.skeleton is not None
    mesh.skeleton.inverse_bind[0, :3, :3] *= bind
    node = hang(stage, mesh, [stage.runtime.scene.nodes.add("joint")])
    picture(stage)
    table = stage.runtime.scene.instances
    row = int(np.flatnonzero(table.node == node)[0])
    assert np.isfinite(table.world_radius[row])


@covers("pose.antipodal")
def test_joints_on_either_side_of_a_half_turn_meet_in_the_middle(stage: Stage) -> None:
    """Turned by 170 and 190 degrees, whose quaternions have opposite signs, and blended as dual quaternions: 180."""
    stage.look(kind="uniform", background="color", background_color=(0.0, 0.0, 0.0))
    mesh = skinned(cube(0.5), 0, 2, 32768)
    mesh.streams["joints"][:, 1], mesh.streams["weights"][:, 1] = 1, 32767
    mesh.streams["position"] = (mesh.streams["position"] + np.float32([0.0, 0.5, 0.0])).astype("<f4")
    nodes = stage.runtime.scene.nodes
    joints = [nodes.add("a"), nodes.add("b")]
    nodes.set_rotation(joints, quat.from_axis_angle(np.array([1.0, 0.0, 0.0]), np.radians([170.0, 190.0])))
    hang(stage, mesh, joints)
    stage.runtime.scene.skins.set_method(0, "dual_quaternion")
    covered = stage.hdr(SIZE, CAMERA)[..., :3].sum(axis=2) > 0.0
    # upside down: below the middle of the picture, nothing above
    assert covered[SIZE[1] // 2 + 1 :].sum() >= 16
    assert not covered[: SIZE[1] // 2 - 1].any()
