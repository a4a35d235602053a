"""Frustum culling of all instances at once."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:
    from engine.scene.scene import Scene


def visible_instances(scene: Scene, planes_ws: ArrayLike) -> NDArray[np.bool_]:
    """Return bool[n]: which instances are drawn and touch the frustum of `planes_ws` f8[6,4] (unit inward normals).

    Never drops a sphere that touches it; may keep one that misses it by less than 1e-6 of the scene's size. One
    float32 product of the planes with the spheres, relative to an origin in the scene's middle, so a scene at 1e6 m is
    culled like one at 0. Call after `scene.update()`.
    """
    table = scene.instances
    planes = np.asarray(planes_ws, np.float64)
    if len(table) == 0:
        return np.zeros(0, np.bool_)
    matrix = np.empty((len(planes), 5))
    matrix[:, :3] = planes[:, :3]
    matrix[:, 3] = 1.0
    distance = planes[:, :3] @ table.cull_origin + planes[:, 3]
    # five rounded products and sums, each off by at most 2^-24 of the largest term
    slack = 2.0**-20 * (table.cull_extent + np.abs(distance))
    matrix[:, 4] = distance + slack
    with np.errstate(over="ignore", invalid="ignore"):
        signed = matrix.astype(np.float32) @ table.cull_spheres
        visible: NDArray[np.bool_] = np.all(signed >= 0.0, axis=0)
    visible &= table.drawn
    return visible
