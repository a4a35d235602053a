"""A whole scene at one moment, on the CPU: where its nodes stand, and its meshes morphed and skinned in world space.

nodes (+ clip, time) ─> local TRS ─> world f8[n,4,4] ─┐
node.weights / weights channels ─> morphed positions ─┴─> linear or dual-quaternion skinning ─> PosedMesh
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from engine.animation import morph, skinning
from engine.animation.sample import sample_track
from engine.animation.tracks import pack
from engine.assets.clip import ClipAsset
from engine.assets.mesh import MeshAsset
from engine.assets.scene import NodeAsset
from engine.math.transform import compose, inverse_affine

F8 = NDArray[np.float64]

#: key of NodeAsset.extras: where a skinned mesh's node stood when it was bound (column-major f8[16], world space).
#: A node that has it carries its skinned mesh along, as Maya does; others leave skinned meshes to their joints alone.
BIND_WORLD = "skin_bind_world"


@dataclass(slots=True)
class ScenePose:
    """`world` f8[n,4,4], `visible` bool[n] (with the parents'), and the morph weights of nodes that have some."""

    world: F8
    visible: NDArray[np.bool_]
    weights: dict[int, F8] = field(default_factory=dict)


@dataclass(slots=True)
class PosedMesh:
    """A mesh on `node` in world space: `positions`, `normals` f8[n,3]; `triangles` of submesh s u4[t,3], counter-
    clockwise seen from outside, mirrored nodes included."""

    node: int
    mesh: MeshAsset
    positions: F8
    normals: F8
    triangles: list[NDArray[np.uint32]]


def pose_nodes(nodes: Sequence[NodeAsset], clip: ClipAsset | None = None, time: float = 0.0) -> ScenePose:
    """The nodes (parents first) at `time` seconds of `clip`, held at its ends; without a clip as they stand."""
    count = len(nodes)
    local = {
        "translation": np.array([n.translation for n in nodes], np.float64).reshape(count, 3),
        "rotation": np.array([n.rotation for n in nodes], np.float64).reshape(count, 4),
        "scale": np.array([n.scale for n in nodes], np.float64).reshape(count, 3),
    }
    weights = {i: np.asarray(node.weights, np.float64) for i, node in enumerate(nodes) if node.weights}
    moved = np.zeros(count, np.bool_)
    if clip is not None:
        for track in pack(clip, np.arange(count)):
            local[track.path][track.rows] = sample_track(track, time)
            moved[track.rows] = True
        for channel in clip.channels:
            if channel.path == "weights" and 0 <= channel.node < count:
                weights[channel.node] = morph.sample_weights(channel, time)
    world = compose(local["translation"], local["rotation"], local["scale"])
    visible = np.ones(count, np.bool_)
    for i, node in enumerate(nodes):
        if node.matrix is not None and not moved[i]:
            world[i] = np.reshape(node.matrix, (4, 4)).T
        visible[i] = node.visible
        if node.parent >= 0:
            world[i] = world[node.parent] @ world[i]
            visible[i] &= visible[node.parent]
    return ScenePose(world, visible, weights)


def pose_meshes(
    nodes: Sequence[NodeAsset], meshes: Sequence[MeshAsset], pose: ScenePose, *, hidden: bool = False
) -> Iterator[PosedMesh]:
    """The meshes on the visible nodes (all with `hidden`), in the order of the nodes."""
    for i, node in enumerate(nodes):
        if node.mesh is None or not 0 <= node.mesh.index < len(meshes) or not (hidden or pose.visible[i]):
            continue
        mesh = meshes[node.mesh.index]
        positions = np.asarray(mesh.streams["position"], np.float64)
        normals = mesh.streams["normal"][:, :3].astype(np.float64) / 32767.0
        if mesh.morphs:
            weights = pose.weights.get(i, np.zeros(len(mesh.morphs)))
            positions = morph.morphed(positions, mesh.morphs, weights)
            normals = morph.morphed(normals, mesh.morphs, weights, "normal")
        matrices = _skin(mesh, node, i, pose) if mesh.skeleton is not None and node.joints else pose.world[i]
        mirrored = matrices.ndim == 2 and np.linalg.det(matrices[:3, :3]) < 0.0
        triangles = [
            mesh.indices[s.first_index : s.first_index + s.index_count].reshape(-1, 3)[
                :, [0, 2, 1] if mirrored else [0, 1, 2]
            ]
            if s.topology == "triangles"
            else np.zeros((0, 3), np.uint32)
            for s in mesh.submeshes
        ]
        yield PosedMesh(
            i,
            mesh,
            skinning.transform_points(matrices, positions),
            skinning.transform_normals(matrices, normals),
            triangles,
        )


def _skin(mesh: MeshAsset, node: NodeAsset, index: int, pose: ScenePose) -> F8:
    """World from mesh per vertex, f8[n,4,4]."""
    assert mesh.skeleton is not None
    matrices = skinning.joint_matrices(pose.world[node.joints], mesh.skeleton.inverse_bind)
    bind = node.extras.get(BIND_WORLD)
    if isinstance(bind, list) and len(bind) == 16:
        own = np.reshape(np.asarray(bind, np.float64), (4, 4)).T
        matrices = pose.world[index] @ inverse_affine(own) @ matrices
    joints, weights = skinning.influences(mesh.streams)
    linear = skinning.vertex_matrices(joints, weights, matrices)
    if mesh.extras.get("skinning") != "dual_quaternion":
        return linear
    dual = skinning.vertex_matrices_dual_quaternion(joints, weights, matrices)
    share = mesh.extras.get("dual_quaternion_share")
    if not isinstance(share, list) or len(share) != len(linear):
        return dual
    blend = np.asarray(share, np.float64)[:, None, None]
    return linear + (dual - linear) * blend
