"""The box of a skinned or morphed instance as it is posed now, from its joints alone: cheap enough for every frame."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from engine.app.posed import INFLUENCES
from engine.assets.mesh import MeshAsset
from engine.scene.scene import Scene

F8 = NDArray[np.float64]


def joint_boxes(mesh: MeshAsset) -> F8:
    """f8[joints,2,3]: (low, high), in mesh space, of the vertices that follow each joint at all; low > high for none.
    All vertices as one joint's where the mesh has no joints."""
    position = np.asarray(mesh.streams["position"], np.float64)
    if "joints" not in mesh.streams or mesh.skeleton is None:
        return np.stack([position.min(axis=0), position.max(axis=0)])[None]
    boxes = np.empty((len(mesh.skeleton.names), 2, 3))
    boxes[:, 0], boxes[:, 1] = np.inf, -np.inf
    for joints, weights in INFLUENCES:
        if joints not in mesh.streams:
            continue
        index, weight = np.asarray(mesh.streams[joints], np.int64), np.asarray(mesh.streams[weights])
        for k in range(index.shape[1]):
            used = weight[:, k] > 0
            np.minimum.at(boxes[:, 0], index[used, k], position[used])
            np.maximum.at(boxes[:, 1], index[used, k], position[used])
    return boxes


def posed_box(scene: Scene, mesh: MeshAsset, boxes: F8, instance: int) -> tuple[F8, F8] | None:
    """(low, high), world, of the instance; None where neither skin nor morph targets bend it.

    `boxes`: `joint_boxes(mesh)`. What linear blending makes of a vertex lies between the places its joints give it, so
    the box of all joints' boxes holds it; dual quaternions may bulge over it by a little.
    """
    node = int(scene.instances.node[instance])
    skin = int(scene.skins.of_nodes(np.array([node]))[0])
    shape = np.asarray(scene.morphs.of_node(node), np.float64)
    if skin < 0 and not shape.any():
        return None
    moves = [
        weight * np.asarray(target.streams["position"], np.float64)
        for target, weight in zip(mesh.morphs, shape.tolist(), strict=False)
        if weight and "position" in target.streams
    ]
    if skin < 0 or "joints" not in mesh.streams:
        position = np.asarray(mesh.streams["position"], np.float64) + sum(moves)
        grown, palette = np.stack([position.min(axis=0), position.max(axis=0)])[None], scene.nodes.world[node][None]
    else:
        grown = boxes.copy()
        for moved in moves:
            grown[:, 0] += np.minimum(moved.min(axis=0), 0.0)
            grown[:, 1] += np.maximum(moved.max(axis=0), 0.0)
        run = slice(int(scene.skins.first[skin]), int(scene.skins.first[skin] + scene.skins.count[skin]))
        world = scene.skins.joint_world()[run]
        palette = world[:, :, :3] @ scene.skins.inverse_bind[run]
        palette[:, :, 3] += world[:, :, 3]
    count = min(len(grown), len(palette))
    used = np.flatnonzero((grown[:count, 0] <= grown[:count, 1]).all(axis=1))
    choice = np.array(list(itertools.product((0, 1), repeat=3)))
    corners = grown[used][:, choice, np.arange(3)]  # [joints,8,3]
    points = np.einsum("jik,jck->jci", palette[used][:, :, :3], corners) + palette[used][:, None, :, 3]
    if not len(used):
        return None
    return points.min(axis=(0, 1)), points.max(axis=(0, 1))
