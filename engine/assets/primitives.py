"""Simple shapes as MeshAssets: for tests, benches, floors and placeholders. Counter-clockwise outside, with tangents.

The bitangent w * cross(normal, tangent) points towards falling v: up in the texture (glTF 2.0, 3.9.3).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.assets.mesh import MeshAsset, Submesh


def snorm16(values: ArrayLike) -> NDArray[np.int16]:
    """[-1, 1] -> [-32767, 32767], rounded."""
    return np.round(np.clip(np.asarray(values, np.float64), -1.0, 1.0) * 32767.0).astype(np.int16)


def mesh_from_arrays(
    name: str, position: ArrayLike, normal: ArrayLike, tangent: ArrayLike, uv: ArrayLike, indices: ArrayLike
) -> MeshAsset:
    """One part from plain arrays: position [n,3], unit normal [n,3], unit tangent [n,4], uv [n,2], indices [m]."""
    position = np.ascontiguousarray(position, np.float32)
    normal = np.asarray(normal, np.float64)
    index = np.ascontiguousarray(indices, np.uint32).reshape(-1)
    low, high = position.min(axis=0).tolist(), position.max(axis=0).tolist()
    return MeshAsset(
        name,
        {
            "position": position,
            "normal": snorm16(np.pad(normal, ((0, 0), (0, 1)))),
            "tangent": snorm16(tangent),
            "uv0": np.ascontiguousarray(uv, np.float32),
        },
        index,
        [Submesh(0, len(index), 0, "triangles", tuple(low), tuple(high))],
    )


def uv_sphere(radius: float = 0.5, rings: int = 32, segments: int = 64) -> MeshAsset:
    """A sphere about the origin; u runs eastward from -Z's meridian, v from the north pole (+Y) down."""
    v, u = np.meshgrid(np.linspace(0.0, 1.0, rings + 1), np.linspace(0.0, 1.0, segments + 1), indexing="ij")
    theta, phi = v * np.pi, u * 2.0 * np.pi
    normal = np.stack([np.sin(theta) * np.sin(phi), np.cos(theta), -np.sin(theta) * np.cos(phi)], -1).reshape(-1, 3)
    tangent = np.stack([np.cos(phi), np.zeros_like(phi), np.sin(phi), -np.ones_like(phi)], -1).reshape(-1, 4)
    row, column = np.meshgrid(np.arange(rings), np.arange(segments), indexing="ij")
    a = (row * (segments + 1) + column).reshape(-1)
    b, c, d = a + 1, a + segments + 1, a + segments + 2
    indices = np.stack([a, b, c, b, d, c], -1)
    return mesh_from_arrays("sphere", normal * radius, normal, tangent, np.stack([u, v], -1).reshape(-1, 2), indices)


def plane(size: float = 1.0) -> MeshAsset:
    """A square in the XZ plane that faces +Y; u along +X, v along +Z."""
    h = size / 2
    position = [(-h, 0, -h), (h, 0, -h), (h, 0, h), (-h, 0, h)]
    uv = [(0, 0), (1, 0), (1, 1), (0, 1)]
    return mesh_from_arrays("plane", position, [(0, 1, 0)] * 4, [(1, 0, 0, 1)] * 4, uv, [0, 2, 1, 0, 3, 2])


def card(size: float = 1.0) -> MeshAsset:
    """A square in the XY plane that faces +Z; its top left is uv (0, 0)."""
    h = size / 2
    position = [(-h, h, 0), (h, h, 0), (h, -h, 0), (-h, -h, 0)]
    uv = [(0, 0), (1, 0), (1, 1), (0, 1)]
    return mesh_from_arrays("card", position, [(0, 0, 1)] * 4, [(1, 0, 0, 1)] * 4, uv, [0, 2, 1, 0, 3, 2])


def cube(size: float = 1.0) -> MeshAsset:
    """A cube about the origin: 24 vertices, 12 triangles."""
    position: list[NDArray[np.float64]] = []
    normal: list[NDArray[np.float64]] = []
    tangent: list[list[float]] = []
    uv: list[list[float]] = []
    indices: list[int] = []
    axes = np.eye(3)
    for axis in range(3):
        for sign in (1.0, -1.0):
            n = sign * axes[axis]
            t = axes[(axis + 1) % 3]
            b = np.cross(n, t)
            first = len(position)
            for s, r in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
                position.append((n + s * t + r * b) * (size / 2))
                normal.append(n)
                tangent.append([*t, 1.0])
                uv.append([(s + 1) / 2, (1 - r) / 2])
            indices += [first, first + 1, first + 2, first, first + 2, first + 3]
    return mesh_from_arrays("cube", position, normal, tangent, uv, indices)
