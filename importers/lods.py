"""Levels of detail: simplified copies of meshes on the vertices of the first, each with half the triangles.

    mesh ─ equal positions welded ─ quadric edge collapses (Garland and Heckbert, 1997; fast-simplification) ─ each
    point left stands for one of the mesh's own ─ its corners take the vertices there that face the same way

They stand in the .lmesh behind the meshes of the source, named NAME.lod1 …; `extras["lods"]` of the first lists them
with triangles and error. No node shows them: choosing one is the engine's business.
"""

from __future__ import annotations

import dataclasses
import importlib.util

import numpy as np
from numpy.typing import NDArray

from engine.assets.mesh import MeshAsset, Submesh
from engine.core.errors import UsageError
from importers.model import ImportedModel
from importers.processing import gather_vertices

F8 = NDArray[np.float64]
I8 = NDArray[np.int64]
#: meshes with fewer triangles stay as they are
_LEAST = 64


def add_lods(model: ImportedModel, levels: int) -> None:
    """Append up to `levels` simplified copies of each mesh of triangles. Raises UsageError without the library."""
    if importlib.util.find_spec("fast_simplification") is None:
        raise UsageError("levels of detail need the fast-simplification library", hint="pip install lucarna[lods]")
    for number in range(len(model.meshes)):
        mesh = model.meshes[number]
        if any(part.topology != "triangles" for part in mesh.submeshes) or len(mesh.indices) < 3 * _LEAST:
            continue
        listed: list[dict[str, object]] = []
        for level in range(1, levels + 1):
            made = simplified(mesh, 0.5**level)
            if made is None:
                break
            lod, error = made
            lod.name = f"{mesh.name}.lod{level}"
            listed.append({"mesh": len(model.meshes), "triangles": len(lod.indices) // 3, "error_m": error})
            model.meshes.append(lod)
            model.slots.append(list(model.slots[number]))
            model.findings.info(
                "mesh.lod", f"{len(lod.indices) // 3:,} of {len(mesh.indices) // 3:,} triangles, off by "
                f"{1000.0 * error:.3g} mm at most", f"meshes[{lod.name}]",
            )  # fmt: skip
        if listed:
            mesh.extras["lods"] = listed


def simplified(mesh: MeshAsset, share: float) -> tuple[MeshAsset, float] | None:
    """A copy with about `share` of the triangles, and how far, in metres, a vertex of the mesh lies from it at most;
    None where nothing could be taken away."""
    import fast_simplification

    positions = np.asarray(mesh.streams["position"], np.float64)
    # what lies closer together than float32 can say of the mesh's size is one point
    step = max(float(np.ptp(positions, axis=0).max()), 1e-30) * 1e-6
    _, first, point = np.unique(np.rint(positions / step), axis=0, return_index=True, return_inverse=True)
    corners, point = positions[first], point.reshape(-1)
    triangles = mesh.indices.reshape(-1, 3).astype(np.int64)
    faces = point[triangles]
    owner = np.repeat(np.arange(len(mesh.submeshes)), [part.index_count // 3 for part in mesh.submeshes])
    solid = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    faces, owner, triangles = faces[solid], owner[solid], triangles[solid]
    _, _, collapses = fast_simplification.simplify(
        corners.astype(np.float32), faces.astype(np.int32), 1.0 - share, return_collapses=True
    )
    _, _, mapping = fast_simplification.replay_simplification(
        corners.astype(np.float32), faces.astype(np.int32), collapses
    )
    mapping = np.asarray(mapping, np.int64)
    if not len(mapping) or mapping.max() + 1 >= len(corners):
        return None
    stands = _representatives(corners, mapping)
    moved = stands[mapping]
    kept = moved[faces]
    left = (kept[:, 0] != kept[:, 1]) & (kept[:, 1] != kept[:, 2]) & (kept[:, 2] != kept[:, 0])
    kept, owner, triangles = kept[left], owner[left], triangles[left]
    if not len(kept) or len(kept) >= len(mesh.indices) // 3:
        return None
    vertices = _attributes(mesh, kept, triangles, point, corners)
    error = _error(corners, moved, kept)
    return _copy(mesh, vertices, owner), error


def _representatives(corners: F8, mapping: I8) -> I8:
    """For each point that is left, the one of those that fell into it that lies nearest their middle."""
    count = int(mapping.max()) + 1
    size = np.bincount(mapping, minlength=count)
    middle = np.stack([np.bincount(mapping, corners[:, k], count) / np.maximum(size, 1) for k in range(3)], 1)
    off = np.linalg.norm(corners - middle[mapping], axis=1)
    order = np.lexsort((off, mapping))
    first = np.searchsorted(mapping[order], np.arange(count))
    return np.asarray(order[np.minimum(first, len(order) - 1)], np.int64)


def _attributes(mesh: MeshAsset, kept: I8, triangles: I8, point: I8, corners: F8) -> I8:
    """Vertices i8[t,3]: the old corner's own where it has not moved, else the one there whose normal and uv come
    nearest the old corner's."""
    order = np.argsort(point, kind="stable")
    first = np.searchsorted(point[order], np.arange(len(corners)))
    size = np.bincount(point, minlength=len(corners))
    wanted, old = kept.reshape(-1), triangles.reshape(-1)
    normal = np.asarray(mesh.streams["normal"], np.float64)[:, :3] / 32767.0
    uv = np.asarray(mesh.streams["uv0"], np.float64) if "uv0" in mesh.streams else np.zeros((len(normal), 2))
    best = order[first[wanted]]
    cost = np.full(len(wanted), np.inf)
    for step in range(int(size.max(initial=1))):
        there = step < size[wanted]
        vertex = order[np.where(there, first[wanted] + step, 0)]
        off = 1.0 - np.einsum("ij,ij->i", normal[vertex], normal[old]) + np.abs(uv[vertex] - uv[old]).sum(axis=1)
        better = there & (off < cost)
        best, cost = np.where(better, vertex, best), np.where(better, off, cost)
    return best.reshape(-1, 3)


def _error(corners: F8, moved: I8, kept: I8) -> float:
    """The largest distance from a point of the mesh to the triangles around the point that stands for it."""
    order = np.argsort(kept.reshape(-1), kind="stable")
    around = order // 3
    names = kept.reshape(-1)[order]
    first, last = np.searchsorted(names, moved, "left"), np.searchsorted(names, moved, "right")
    nearest = np.linalg.norm(corners - corners[moved], axis=1)
    for step in range(int((last - first).max(initial=0))):
        rows = np.flatnonzero(first + step < last)
        face = kept[around[first[rows] + step]]
        nearest[rows] = np.minimum(nearest[rows], _distance(corners[rows], *(corners[face[:, k]] for k in range(3))))
    return float(nearest.max(initial=0.0))


def _distance(p: F8, a: F8, b: F8, c: F8) -> F8:
    """From points to triangles, row by row: inside by the plane, outside by the nearest of the edges."""
    n = np.cross(b - a, c - a)
    area = np.einsum("ij,ij->i", n, n)
    inside = area > 0
    for u, v in ((a, b), (b, c), (c, a)):
        inside &= np.einsum("ij,ij->i", np.cross(v - u, p - u), n) >= 0
    plane = np.abs(np.einsum("ij,ij->i", p - a, n)) / np.sqrt(np.where(area > 0, area, 1.0))
    result = np.where(inside, plane, np.inf)
    for u, v in ((a, b), (b, c), (c, a)):
        edge = v - u
        length = np.einsum("ij,ij->i", edge, edge)
        t = np.clip(np.einsum("ij,ij->i", p - u, edge) / np.where(length > 0, length, 1.0), 0.0, 1.0)
        result = np.minimum(result, np.linalg.norm(p - u - t[:, None] * edge, axis=1))
    return result


def _copy(mesh: MeshAsset, vertices: I8, owner: I8) -> MeshAsset:
    """The mesh with these triangles only, and without the vertices that they leave over."""
    parts: list[Submesh] = []
    runs: list[NDArray[np.uint32]] = []
    first = 0
    for number, part in enumerate(mesh.submeshes):
        run = vertices[owner == number].reshape(-1).astype(np.uint32)
        parts.append(dataclasses.replace(part, first_index=first, index_count=len(run)))
        runs.append(run)
        first += len(run)
    copy = MeshAsset(mesh.name, dict(mesh.streams), mesh.indices, parts, mesh.skeleton, list(mesh.morphs), {})
    indices = np.concatenate(runs)
    gather_vertices(copy, np.unique(indices).astype(np.int64), indices)
    return copy
