"""Building parts as MeshAssets: boxes, turned columns, arches, pierced walls. Metres; uv in metres too.

Every part is made of patches: grids of points whose normals come from the two directions along the grid, so a patch is
smooth in itself and has a hard edge to its neighbours.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.assets.mesh import MeshAsset
from engine.assets.primitives import mesh_from_arrays

F8 = NDArray[np.float64]
Vec = tuple[float, float, float]


class Patches:
    """Collects grids of points; `mesh` makes one MeshAsset of them all."""

    def __init__(self) -> None:
        self._parts: list[tuple[F8, F8, F8, F8, NDArray[np.int64]]] = []
        self._count = 0

    def grid(self, points: F8) -> None:
        """Add a grid of `points` [rows,columns,3]. Its outside is where columns run right and rows run down."""
        rows, columns = points.shape[:2]
        along, down = _slope(points, 1), _slope(points, 0)
        normal = _unit(np.cross(down, along))
        right = _unit(along - (along * normal).sum(-1, keepdims=True) * normal)
        tangent = np.concatenate([right, np.ones((rows, columns, 1))], axis=-1)
        tangent[..., 3] = 1.0
        uv = np.stack([_distance(points, 1), _distance(points, 0)], axis=-1)
        i, j = np.meshgrid(np.arange(rows - 1), np.arange(columns - 1), indexing="ij")
        a = (i * columns + j).reshape(-1) + self._count
        faces = np.stack([a, a + columns, a + columns + 1, a, a + columns + 1, a + 1], axis=1)
        flat = (-1, 3)
        self._parts.append(
            (points.reshape(flat), normal.reshape(flat), tangent.reshape(-1, 4), uv.reshape(-1, 2), faces)
        )
        self._count += rows * columns

    def quad(self, corners: Sequence[ArrayLike]) -> None:
        """Add four corners, seen from outside: top left, top right, bottom left, bottom right."""
        self.grid(np.array(corners, np.float64).reshape(2, 2, 3))

    def box(self, low: Vec, high: Vec, *, without: str = "") -> None:
        """Add a box; `without`: faces to leave out, of "-x+x-y+y-z+z" (two letters each)."""
        (x0, y0, z0), (x1, y1, z1) = low, high
        faces = {
            "+z": ((x0, y1, z1), (x1, y1, z1), (x0, y0, z1), (x1, y0, z1)),
            "-z": ((x1, y1, z0), (x0, y1, z0), (x1, y0, z0), (x0, y0, z0)),
            "+x": ((x1, y1, z1), (x1, y1, z0), (x1, y0, z1), (x1, y0, z0)),
            "-x": ((x0, y1, z0), (x0, y1, z1), (x0, y0, z0), (x0, y0, z1)),
            "+y": ((x0, y1, z0), (x1, y1, z0), (x0, y1, z1), (x1, y1, z1)),
            "-y": ((x0, y0, z1), (x1, y0, z1), (x0, y0, z0), (x1, y0, z0)),
        }
        for name, corners in faces.items():
            if name not in {without[i : i + 2] for i in range(0, len(without), 2)}:
                self.quad(corners)

    def turned(self, profile: Iterable[Sequence[tuple[float, float]]], segments: int) -> None:
        """Add a body turned about +Y. `profile`: runs of (radius, height) going down; an edge is hard between runs."""
        angle = np.linspace(0.0, 2.0 * np.pi, segments + 1)
        for run in profile:
            radius, height = np.array(run, np.float64).T
            radius = np.maximum(radius, 1e-9)  # a pole of radius 0 has no direction along its circle, so no normal
            x = radius[:, None] * np.sin(angle)
            z = radius[:, None] * np.cos(angle)
            self.grid(np.stack([x, np.broadcast_to(height[:, None], x.shape), z], axis=-1))

    def mesh(self, name: str) -> MeshAsset:
        position, normal, tangent, uv, faces = (np.concatenate(column) for column in zip(*self._parts, strict=True))
        return mesh_from_arrays(name, position, normal, tangent, uv, faces)


def box(name: str, low: Vec, high: Vec) -> MeshAsset:
    patches = Patches()
    patches.box(low, high)
    return patches.mesh(name)


def column(name: str, radius: float, height: float, segments: int = 24) -> MeshAsset:
    """A round column on a square plinth with a capital, standing on y = 0; the shaft swells slightly."""
    patches = Patches()
    plinth, slab = 0.10 * height / 3.0, 0.07 * height / 3.0
    wide = 1.45 * radius
    patches.box((-wide, 0.0, -wide), (wide, plinth, wide), without="-y")
    patches.box((-wide, height - slab, -wide), (wide, height, wide))
    s = np.linspace(0.0, 1.0, 5)
    top, bottom = height - slab - 0.5 * radius, plinth + 0.35 * radius
    shaft = [(radius * (0.86 + 0.14 * np.sqrt(t)), top + (bottom - top) * t) for t in s.tolist()]
    bell = [(wide - (wide - 0.86 * radius) * np.sqrt(t), height - slab - 0.5 * radius * t) for t in s.tolist()]
    foot = np.linspace(0.0, np.pi, 7)
    torus = [(radius + 0.2 * radius * np.sin(a), bottom - 0.175 * radius * (1 - np.cos(a))) for a in foot.tolist()]
    patches.turned([bell, shaft, torus], segments)
    return patches.mesh(name)


def arch(name: str, span: float, rise: float, height: float, depth: float, segments: int = 16) -> MeshAsset:
    """A wall `span` wide (about x = 0), `height` high and `depth` thick (about z = 0) over a round opening of `rise`
    from its foot at y = 0, half an ellipse that leaves a tenth of the span as feet."""
    a = np.linspace(np.pi, 0.0, segments + 1)
    opening = np.stack([0.45 * span * np.cos(a), rise * np.sin(a)], axis=1)
    curve = np.concatenate([[[-0.5 * span, 0.0]], opening, [[0.5 * span, 0.0]]])
    top = np.stack([curve[:, 0], np.full(len(curve), height)], axis=1)
    half = depth / 2
    patches = Patches()
    for first, end in ((0, 2), (1, len(curve) - 1), (len(curve) - 2, len(curve))):
        face = np.stack([top[first:end], curve[first:end]])
        patches.grid(np.concatenate([face, np.full((*face.shape[:2], 1), half)], axis=-1))
        back = face[:, ::-1]
        patches.grid(np.concatenate([back, np.full((*back.shape[:2], 1), -half)], axis=-1))
    under = np.stack([np.insert(opening, 2, z, axis=1) for z in (half, -half)])
    patches.grid(under)
    x = 0.5 * span
    patches.quad([(-x, height, -half), (x, height, -half), (-x, height, half), (x, height, half)])
    for low, high in ((-x, -0.9 * x), (0.9 * x, x)):
        patches.quad([(low, 0, half), (high, 0, half), (low, 0, -half), (high, 0, -half)])
    return patches.mesh(name)


def _slope(points: F8, axis: int) -> F8:
    """Return the direction along `axis`, unit, taken over both neighbours where there are two."""
    count = points.shape[axis]
    ahead = np.take(points, np.minimum(np.arange(count) + 1, count - 1), axis)
    behind = np.take(points, np.maximum(np.arange(count) - 1, 0), axis)
    return _unit(ahead - behind)


def _distance(points: F8, axis: int) -> F8:
    steps = np.linalg.norm(np.diff(points, axis=axis), axis=-1)
    start = np.zeros_like(np.take(steps, [0], axis))
    result: F8 = np.cumsum(np.concatenate([start, steps], axis=axis), axis=axis)
    return result


def _unit(v: F8) -> F8:
    result: F8 = v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-30)
    return result
