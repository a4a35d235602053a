"""ShadowFloor: a level floor under the scene that nothing but shadows is seen of: how high it lies, what it shows.

The shadow of a box on it lies, in light space, below the box: the same square, as deep as the plane is there.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.render.settings import LIT_LOOK, RenderSettings
from engine.render.shadows.fit import Boxes
from engine.resources.residency import Residency
from engine.scene.scene import Scene

F8 = NDArray[np.float64]

#: sine of the sun's elevation below which shadows have no end on a floor
LEAST_ELEVATION = 0.02


def floor_wanted(settings: RenderSettings) -> bool:
    return settings.shadow_floor > 0.0 and settings.shading_view in LIT_LOOK


class ShadowFloor:
    """Keeps the height while nothing moves."""

    def __init__(self, residency: Residency) -> None:
        self._residency = residency
        self._found: tuple[tuple[object, ...], float] = ((), 0.0)

    def height(self, scene: Scene) -> float:
        """World y of the lowest point that is drawn, 0 where nothing is. What is skinned stands on its lowest joint, or
        on the floor of its bounds where those are higher; what morphs, on its unmorphed mesh."""
        table = scene.instances
        key = (id(scene), scene.transform_rev, scene.structure_rev, table.bounds_rev, table.drawn_rev)
        if key != self._found[0]:
            self._found = (key, _lowest(scene, self._residency))
        return self._found[1]


def _lowest(scene: Scene, residency: Residency) -> float:
    table, nodes = scene.instances, scene.nodes
    rows = np.flatnonzero(table.drawn)
    if len(rows) == 0:
        return 0.0
    shapes, of_row = np.unique(np.stack([table.mesh[rows], table.submesh[rows]], 1), axis=0, return_inverse=True)
    assets = [(residency.meshes[mesh].asset, submesh) for mesh, submesh in shapes.tolist()]
    of_row = of_row.reshape(-1)
    box = np.array([(a.submeshes[s].bounds_min, a.submeshes[s].bounds_max) for a, s in assets], np.float64)[of_row]
    up = nodes.world[table.node[rows]][:, 1]  # y of what is there, by local x, y, z, 1
    low = np.minimum(box[:, 0] * up[:, :3], box[:, 1] * up[:, :3]).sum(axis=1) + up[:, 3]
    skin = scene.skins.of_nodes(table.node[rows])
    for i in np.flatnonzero(skin >= 0).tolist():
        first = int(scene.skins.first[skin[i]])
        later = scene.skins.first[scene.skins.first > first]
        joints = scene.skins.joint[first : int(later.min()) if len(later) else None]
        sphere = float(table.world_center[rows[i], 1]) - float(table.world_radius[rows[i]])
        low[i] = max(sphere, float(nodes.world[joints, 1, 3].min()))
    best = float("inf")
    for i in np.argsort(low).tolist():  # boxes of what is turned reach lower than what is in them
        if not low[i] < best:
            break
        if skin[i] >= 0:
            best = float(low[i])
            continue
        asset, number = assets[of_row[i]]
        part = asset.submeshes[number]
        used = asset.indices[part.first_index : part.first_index + part.index_count]
        points = np.asarray(asset.streams["position"], np.float64)[used]
        if len(points):
            best = min(best, float((points @ up[i, :3]).min()) + float(up[i, 3]))
    return best if np.isfinite(best) else 0.0


def with_floor(receivers: Boxes, casters: Boxes, height: float, axes: F8, eye: F8, forward: F8) -> Boxes:
    """`receivers`, and the part of the floor that `casters` may darken (fit.py has what boxes are)."""
    climb = float(axes[2, 1])
    if len(casters) == 0 or climb < LEAST_ELEVATION:
        return receivers
    low, high = casters.low.min(axis=1), casters.high.max(axis=1)
    x, y = np.array([(a, b) for a in (low[0], high[0]) for b in (low[1], high[1])]).T
    z = (height - x * axes[0, 1] - y * axes[1, 1]) / climb  # where the light through (x, y) meets the floor
    corners = np.stack([x, y, z])
    depth = (axes.T @ corners).T @ forward - float(eye @ forward)
    return Boxes(
        np.concatenate([receivers.low, corners.min(axis=1)[:, None]], axis=1),
        np.concatenate([receivers.high, corners.max(axis=1)[:, None]], axis=1),
        np.append(receivers.near, depth.min()), np.append(receivers.far, depth.max()),
    )  # fmt: skip
