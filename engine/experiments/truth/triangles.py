"""A runtime scene as triangles: posed, in the world, with what shading needs at their corners."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from engine.animation.skinning import influences, vertex_matrices
from engine.assets.mesh import MeshAsset
from engine.core.errors import InputError
from engine.math.transform import cofactor
from engine.resources.residency import Residency
from engine.scene.scene import Scene

F8 = NDArray[np.float64]

#: more take gigabytes here
MOST = 6_000_000


@dataclass(slots=True)
class Triangles:
    """Per triangle: corners and unit normals f8[n,3,3] (world), uv f4[n,3,2] of both sets, tangents f4[n,3,4] (world,
    w = handedness; 0 where there are none), colours f4[n,3,4], the material id; `face`: unit, outward, f8[n,3]."""

    corners: F8
    normals: F8
    uv0: NDArray[np.float32]
    uv1: NDArray[np.float32]
    tangents: NDArray[np.float32]
    colors: NDArray[np.float32]
    material: NDArray[np.int32]
    face: F8

    def __len__(self) -> int:
        return len(self.material)


def triangles_of(scene: Scene, residency: Residency) -> Triangles:
    """Everything drawn, as of the last update. Lines and points have no area and are left out. Raises InputError for
    more than MOST triangles."""
    table = scene.instances
    parts: list[Triangles] = []
    total = 0
    for row in np.flatnonzero(table.drawn).tolist():
        mesh = residency.meshes[int(table.mesh[row])].asset
        part = mesh.submeshes[int(table.submesh[row])]
        if part.topology != "triangles" or part.index_count < 3:
            continue
        total += part.index_count // 3
        if total > MOST:
            raise InputError(f"more than {MOST:,} triangles are too many to trace", hint="hide some of the scene")
        index = np.asarray(mesh.indices[part.first_index : part.first_index + part.index_count], np.int64)
        used, local = np.unique(index, return_inverse=True)
        matrices = _matrices(scene, int(table.node[row]), mesh, used)
        parts.append(mesh_triangles(mesh, used, local.reshape(-1, 3), matrices, int(table.material[row])))
    if not parts:
        return _empty()
    joined = Triangles(*(np.concatenate([getattr(p, f.name) for p in parts]) for f in fields(Triangles)))
    sound = np.isfinite(joined.corners).all(axis=(1, 2)) & (np.abs(joined.corners).max(axis=(1, 2)) < 1e15)
    return joined if sound.all() else Triangles(*(getattr(joined, f.name)[sound] for f in fields(Triangles)))


def _matrices(scene: Scene, node: int, mesh: MeshAsset, used: NDArray[np.int64]) -> F8:
    """World from mesh space f8[k,3,4], k = 1 for rigid meshes, else one for each of the vertices `used`."""
    skin = int(scene.skins.of_nodes(np.array([node]))[0])
    if skin < 0 or "joints" not in mesh.streams:
        return np.asarray(scene.nodes.world[node][None], np.float64)
    run = slice(int(scene.skins.first[skin]), int(scene.skins.first[skin] + scene.skins.count[skin]))
    world = scene.skins.joint_world()[run]
    palette = np.zeros((len(world), 4, 4))
    palette[:, :3] = world[:, :, :3] @ scene.skins.inverse_bind[run]
    palette[:, :3, 3] += world[:, :, 3]
    palette[:, 3, 3] = 1.0
    joints, weights = influences(mesh.streams)
    return vertex_matrices(joints[used], weights[used], palette)[:, :3]


def mesh_triangles(
    mesh: MeshAsset, used: NDArray[np.int64], index: NDArray[np.int64], m: F8, material: int
) -> Triangles:
    """Triangles `index` [n,3], into the vertices `used`, moved by `m` f8[1|len(used),3,4]."""
    streams = mesh.streams
    position = np.asarray(streams["position"], np.float64)[used]
    linear = m[:, :, :3]
    corners = (np.einsum("nij,nj->ni", np.broadcast_to(linear, (len(used), 3, 3)), position) + m[:, :, 3])[index]
    flip = np.where(np.linalg.det(linear) < 0.0, -1.0, 1.0)
    turn = cofactor(linear) * flip[:, None, None]
    normal = _unit(_apply(turn, np.asarray(streams["normal"], np.float64)[used, :3]))
    face = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    face = _unit(face * np.broadcast_to(flip, len(used))[index[:, 0], None])
    tangent = np.zeros((len(used), 4))
    if "tangent" in streams:
        raw = np.asarray(streams["tangent"], np.float64)[used] / 32767.0
        tangent[:, :3], tangent[:, 3] = _unit(_apply(linear, raw[:, :3])), np.sign(raw[:, 3]) * flip
    uv0 = np.asarray(streams["uv0"], np.float32)[used] if "uv0" in streams else np.zeros((len(used), 2), np.float32)
    uv1 = np.asarray(streams["uv1"], np.float32)[used] if "uv1" in streams else uv0
    color = np.ones((len(used), 4), np.float32)
    if "color" in streams:
        color = np.asarray(streams["color"], np.float32)[used] / np.float32(65535.0)
    return Triangles(
        corners, normal[index], uv0[index], uv1[index], tangent.astype(np.float32)[index], color[index],
        np.full(len(index), material, np.int32), face,
    )  # fmt: skip


def _apply(m: F8, v: F8) -> F8:
    result: F8 = np.einsum("nij,nj->ni", np.broadcast_to(m, (len(v), 3, 3)), v)
    return result


def _unit(v: F8) -> F8:
    result: F8 = v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-30)
    return result


def _empty() -> Triangles:
    f4 = np.float32
    return Triangles(
        np.zeros((0, 3, 3)), np.zeros((0, 3, 3)), np.zeros((0, 3, 2), f4), np.zeros((0, 3, 2), f4),
        np.zeros((0, 3, 4), f4), np.zeros((0, 3, 4), f4), np.zeros(0, np.int32), np.zeros((0, 3)),
    )  # fmt: skip
