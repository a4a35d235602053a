"""View frusta as six inward planes, and sphere tests against them."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

F8 = NDArray[np.float64]

PLANES = ("left", "right", "bottom", "top", "near", "far")


def planes_from_matrix(clip_from_world: ArrayLike) -> F8:
    """Return planes f8[6,4] (order of PLANES) with unit inward normals: a point is inside where n.p + d >= 0.

    Gribb and Hartmann 2001, for reversed z in [0, w]: near is w - z, far is z. A projection without a far plane gives
    the plane (0, 0, 0, 1), which everything is inside of.
    """
    x, y, z, w = np.asarray(clip_from_world, np.float64)
    planes = np.stack([w + x, w - x, w + y, w - y, w - z, z])
    length = np.linalg.norm(planes[:, :3], axis=1, keepdims=True)
    # against the planes' own size: a far plane at infinity leaves rounding noise as its normal
    endless = length <= 1e-12 * np.abs(planes).max()
    return np.where(endless, [0.0, 0.0, 0.0, 1.0], planes / np.where(endless, 1.0, length))


def spheres_visible(planes: ArrayLike, centers: ArrayLike, radii: ArrayLike) -> NDArray[np.bool_]:
    """Return bool[n]: which spheres (`centers` [n,3], `radii` [n]) touch the frustum `planes` [6,4].

    Conservative: a sphere beside an edge of the frustum may pass. A NaN sphere does not.
    """
    planes = np.asarray(planes, np.float64)
    distance = np.asarray(centers, np.float64) @ planes[:, :3].T + planes[:, 3]
    result: NDArray[np.bool_] = np.all(distance >= -np.asarray(radii, np.float64)[:, None], axis=1)
    return result


def corners(world_from_clip: ArrayLike, far_depth: float) -> F8:
    """Return the eight corners f8[8,3] of a frustum between depth 1 (near) and `far_depth` in (0, 1), near first."""
    m = np.asarray(world_from_clip, np.float64)
    clip = np.array([[x, y, z, 1.0] for z in (1.0, far_depth) for y in (-1.0, 1.0) for x in (-1.0, 1.0)])
    points = clip @ m.T
    result: F8 = points[:, :3] / points[:, 3:]
    return result
