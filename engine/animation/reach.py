"""How far from each joint the vertices lie that follow it: what a pose's bounds are made of."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray


def joint_reach(
    positions: ArrayLike, joints: ArrayLike, weights: ArrayLike, inverse_bind: ArrayLike
) -> NDArray[np.float64]:
    """f8[k]: the greatest distance from joint j, in its own space, of a vertex with a weight on it; 0 where none has.

    `positions` [n,3] in mesh space, `joints` and `weights` [n,m], `inverse_bind` [k,4,4]. A posed vertex is a weighted
    mean of points that each lie within their joint's reach, so the union of these spheres holds every pose.
    """
    point = np.asarray(positions, np.float64)
    bind = np.asarray(inverse_bind, np.float64)
    index, weight = np.asarray(joints, np.int64), np.asarray(weights)
    reach = np.zeros(len(bind))
    for column in range(index.shape[1]):
        used = np.flatnonzero((weight[:, column] > 0) & (index[:, column] < len(bind)))
        of = index[used, column]
        local = np.einsum("nij,nj->ni", bind[of, :3, :3], point[used]) + bind[of, :3, 3]
        np.maximum.at(reach, of, np.linalg.norm(local, axis=1))
    return reach
