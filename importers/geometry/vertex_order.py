"""Triangle and vertex order for the GPU: vertex cache and overdraw (triangles), then fetch (vertices).

Triangles: Sander, Nehab, Barczak, "Fast Triangle Reordering for Vertex Locality and Reduced Overdraw" (2007): fans
around the vertex that stays longest in a FIFO cache; the runs that this gives are then drawn outermost first. Vertices
are numbered as they are first used.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Triangles = NDArray[np.uint32]
I8 = NDArray[np.int64]

#: entries of the cache that is assumed; smaller than most, and near the best for larger ones, too
CACHE = 16
#: a run may be cut where it has come down to this many misses per triangle (the paper's lambda)
_SOFT = 0.75


def cache_order(triangles: Triangles, cache: int = CACHE) -> tuple[I8, I8]:
    """The order i8[t] in which to draw triangles u4[t,3], and the places in it at which runs begin.

    A run begins where the walk reached a dead end, or where it had become cheap enough to begin anew.
    """
    count = len(triangles)
    if not count:
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    used, flat = np.unique(triangles, return_inverse=True)
    flat = flat.reshape(-1)
    vertices = len(used)
    by_vertex = np.argsort(flat, kind="stable") // 3
    starts = np.concatenate([[0], np.cumsum(np.bincount(flat, minlength=vertices))]).tolist()
    around, corner = by_vertex.tolist(), flat.reshape(-1, 3).tolist()
    live = np.bincount(flat, minlength=vertices).tolist()
    stamp = [-(cache + 1)] * vertices
    done = bytearray(count)
    order: list[int] = []
    begins: list[int] = [0]
    dead_ends: list[int] = []
    time, cursor, fan, misses, since = 0, 0, 0, 0, 0
    while fan >= 0:
        ring: list[int] = []
        for triangle in around[starts[fan] : starts[fan + 1]]:
            if done[triangle]:
                continue
            done[triangle] = 1
            order.append(triangle)
            since += 1
            for v in corner[triangle]:
                ring.append(v)
                live[v] -= 1
                if time - stamp[v] > cache:
                    stamp[v] = time
                    time += 1
                    misses += 1
        dead_ends += ring
        # of the ring, the oldest vertex that is still in the cache once its own fan is drawn
        best, priority = -1, -1
        for v in ring:
            if live[v]:
                age = time - stamp[v]
                worth = age if age + 2 * live[v] <= cache else 0
                if worth > priority:
                    best, priority = v, worth
        hard = best < 0
        while best < 0 and dead_ends:
            v = dead_ends.pop()
            if live[v]:
                best = v
        while best < 0 and cursor < vertices:
            if live[cursor]:
                best = cursor
            cursor += 1
        fan = best
        if len(order) > begins[-1] and fan >= 0 and (hard or misses <= _SOFT * since):
            begins.append(len(order))
            misses, since = 0, 0
            if not hard:
                # the paper measures each run as if it began with an empty cache
                time += cache + 1
    return np.array(order, np.int64), np.array(begins, np.int64)


def outermost_first(positions: NDArray[np.float32], triangles: Triangles, begins: I8) -> I8:
    """The order i8[t] of ordered triangles whose runs are sorted: first those that face away from the middle and lie
    far from it, as they hide the others more often (section 4.2 of the paper)."""
    corners = positions[triangles].astype(np.float64)
    area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = np.linalg.norm(area, axis=1)
    center = corners.mean(axis=1)
    run = np.zeros(len(triangles), np.int64)
    run[begins[1:]] = 1
    run = np.cumsum(run)
    runs = len(begins)
    weight = np.maximum(np.bincount(run, size, runs), 1e-300)
    means = np.stack([np.bincount(run, size * center[:, k], runs) / weight for k in range(3)], 1)
    normals = np.stack([np.bincount(run, area[:, k], runs) for k in range(3)], 1)
    length = np.maximum(np.linalg.norm(normals, axis=1), 1e-300)
    middle = (size[:, None] * center).sum(axis=0) / max(float(size.sum()), 1e-300)
    potential = np.einsum("ij,ij->i", means - middle, normals) / length
    rank = np.empty(runs, np.int64)
    rank[np.argsort(-potential, kind="stable")] = np.arange(runs)
    return np.argsort(rank[run], kind="stable")


def fetch_order(indices: NDArray[np.uint32], count: int) -> I8:
    """Old vertex numbers i8[count] in the order of their first use; unused ones stay behind, in their order."""
    used, first = np.unique(indices, return_index=True)
    ordered = used[np.argsort(first, kind="stable")].astype(np.int64)
    rest = np.ones(count, bool)
    rest[ordered] = False
    return np.concatenate([ordered, np.flatnonzero(rest)])


def cache_misses(triangles: Triangles, cache: int = CACHE) -> int:
    """How many vertices a FIFO cache of that size has to load for these triangles."""
    stamp: dict[int, int] = {}
    time = 0
    for v in triangles.reshape(-1).tolist():
        if time - stamp.get(v, -cache - 1) > cache:
            stamp[v] = time
            time += 1
    return time


def acmr(triangles: Triangles, cache: int = CACHE) -> float:
    """Average cache miss ratio: vertices loaded per triangle; 0.5 at best for large meshes, 3 at worst."""
    return cache_misses(triangles, cache) / max(len(triangles), 1)


def atvr(triangles: Triangles, cache: int = CACHE) -> float:
    """Average transform to vertex ratio: vertices loaded per vertex that is used; 1 at best."""
    return cache_misses(triangles, cache) / max(len(np.unique(triangles)), 1)


def line_misses(indices: Sequence[int] | NDArray[np.uint32], stride: int, line: int = 64, lines: int = 256) -> int:
    """How many lines of memory are fetched for the vertices in the order of first use, by a FIFO cache of `lines`."""
    stamp: dict[int, int] = {}
    time = 0
    for v in np.asarray(indices).tolist():
        for address in range(v * stride // line, ((v + 1) * stride - 1) // line + 1):
            if time - stamp.get(address, -lines - 1) > lines:
                stamp[address] = time
                time += 1
    return time
