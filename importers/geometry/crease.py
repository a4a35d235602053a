"""Smooth normals up to a crease angle, for sources that say nothing about their normals."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from importers.geometry.normals import unit

F8 = NDArray[np.float64]
I8 = NDArray[np.int64]
#: pairs of corners looked at in one go
_CHUNK = 1 << 22
#: corners that meet at one point; beyond it all of them are averaged
_MOST = 128


def crease_normals(corners: F8, point: I8, angle: float) -> F8:
    """f8[t,3,3]: the normal of each corner of triangles f8[t,3,3] whose corners lie at the points i8[t,3].

    A corner's normal is the mean of the faces' at its point that turn from its own by less than `angle` radians, each
    weighted by its angle there (Thuermer and Wuthrich, 1998); +Z where there is no area.
    """
    faces = unit(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), (0.0, 0.0, 0.0))
    weight = _angles(corners).reshape(-1)
    face = np.repeat(np.arange(len(corners)), 3)
    order = np.argsort(point.reshape(-1), kind="stable")
    face, weight = face[order], weight[order]
    ordered = point.reshape(-1)[order]
    first = np.searchsorted(ordered, ordered, "left")
    size = np.searchsorted(ordered, ordered, "right") - first
    sums = np.zeros((len(order), 3))
    crowded = size > _MOST
    if crowded.any():
        means = np.stack([np.bincount(ordered, weight * faces[face, k], ordered[-1] + 1) for k in range(3)], 1)
        sums[crowded] = means[ordered[crowded]]
    rows = np.flatnonzero(~crowded)
    ends = np.cumsum(size[rows])
    limit, start = np.cos(angle), 0
    while start < len(rows):
        base = int(ends[start - 1]) if start else 0
        stop = max(int(np.searchsorted(ends, base + _CHUNK, "right")), start + 1)
        part = rows[start:stop]
        own = np.repeat(part, size[part])
        other = first[own] + np.arange(len(own)) - np.repeat(np.cumsum(size[part]) - size[part], size[part])
        near = np.einsum("ij,ij->i", faces[face[own]], faces[face[other]]) > limit - 1e-9
        own, other = own[near], other[near]
        for k in range(3):
            sums[:, k] += np.bincount(own, weight[other] * faces[face[other], k], len(order))
        start = stop
    result = np.empty_like(sums)
    result[order] = unit(sums, (0.0, 0.0, 1.0))
    return result.reshape(-1, 3, 3)


def _angles(corners: F8) -> F8:
    """f8[t,3]: the angle of the triangle at each corner."""
    a = unit((np.roll(corners, -1, axis=1) - corners).reshape(-1, 3), (0.0, 0.0, 0.0))
    b = unit((np.roll(corners, 1, axis=1) - corners).reshape(-1, 3), (0.0, 0.0, 0.0))
    angle = np.arccos(np.clip(np.einsum("ij,ij->i", a, b), -1.0, 1.0))
    return np.asarray(angle.reshape(-1, 3))
