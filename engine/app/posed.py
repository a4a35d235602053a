"""World positions of an instance's vertices as they are posed now: for picking, framing, export. On the CPU."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.animation.morph import morphed
from engine.animation.skinning import influences, transform_points, vertex_matrices_dual_quaternion
from engine.resources.residency import Residency
from engine.scene.scene import Scene

#: so that influences stay one array: stream pairs in order
INFLUENCES = (("joints", "weights"), ("joints1", "weights1"))


def posed_positions(scene: Scene, residency: Residency, instance: int) -> NDArray[np.float64]:
    """f8[n,3], metres, world: all vertices of the instance's mesh, morphed and skinned as they are drawn."""
    table = scene.instances
    node = int(table.node[instance])
    mesh = residency.meshes[int(table.mesh[instance])].asset
    position = np.asarray(mesh.streams["position"], np.float64)
    shape = scene.morphs.of_node(node)
    if shape.any():
        position = morphed(position, mesh.morphs, shape)
    skin = int(scene.skins.of_nodes(np.array([node]))[0])
    if skin < 0 or "joints" not in mesh.streams:
        world = scene.nodes.world[node]
        return np.asarray(position @ world[:, :3].T + world[:, 3], np.float64)
    skins = scene.skins
    run = slice(int(skins.first[skin]), int(skins.first[skin] + skins.count[skin]))
    world = skins.joint_world()[run]
    palette = world[:, :, :3] @ skins.inverse_bind[run]
    palette[:, :, 3] += world[:, :, 3]
    if skins.blends_dual[skin]:
        whole = np.zeros((len(palette), 4, 4))
        whole[:, :3], whole[:, 3, 3] = palette, 1.0
        return transform_points(vertex_matrices_dual_quaternion(*influences(mesh.streams), whole), position)
    out = np.zeros_like(position)
    for joints, weights in INFLUENCES:
        if joints not in mesh.streams:
            continue
        index = np.asarray(mesh.streams[joints], np.int64)
        weight = np.asarray(mesh.streams[weights], np.float64) / 65535.0
        for k in range(4):
            m = palette[index[:, k]]
            out += weight[:, k, None] * (np.einsum("nij,nj->ni", m[:, :, :3], position) + m[:, :, 3])
    return out
