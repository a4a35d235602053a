"""Normals where a source has none: flat ones, as glTF 2.0 (section 3.7.2.1) asks for."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def flat_normals(
    positions: NDArray[np.float32], triangles: NDArray[np.uint32]
) -> tuple[NDArray[np.int64], NDArray[np.float32], NDArray[np.uint32]]:
    """Split vertices so that each triangle of u4[t,3] has its own flat normal; equal ones at a vertex stay joined.

    Returns `source` i8[n'], unit normals f4[n',3] (+Z where a triangle has no area), and triangles u4[t,3].
    """
    corners = positions[triangles].astype(np.float64)
    faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = unit(faces, (0.0, 0.0, 1.0)).astype(np.float32)
    # Coplanar neighbours share their vertices: join corners of equal vertex and equal normal (to 1e-4).
    rounded = np.round(normals * 1e4).astype(np.int64) + 10001
    code = (rounded[:, 0] * 20003 + rounded[:, 1]) * 20003 + rounded[:, 2]
    _, code = np.unique(code, return_inverse=True)
    key = triangles.astype(np.int64) * (int(code.max(initial=0)) + 1) + code.reshape(-1, 1)
    _, first, inverse = np.unique(key.reshape(-1), return_index=True, return_inverse=True)
    source = triangles.reshape(-1)[first].astype(np.int64)
    return source, normals[first // 3], inverse.reshape(-1, 3).astype(np.uint32)


def unit(vectors: NDArray[np.float64], fallback: tuple[float, float, float]) -> NDArray[np.float64]:
    """[n,3] scaled to length 1; `fallback` where the length is 0 or not finite. Safe from overflow and underflow."""
    largest = np.abs(vectors).max(axis=1, keepdims=True, initial=0.0)
    usable = np.isfinite(largest) & (largest > 0)
    scaled = np.where(usable, vectors, 0.0) / np.where(usable, largest, 1.0)
    length = np.linalg.norm(scaled, axis=1, keepdims=True)
    return np.where(usable, scaled / np.where(length > 0, length, 1.0), np.asarray(fallback))


def fill_normals(
    normals: NDArray[np.float32], positions: NDArray[np.float32], triangles: NDArray[np.uint32]
) -> NDArray[np.float32]:
    """Unit normals f4[n,3]; the zero ones become the area-weighted mean of their triangles' normals, or +Z."""
    missing = ~normals.any(axis=1)
    if not missing.any():
        return normals
    corners = positions[triangles].astype(np.float64)
    faces = np.repeat(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), 3, axis=0)
    flat = triangles.reshape(-1)
    columns = [np.bincount(flat, faces[:, k], len(normals)) for k in range(3)]
    sums = np.stack(columns, 1).astype(np.float64)
    result = normals.copy()
    result[missing] = unit(sums[missing], (0.0, 0.0, 1.0))
    return result
