"""Frustum culling of all instances at once."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.scene.instances import CULL_SLACK

if TYPE_CHECKING:
    from engine.scene.scene import Scene


#: Spheres per product: small enough to stay in cache and on this thread (BLAS threads cost more than they give here).
BLOCK = 8192


def visible_instances(scene: Scene, planes_ws: ArrayLike) -> NDArray[np.bool_]:
    """Return bool[n]: which instances are drawn and touch the frustum of `planes_ws` f8[6,4] (unit inward normals).

    Never drops a sphere that touches it; may keep one that misses it by less than 1e-6 of its distance from the
    scene's middle. Float32 products of the planes with the spheres, relative to an origin in that middle, so a scene
    at 1e6 m is culled like one at 0. Call after `scene.update()`.
    """
    table = scene.instances
    planes = np.asarray(planes_ws, np.float64)
    count = len(table)
    distance = planes[:, :3] @ table.cull_origin + planes[:, 3]
    matrix = np.empty((len(planes), 5), np.float32)
    matrix[:, :3] = planes[:, :3]
    matrix[:, 3] = 1.0
    spheres, drawn = table.cull_spheres, table.drawn
    visible = np.empty(count, np.bool_)
    signed = np.empty((len(planes), min(BLOCK, count)), np.float32)
    with np.errstate(over="ignore", invalid="ignore"):
        matrix[:, 4] = distance + CULL_SLACK * np.abs(distance)
        for start in range(0, count, BLOCK):
            stop = min(start + BLOCK, count)
            block = np.matmul(matrix, spheres[:, start:stop], out=signed[:, : stop - start])
            np.all(block >= 0.0, axis=0, out=visible[start:stop])
    visible &= drawn
    return visible
