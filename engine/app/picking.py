"""Picking: which node is under a pixel. On the CPU, against the real triangles of the few boxes that the ray meets."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.app.posed import posed_positions
from engine.render.view import View
from engine.resources.residency import Residency
from engine.scene.scene import Scene


def view_ray(view: View, x: float, y: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Origin and unit direction f8[3] (world) of the ray through pixel (x, y), from the top left."""
    ndc = np.array([2.0 * x / view.width - 1.0, 1.0 - 2.0 * y / view.height])
    world_from_clip = np.linalg.inv(view.camera.clip_from_world(view.aspect))
    near = world_from_clip @ np.array([*ndc, 1.0, 1.0])
    far = world_from_clip @ np.array([*ndc, 0.5, 1.0])
    start, end = near[:3] / near[3], far[:3] / far[3]
    direction = end - start
    return start, direction / np.linalg.norm(direction)


def pick_node(scene: Scene, residency: Residency, view: View, x: float, y: float) -> int:
    """The node row of the nearest visible triangle under the pixel, or -1."""
    origin, direction = view_ray(view, x, y)
    table = scene.instances
    if len(table.node) == 0:
        return -1
    to_center = table.world_center - origin
    along = to_center @ direction
    off_axis = np.einsum("ij,ij->i", to_center, to_center) - along**2
    shown = table.alive & table.visible & scene.nodes.visible_world[table.node]
    candidates = np.flatnonzero(
        shown & (off_axis <= table.world_radius.astype(np.float64) ** 2) & (along > -table.world_radius)
    )
    best, best_node = np.inf, -1
    for row in candidates[np.argsort(along[candidates] - table.world_radius[candidates])]:
        if along[row] - table.world_radius[row] > best:
            break
        distance = _nearest_triangle(scene, residency, int(row), origin, direction)
        if distance < best:
            best, best_node = distance, int(table.node[row])
    return best_node


def pick_hits(scene: Scene, residency: Residency, view: View, x: float, y: float) -> list[tuple[float, int]]:
    """(metres from the near plane, node row) of every visible node under the pixel, the nearest first."""
    return ray_hits(scene, residency, *view_ray(view, x, y))


def ray_hits(
    scene: Scene, residency: Residency, origin: NDArray[np.float64], direction: NDArray[np.float64]
) -> list[tuple[float, int]]:
    """(metres from `origin`, node row) of every visible node that the ray along the unit `direction` hits, the nearest
    first."""
    table = scene.instances
    if len(table.node) == 0:
        return []
    to_center = table.world_center - origin
    along = to_center @ direction
    off_axis = np.einsum("ij,ij->i", to_center, to_center) - along**2
    near = (off_axis <= table.world_radius.astype(np.float64) ** 2) & (along > -table.world_radius)
    nearest: dict[int, float] = {}
    for row in np.flatnonzero(table.drawn & near):
        distance = _nearest_triangle(scene, residency, int(row), origin, direction)
        if np.isfinite(distance):
            node = int(table.node[row])
            nearest[node] = min(distance, nearest.get(node, np.inf))
    return sorted((distance, node) for node, distance in nearest.items())


def _nearest_triangle(
    scene: Scene, residency: Residency, row: int, origin: NDArray[np.float64], direction: NDArray[np.float64]
) -> float:
    """Distance along the ray to the nearest triangle of an instance; inf when it misses.

    Moller and Trumbore 1997, "Fast, Minimum Storage Ray/Triangle Intersection", both faces.
    """
    table = scene.instances
    mesh = residency.meshes[int(table.mesh[row])].asset
    part = mesh.submeshes[int(table.submesh[row])]
    if part.topology != "triangles":
        return np.inf
    indices = mesh.indices[part.first_index : part.first_index + part.index_count].reshape(-1, 3)
    corners = posed_positions(scene, residency, row)[indices]
    edge1, edge2 = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    p = np.cross(direction, edge2)
    det = np.einsum("ij,ij->i", edge1, p)
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse = 1.0 / det
        s = origin - corners[:, 0]
        u = np.einsum("ij,ij->i", s, p) * inverse
        q = np.cross(s, edge1)
        v = (q @ direction) * inverse
        t = np.einsum("ij,ij->i", edge2, q) * inverse
        hit = (det != 0) & (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0)
    return float(t[hit].min()) if hit.any() else np.inf
