"""Whether a point lies inside a body: seen from there, the nearest faces show their backs."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.assets.mesh import MeshAsset
from engine.math.transform import inverse_affine

#: slightly skew, so that rays do not run along the edges of boxes
DIRECTIONS = np.array(
    [
        [1.0, 0.013, 0.007], [-1.0, 0.011, -0.005], [0.009, 1.0, 0.012],
        [-0.006, -1.0, 0.014], [0.008, -0.011, 1.0], [0.012, 0.006, -1.0],
    ]
)  # fmt: skip
#: Of the six rays so many must meet a back first: a hole or an open end may let one go.
ENOUGH = 5


def is_inside(point_ws: NDArray[np.float64], mesh: MeshAsset, world_from_mesh: NDArray[np.float64]) -> bool:
    """Whether `point_ws` f8[3] is enclosed by the mesh's outward-facing triangles. A room does not count, as its walls
    face inward: a lamp belongs there.

    Ray and triangle after Moeller and Trumbore 1997, "Fast, Minimum Storage Ray/Triangle Intersection", section 2.
    """
    runs = [
        mesh.indices[s.first_index : s.first_index + s.index_count] for s in mesh.submeshes if s.topology == "triangles"
    ]
    if not runs:
        return False
    corners = np.asarray(mesh.streams["position"], np.float64)[np.concatenate(runs).reshape(-1, 3)]
    with np.errstate(all="ignore"):
        point = (inverse_affine(world_from_mesh) @ np.append(point_ws, 1.0))[:3]
        return sum(_sees_a_back(point, direction, corners) for direction in DIRECTIONS) >= ENOUGH


def _sees_a_back(point: NDArray[np.float64], direction: NDArray[np.float64], corners: NDArray[np.float64]) -> bool:
    """Whether the nearest triangle of `corners` f8[t,3,3] along the ray faces away from `point`, in mesh space."""
    a = corners[:, 0]
    e1, e2 = corners[:, 1] - a, corners[:, 2] - a
    p = np.cross(direction, e2)
    determinant = np.einsum("ij,ij->i", e1, p)
    usable = np.abs(determinant) > 0.0
    inverse = 1.0 / np.where(usable, determinant, 1.0)
    s = point - a
    u = np.einsum("ij,ij->i", s, p) * inverse
    q = np.cross(s, e1)
    v = (q @ direction) * inverse
    t = np.einsum("ij,ij->i", e2, q) * inverse
    hit = usable & (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (t > 0.0)
    if not hit.any():
        return False
    nearest = int(np.argmin(np.where(hit, t, np.inf)))
    # the determinant is -direction . (e1 x e2): below zero the ray leaves through the back
    return bool(determinant[nearest] < 0.0)
