"""Tangent frames as MikkTSpace makes them, on whole arrays.

Source: Mikkelsen, "Simulation of Wrinkled Surfaces Revisited" (2008), chapter 4, and the rules of its reference
implementation, which glTF 2.0 (section 3.7.2.1) names: corners are grouped around a vertex over shared edges of equal
handedness; each triangle adds its uv tangent, projected on the vertex's tangent plane, weighted by the corner's angle.
Differs in one thing: triangles without area in uv space take the frame of a group at their vertex that has one, or an
arbitrary frame, where the reference copies from the first neighbour that it meets.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from importers.geometry.normals import unit

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def tangent_frames(
    positions: NDArray[np.float32],
    normals: NDArray[np.float32],
    uv: NDArray[np.float32],
    triangles: NDArray[np.uint32],
) -> tuple[Ints, NDArray[np.float32], NDArray[np.uint32]]:
    """Tangents of triangles u4[t,3] over vertices [n,3], [n,3], [n,2].

    Returns `source` i8[n'] (vertices are split where frames differ; those of no triangle stay), tangents f4[n',4]
    (unit, orthogonal to the normal; w = +-1, bitangent = w * cross(normal, tangent)) and triangles u4[t,3].
    The direction follows growing u; w makes the bitangent follow *shrinking* v, since uv start at the top left and
    tangent-space normals have +Y up.
    """
    flat = triangles.reshape(-1).astype(np.int64)
    if not len(flat):
        source = np.arange(len(positions), dtype=np.int64)
        return source, _arbitrary(normals.astype(np.float64)), triangles
    # MikkTSpace gets v growing upwards from glTF tools (1 - v): so do we.
    texture = np.stack([uv[:, 0], 1.0 - uv[:, 1]], 1).astype(np.float64)
    welded = _weld(positions, normals, uv)[flat]
    p, t = positions[flat].astype(np.float64).reshape(-1, 3, 3), texture[flat].reshape(-1, 3, 2)
    n = unit(normals[flat].astype(np.float64), (0.0, 0.0, 1.0))

    d1, d2 = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]
    t1, t2 = t[:, 1] - t[:, 0], t[:, 2] - t[:, 0]
    area = t1[:, 0] * t2[:, 1] - t1[:, 1] * t2[:, 0]
    with np.errstate(over="ignore", invalid="ignore"):
        face_tangent = t2[:, 1:2] * d1 - t1[:, 1:2] * d2
    good = (area != 0) & np.isfinite(face_tangent).all(axis=1) & (np.abs(face_tangent).max(axis=1) > 0)
    positive = area > 0
    face_tangent = unit(face_tangent * np.where(positive, 1.0, -1.0)[:, None], (1.0, 0.0, 0.0))

    group = _groups(welded.reshape(-1, 3), positive, good)
    corner_good = np.repeat(good, 3)
    vectors = np.repeat(face_tangent, 3, axis=0)
    vectors = unit(vectors - n * _dot(n, vectors), (0.0, 0.0, 0.0))
    vectors *= _corner_angles(p, n.reshape(-1, 3, 3)).reshape(-1, 1) * corner_good[:, None]
    columns = [np.bincount(group, vectors[:, k], len(flat)) for k in range(3)]
    sums = np.stack(columns, 1).astype(np.float64)
    signs = np.zeros(len(flat))
    signs[group[corner_good]] = np.where(np.repeat(positive, 3)[corner_good], 1.0, -1.0)
    return _split(len(positions), normals, flat, group, sums, signs)


def _split(
    count: int, normals: NDArray[np.float32], flat: Ints, group: Ints, sums: Floats, signs: Floats
) -> tuple[Ints, NDArray[np.float32], NDArray[np.uint32]]:
    """One vertex per (old vertex, group), in the order of the old ones; unused old vertices are appended."""
    _, dense = np.unique(group, return_inverse=True)
    key = flat * (int(dense.max()) + 1) + dense
    _, first, inverse = np.unique(key, return_index=True, return_inverse=True)
    source = flat[first]
    frames = group[first]
    unused = np.setdiff1d(np.arange(count, dtype=np.int64), flat)
    source = np.concatenate([source, unused])
    n = unit(normals[source].astype(np.float64), (0.0, 0.0, 1.0))
    tangents = _arbitrary(n).astype(np.float64)
    used = len(frames)
    # The groups' sums lie near the tangent plane already; make them exactly orthogonal to each vertex's own normal.
    direction = sums[frames] - n[:used] * _dot(n[:used], sums[frames])
    direction = unit(direction, (0.0, 0.0, 0.0))
    known = (np.abs(direction).max(axis=1) > 0) & (signs[frames] != 0)
    tangents[:used][known, :3] = direction[known]
    tangents[:used][known, 3] = signs[frames][known]
    return source, tangents.astype(np.float32), inverse.reshape(-1, 3).astype(np.uint32)


def _groups(welded: Ints, positive: NDArray[np.bool_], good: NDArray[np.bool_]) -> Ints:
    """i8[3t]: a group number per corner. Corners at one vertex join over shared edges between triangles of equal
    handedness; corners of triangles without uv area join any group at their vertex."""
    corners = np.arange(welded.size, dtype=np.int64).reshape(-1, 3)
    start, end = welded.reshape(-1), np.roll(welded, -1, axis=1).reshape(-1)
    next_corner = np.roll(corners, -1, axis=1).reshape(-1)
    a, b = _matching_edges(start, end)
    face_a, face_b = a // 3, b // 3
    same = good[face_a] & good[face_b] & (positive[face_a] == positive[face_b])
    a, b = a[same], b[same]
    # Edge a runs u -> v, edge b runs v -> u: at u meet corner a and the end of b, at v the end of a and corner b.
    label = _components(welded.size, np.concatenate([a, next_corner[a]]), np.concatenate([next_corner[b], b]))
    corner_good = np.repeat(good, 3)
    if not corner_good.all():
        adopt = np.full(int(start.max()) + 1, -1, np.int64)
        # reversed, so that the first group at a vertex wins
        adopt[start[corner_good][::-1]] = label[corner_good][::-1]
        bad = np.flatnonzero(~corner_good)
        found = adopt[start[bad]]
        label[bad] = np.where(found >= 0, found, bad)
    return label


def _matching_edges(start: Ints, end: Ints) -> tuple[Ints, Ints]:
    """Pairs of directed edges that run opposite ways between the same vertices; the k-th with the k-th of its kind."""
    scale = int(max(start.max(), end.max())) + 1
    forward, backward = start * scale + end, end * scale + start
    order = np.argsort(forward, kind="stable")
    ordered = forward[order]
    rank = np.arange(len(ordered)) - np.searchsorted(ordered, ordered)
    ranks = np.empty_like(order)
    ranks[order] = rank
    wanted = np.flatnonzero(start < end)
    position = np.searchsorted(ordered, backward[wanted]) + ranks[wanted]
    inside = position < len(ordered)
    wanted, position = wanted[inside], position[inside]
    matched = ordered[position] == backward[wanted]
    return wanted[matched], order[position[matched]]


def _components(count: int, a: Ints, b: Ints) -> Ints:
    """Connected components: the smallest member of each (hooking and pointer jumping; Shiloach and Vishkin, 1982)."""
    parent = np.arange(count, dtype=np.int64)
    while True:
        root_a, root_b = parent[a], parent[b]
        apart = root_a != root_b
        if not apart.any():
            return parent
        np.minimum.at(parent, np.maximum(root_a, root_b)[apart], np.minimum(root_a, root_b)[apart])
        while True:
            jumped = parent[parent]
            if np.array_equal(jumped, parent):
                break
            parent = jumped


def _weld(positions: NDArray[np.float32], normals: NDArray[np.float32], uv: NDArray[np.float32]) -> Ints:
    """i8[n]: equal numbers for vertices of equal position, normal and uv."""
    rows = np.concatenate([positions, normals, uv], axis=1).astype(np.float32) + np.float32(0)  # -0 becomes 0
    bits = rows.view(np.uint32)
    order = np.lexsort(bits.T)
    changed = np.ones(len(rows), bool)
    changed[1:] = (bits[order[1:]] != bits[order[:-1]]).any(axis=1)
    result = np.empty(len(rows), np.int64)
    result[order] = np.cumsum(changed) - 1
    return result


def _corner_angles(p: Floats, n: Floats) -> Floats:
    """f8[t,3]: the angle at each corner, between the edges projected on the plane of the corner's normal."""
    to_next = np.roll(p, -1, axis=1) - p
    to_previous = np.roll(p, 1, axis=1) - p
    a = unit((to_next - n * _dot(n, to_next)).reshape(-1, 3), (0.0, 0.0, 0.0))
    b = unit((to_previous - n * _dot(n, to_previous)).reshape(-1, 3), (0.0, 0.0, 0.0))
    angle = np.arccos(np.clip(np.einsum("ij,ij->i", a, b), -1.0, 1.0))
    return np.asarray(angle.reshape(-1, 3))


def _arbitrary(n: Floats) -> NDArray[np.float32]:
    """Some unit tangent for each unit normal, w = 1 (Duff et al., 2017, eq. of section 3)."""
    sign = np.where(n[:, 2] >= 0, 1.0, -1.0)
    a = -1.0 / (sign + n[:, 2])
    b = n[:, 0] * n[:, 1] * a
    return np.stack([1.0 + sign * n[:, 0] ** 2 * a, sign * b, -sign * n[:, 0], np.ones(len(n))], 1).astype(np.float32)


def _dot(a: Floats, b: Floats) -> Floats:
    return np.asarray((a * b).sum(axis=-1, keepdims=True))
