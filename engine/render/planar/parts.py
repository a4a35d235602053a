"""The flat parts of a mesh: sets of triangles in one plane that are worth a mirror."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.assets.mesh import MeshAsset

F8 = NDArray[np.float64]

#: a part has at least this share of the area, and there are no more
LEAST_SHARE, MOST_PARTS = 0.1, 6
#: vertices may be off the plane by this part of the mesh's extent, normals by this angle's cosine (1 degree)
FLATNESS, ALIKE = 1e-3, 0.99985
#: places that tell how much of a part is in a picture
POINTS = 24


@dataclass(frozen=True, slots=True)
class FlatPart:
    """`plane` f8[4]: (n, w), n.x + w = 0, n unit on the side that is seen, in mesh space. `center` f8[3], `radius`: a
    sphere about it; `area`; `off`: how far vertices are from the plane; `whole`: there is nothing else in the mesh;
    `points` f8[POINTS,3]: spread evenly over it; `frame` f8[4,3]: corners of a rectangle about it."""

    plane: F8
    center: F8
    radius: float
    area: float
    off: float
    whole: bool
    points: F8
    frame: F8


def flat_parts(mesh: MeshAsset, submesh: int) -> list[FlatPart]:
    """The flat parts of a submesh, the largest first; none of lines and points, or where nothing is flat."""
    part = mesh.submeshes[submesh]
    if part.topology != "triangles":
        return []
    indices = mesh.indices[part.first_index : part.first_index + part.index_count].reshape(-1, 3)
    corners = np.asarray(mesh.streams["position"], np.float64)[indices, :3]
    if not len(corners) or not np.isfinite(corners).all():
        return []
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    doubled = np.linalg.norm(normal, axis=1)
    extent = float((corners.max(axis=(0, 1)) - corners.min(axis=(0, 1))).max())
    total, left = float(doubled.sum()), doubled > 1e-12 * extent * extent
    unit = normal / np.where(doubled > 0.0, doubled, 1.0)[:, None]
    found: list[FlatPart] = []
    for _ in range(2 * MOST_PARTS):
        if len(found) == MOST_PARTS or float(doubled[left].sum()) < LEAST_SHARE * total or not left.any():
            break
        seed = int(np.argmax(np.where(left, doubled, 0.0)))
        off = np.abs((corners - corners[seed, 0]) @ unit[seed]).max(axis=1)
        chosen = left & (unit @ unit[seed] > ALIKE) & (off < FLATNESS * extent)
        left &= ~chosen
        if float(doubled[chosen].sum()) >= LEAST_SHARE * total:
            found.append(_part(corners[chosen], unit[chosen], doubled[chosen], total))
    return sorted(found, key=lambda part: -part.area)


def _part(corners: F8, unit: F8, doubled: F8, total: float) -> FlatPart:
    points = corners.reshape(-1, 3)
    n = doubled @ unit
    n /= np.linalg.norm(n)
    w = -float(doubled @ (corners.mean(axis=1) @ n)) / float(doubled.sum())
    center = (points.min(axis=0) + points.max(axis=0)) / 2.0
    return FlatPart(
        np.append(n, w), center, float(np.linalg.norm(points - center, axis=1).max()), float(doubled.sum()) / 2.0,
        float(np.abs(points @ n + w).max()), bool(doubled.sum() > (1.0 - 1e-6) * total),
        _spread(corners, doubled), _frame(points, n),
    )  # fmt: skip


def _frame(points: F8, n: F8) -> F8:
    x = np.cross(n, np.eye(3)[int(np.argmin(np.abs(n)))])
    axes = np.stack([x / np.linalg.norm(x), np.cross(n, x / np.linalg.norm(x))])
    (left, low), (right, high) = (points @ axes.T).min(axis=0), (points @ axes.T).max(axis=0)
    around = np.array([(left, low), (right, low), (right, high), (left, high)])
    corners: F8 = around @ axes + n * float((points @ n).mean())
    return corners


def _spread(corners: F8, doubled: F8) -> F8:
    """Triangles by their areas, and places in them by the additive sequence of the plastic number."""
    k = np.arange(POINTS) + 0.5
    chosen = np.searchsorted(np.cumsum(doubled) / doubled.sum(), k / POINTS).clip(0, len(doubled) - 1)
    u, v = np.mod(np.outer([0.7548776662466927, 0.5698402909980532], k), 1.0)
    u, v = np.where(u + v > 1.0, 1.0 - u, u)[:, None], np.where(u + v > 1.0, 1.0 - v, v)[:, None]
    a, b, c = corners[chosen].transpose(1, 0, 2)
    points: F8 = a + u * (b - a) + v * (c - a)
    return points
