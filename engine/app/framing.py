"""A sensible camera for a scene that has none: from the front and a little above, everything in the picture."""

from __future__ import annotations

import itertools
import math

import numpy as np
from numpy.typing import NDArray

from engine.app.posed import posed_positions
from engine.math.transform import look_at
from engine.render.camera import Camera
from engine.resources.residency import Residency
from engine.scene.scene import Scene

#: degrees from the front (+Z) towards +X, and above the horizon
AZIMUTH, ELEVATION = 30.0, 18.0
#: how much of the picture's width or height the scene may fill
FILL = 0.9
#: vertices looked at for framing; a scene with more is framed by its boxes
POINT_LIMIT = 2_000_000


def frame_points(
    points: NDArray[np.float64], aspect: float, *,
    azimuth: float = AZIMUTH, elevation: float = ELEVATION, yfov: float = math.radians(40.0),
) -> Camera:  # fmt: skip
    """The nearest camera in that direction that has all `points` (f8[n,3], world) in the picture, with a small margin.

    Angles in degrees, `yfov` in radians. No or non-finite points give a camera that sees the unit cube.
    """
    points = points[np.isfinite(points).all(axis=1)]
    if len(points) == 0:
        points = np.array(list(itertools.product((-0.5, 0.5), repeat=3)))
    low, high = points.min(axis=0), points.max(axis=0)
    center = (low + high) / 2
    radius = max(float(np.linalg.norm(high - low)) / 2, 1e-6)
    pose = look_at(center + _direction(high - low, radius, azimuth, elevation), center)
    # In the camera's axes, |x - cx| <= tx (d - z) must hold for all points, and the same for y: the smallest d and the
    # best cx follow from the largest x + tx z and the largest -x + tx z.
    x, y, z = ((points - center) @ pose[:3, :3]).T
    ty = math.tan(yfov / 2) * FILL
    tx = ty * aspect
    right, left = float((x + tx * z).max()), float((-x + tx * z).max())
    top, bottom = float((y + ty * z).max()), float((-y + ty * z).max())
    distance = max((right + left) / (2 * tx), (top + bottom) / (2 * ty), float(z.max()) + 0.05 * radius)
    pose[:3, 3] = center + pose[:3, :3] @ np.array([(right - left) / 2, (top - bottom) / 2, distance])
    nearest = distance - float(z.max())
    return Camera(pose, yfov, znear=max(nearest * 0.2, distance * 1e-3), zfar=distance + 4 * radius)


def frame_bounds(
    low: NDArray[np.float64], high: NDArray[np.float64], aspect: float, *,
    azimuth: float = AZIMUTH, elevation: float = ELEVATION, yfov: float = math.radians(40.0),
) -> Camera:  # fmt: skip
    """As `frame_points` for the box [low, high] (f8[3], world); an empty one counts as no points."""
    empty = not (np.isfinite(low).all() and np.isfinite(high).all()) or bool((low > high).any())
    corners = [] if empty else list(itertools.product(*zip(low, high, strict=True)))
    points = np.array(corners, np.float64).reshape(-1, 3)
    return frame_points(points, aspect, azimuth=azimuth, elevation=elevation, yfov=yfov)


def _direction(size: NDArray[np.float64], radius: float, azimuth: float, elevation: float) -> NDArray[np.float64]:
    """From the scene to the camera, unit. A flat thing is looked at along its thin axis, or it would be a line."""
    thin = int(np.argmin(size))
    if size[thin] < 1e-3 * radius and float(np.sort(size)[1]) > 1e-3 * radius:
        along: NDArray[np.float64] = np.eye(3)[thin] + np.array([0.0, 0.0, 1e-3])  # looking straight down, north is up
        along /= np.linalg.norm(along)
        return along
    if size[2] < 0.25 * min(size[0], size[1]) and (azimuth, elevation) == (AZIMUTH, ELEVATION):
        azimuth = elevation = 0.0  # a card or relief that faces the front is made to be seen head-on
    a, e = math.radians(azimuth), math.radians(elevation)
    return np.array([math.sin(a) * math.cos(e), math.sin(e), math.cos(a) * math.cos(e)])


def scene_points(scene: Scene, residency: Residency) -> NDArray[np.float64]:
    """World positions f8[n,3] of what is drawn: every vertex, or the boxes' corners where those are too many."""
    table = scene.instances
    rows = np.flatnonzero(table.drawn)
    # a mesh is looked at once per node, however many submeshes it draws there
    once = dict(zip(zip(table.node[rows].tolist(), table.mesh[rows].tolist(), strict=True), rows.tolist(), strict=True))
    if sum(residency.meshes[mesh].asset.vertex_count for _, mesh in once) > POINT_LIMIT:
        low, high = scene_box(scene, residency)
        return np.array(list(itertools.product(*zip(low, high, strict=True))), np.float64)
    parts = [posed_positions(scene, residency, row) for row in once.values()]
    return np.concatenate(parts) if parts else np.zeros((0, 3))


def scene_box(scene: Scene, residency: Residency) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(min, max: f8[3], world) of the drawn instances' boxes; (+inf, -inf) when nothing is drawn. Call after update."""
    table = scene.instances
    rows = np.flatnonzero(table.drawn)
    if len(rows) == 0:
        return np.full(3, np.inf), np.full(3, -np.inf)
    shapes, of_row = np.unique(np.stack([table.mesh[rows], table.submesh[rows]], 1), axis=0, return_inverse=True)
    parts = [residency.meshes[mesh].asset.submeshes[submesh] for mesh, submesh in shapes.tolist()]
    low = np.array([p.bounds_min for p in parts], np.float64)[of_row.reshape(-1)]
    high = np.array([p.bounds_max for p in parts], np.float64)[of_row.reshape(-1)]
    world = scene.nodes.world[table.node[rows]]
    # Arvo 1990, "Transforming Axis-Aligned Bounding Boxes": centre by the matrix, extent by its absolute values
    center = np.einsum("nij,nj->ni", world[:, :, :3], (low + high) / 2) + world[:, :, 3]
    extent = np.einsum("nij,nj->ni", np.abs(world[:, :, :3]), (high - low) / 2)
    morph = scene.morphs.of_nodes(table.node[rows])
    posed = (scene.skins.of_nodes(table.node[rows]) >= 0) | np.append(scene.morphs.active, False)[morph]
    center[posed] = table.world_center[rows[posed]]
    extent[posed] = table.world_radius[rows[posed], None]
    return (center - extent).min(axis=0), (center + extent).max(axis=0)
