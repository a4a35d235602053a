"""A sensible camera for a scene that has none: from the front and a little above, everything in the picture."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from engine.math.transform import look_at
from engine.render.camera import Camera
from engine.resources.residency import Residency
from engine.scene.scene import Scene

#: degrees from the front (+Z) towards +X, and above the horizon
AZIMUTH, ELEVATION = 30.0, 18.0


def frame_bounds(
    low: NDArray[np.float64], high: NDArray[np.float64], aspect: float, *,
    azimuth: float = AZIMUTH, elevation: float = ELEVATION, yfov: float = math.radians(40.0),
) -> Camera:  # fmt: skip
    """A camera that sees the box [low, high] (f8[3], world) with a small margin; angles in degrees, `yfov` in radians.

    An empty or non-finite box gives a camera 3 m from the origin.
    """
    if not (np.isfinite(low).all() and np.isfinite(high).all()) or (low > high).any():
        low, high = np.full(3, -0.5), np.full(3, 0.5)
    center = (low + high) / 2
    radius = max(float(np.linalg.norm(high - low)) / 2, 1e-6)
    a, e = math.radians(azimuth), math.radians(elevation)
    back = np.array([math.sin(a) * math.cos(e), math.sin(e), math.cos(a) * math.cos(e)])
    # A flat thing is looked at along its thin axis, or it would be a line.
    size = high - low
    thin = int(np.argmin(size))
    if size[thin] < 1e-3 * radius:
        back = np.eye(3)[thin] + 1e-3 * np.array([0.0, 0.0, 1.0])
        back /= np.linalg.norm(back)
    up = np.array([0.0, 1.0, 0.0]) if abs(back[1]) < 0.99 else np.array([0.0, 0.0, -1.0])
    pose = look_at(center + back, center, up)
    corners = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
    local = (corners - center) @ pose[:3, :3]
    half_y = math.tan(yfov / 2) * 0.92
    half_x = half_y * aspect
    distance = float(np.max(np.maximum(np.abs(local[:, 0]) / half_x, np.abs(local[:, 1]) / half_y) + local[:, 2]))
    distance = max(distance, 0.05 * radius)
    pose[:3, 3] = center + back * distance
    return Camera(pose, yfov, znear=max(distance - radius, distance * 1e-3) * 0.2, zfar=distance + 4 * radius)


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
    return (center - extent).min(axis=0), (center + extent).max(axis=0)
