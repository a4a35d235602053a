"""What of a scene can cast: which bounds are sound, and when each instance changed last."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.scene.scene import Scene


def finite_bounds(scene: Scene) -> NDArray[np.bool_] | np.bool_:
    """Which instances have finite bounds; one True when all have, which a sum tells without looking at each."""
    table = scene.instances
    with np.errstate(over="ignore", invalid="ignore"):
        total = float(table.world_center.sum()) + float(table.world_radius.sum(dtype=np.float64))
    if np.isfinite(total):
        return np.True_
    finite: NDArray[np.bool_] = np.isfinite(table.world_center).all(axis=1) & np.isfinite(table.world_radius)
    return finite


def last_moved(scene: Scene, rows: NDArray[np.intp]) -> NDArray[np.uint32]:
    """u4[k]: the transform_rev at which what instances `rows` look like changed last: their nodes, or their joints."""
    nodes, skins = scene.nodes, scene.skins
    node = np.maximum(scene.instances.node[rows], 0)
    moved = nodes.world_rev[node].copy()
    if len(skins):
        skin = skins.of_nodes(node)
        of_skin = np.maximum.reduceat(nodes.world_rev[skins.joint], skins.first)
        posed = skin >= 0
        moved[posed] = of_skin[skin[posed]]
    return moved
