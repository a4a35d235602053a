"""Polygons to triangles: convex and concave ones of any size, on whole arrays where they are small.

Quads are split along the diagonal that keeps both triangles facing the same way, the shorter one where both do. Larger
polygons are fans where that is convex, else ear-clipped (Held, "FIST", 2001, as the mapbox_earcut library does it) in
the plane of their Newell normal (Newell's method: Sutherland et al., 1974).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]


def triangulate(corners: Floats, first: Ints, count: Ints) -> tuple[Ints, Ints]:
    """Triangles of polygons: polygon p has corners first[p] .. first[p] + count[p] of `corners` f8[n,3], count >= 3.

    Returns triangles i8[t,3] of corner numbers, wound as the polygons are, and each one's polygon i8[t], both in the
    order of the polygons. A polygon of k corners always gives k - 2 triangles, some maybe without area.
    """
    # what is no number counts as 0: whoever draws the triangles leaves those out
    corners = np.where(np.abs(corners) < 1e140, corners, 0.0)
    pieces: list[Ints] = []
    owners: list[Ints] = []
    for size in np.unique(count):
        polygons = np.flatnonzero(count == size)
        rows = first[polygons, None] + np.arange(int(size))
        if size == 3:
            triangles = rows[:, None, :]
        elif size == 4:
            triangles = _quads(corners[rows], rows)
        else:
            triangles = _larger(corners[rows], rows)
        pieces.append(triangles.reshape(-1, 3))
        owners.append(np.repeat(polygons, int(size) - 2))
    if not pieces:
        return np.zeros((0, 3), np.int64), np.zeros(0, np.int64)
    owner = np.concatenate(owners)
    order = np.argsort(owner, kind="stable")
    return np.concatenate(pieces)[order], owner[order]


def _quads(p: Floats, rows: Ints) -> Ints:
    """[m,2,3] from corners f8[m,4,3]."""
    normal = newell_normals(p)
    # how far each corner turns left, seen against the normal: negative at a reflex corner
    turn = np.einsum("mij,mj->mi", np.cross(p - np.roll(p, 1, axis=1), np.roll(p, -1, axis=1) - p), normal)
    reflex = turn < 0
    length = np.stack([_square(p[:, 2] - p[:, 0]), _square(p[:, 3] - p[:, 1])], axis=1)
    # a diagonal must start at the reflex corner; at a tie within rounding the first one is taken
    second = (length[:, 1] < length[:, 0] * (1 - 1e-6)) & ~(reflex[:, 0] | reflex[:, 2])
    second |= (reflex[:, 1] | reflex[:, 3]) & ~(reflex[:, 0] | reflex[:, 2])
    a, b, c, d = rows.T
    one = np.stack([np.stack([a, b, c], 1), np.stack([a, c, d], 1)], axis=1)
    other = np.stack([np.stack([a, b, d], 1), np.stack([b, c, d], 1)], axis=1)
    return np.where(second[:, None, None], other, one)


def _larger(p: Floats, rows: Ints) -> Ints:
    """[m,k-2,3] from corners f8[m,k,3], k > 4."""
    count, size = rows.shape
    normal = newell_normals(p)
    turn = np.einsum("mij,mj->mi", np.cross(p - np.roll(p, 1, axis=1), np.roll(p, -1, axis=1) - p), normal)
    # a fan may be used where every corner turns left and the fan's triangles do, too (stars turn left everywhere)
    steps = np.cross(p[:, 1:-1] - p[:, :1], p[:, 2:] - p[:, :1])
    convex = (turn >= 0).all(axis=1) & (np.einsum("mij,mj->mi", steps, normal) >= 0).all(axis=1)
    local = np.empty((count, size - 2, 3), np.int64)
    k = np.arange(1, size - 1)
    local[:] = np.stack([np.zeros_like(k), k, k + 1], axis=1)
    for m in np.flatnonzero(~convex):
        local[m] = _ears(p[m], normal[m])
    return np.take_along_axis(rows[:, None, :], local.reshape(count, 1, -1), axis=2).reshape(count, size - 2, 3)


def _ears(p: Floats, normal: Floats) -> Ints:
    """[k-2,3] of a polygon f8[k,3]; a fan where no ear clipping comes to that number."""
    import mapbox_earcut  # only concave polygons need it

    size = len(p)
    side = np.eye(3)[int(np.argmin(np.abs(normal)))]
    u = np.cross(side, normal)
    length = np.linalg.norm(u)
    fan = np.stack([np.zeros(size - 2, np.int64), np.arange(1, size - 1), np.arange(2, size)], axis=1)
    if not np.isfinite(p).all() or not length > 0:
        return fan
    u /= length
    plane = (p - p[0]) @ np.stack([u, np.cross(normal, u)], axis=1)
    found = mapbox_earcut.triangulate_float64(np.ascontiguousarray(plane), np.array([size], np.uint32))
    triangles = np.asarray(found, np.int64).reshape(-1, 3)
    if not len(triangles):
        return fan
    # earcut's winding is fixed: turn it to the polygon's, which is left about its own normal
    a, b, c = plane[triangles[:, 0]], plane[triangles[:, 1]], plane[triangles[:, 2]]
    area = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    if area.sum() < 0:
        triangles = triangles[:, [0, 2, 1]]
    if len(triangles) >= size - 2:
        return triangles[: size - 2]
    # collinear and repeated corners are dropped by earcut: fill up with triangles without area
    missing = np.repeat(triangles[:1, :1], size - 2 - len(triangles), axis=0).repeat(3, axis=1)
    return np.concatenate([triangles, missing])


def newell_normals(p: Floats) -> Floats:
    """Unit normals f8[m,3] of polygons f8[m,k,3], zero where there is no area; any shape, also not planar."""
    with np.errstate(over="ignore", invalid="ignore"):
        q = p - p[:, :1]
        normal = np.cross(q, np.roll(q, -1, axis=1)).sum(axis=1)
        length = np.linalg.norm(normal, axis=1, keepdims=True)
        usable = np.isfinite(length) & (length > 0)
        result: Floats = np.where(usable, normal / np.where(usable, length, 1.0), 0.0)
    return result


def _square(v: Floats) -> Floats:
    result: Floats = np.einsum("mj,mj->m", v, v)
    return result
