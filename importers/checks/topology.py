"""What is wrong with how a mesh hangs together. Vertices at one place count as one, where seams doubled them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.assets.mesh import MeshAsset
from engine.core.findings import Findings
from importers.geometry.topology import zero_area


def check_topology(mesh: MeshAsset, path: str, findings: Findings) -> None:
    """Add findings about edges with more than two triangles, and about neighbours that face opposite ways.

    Open edges are no fault: cloth, leaves and terrain have them."""
    triangles = welded_triangles(mesh)
    if not len(triangles):
        return
    crowded, turned = edge_faults(triangles)
    if crowded:
        findings.warn(
            "mesh.non-manifold", f"mesh {mesh.name!r}: {crowded:,} edges belong to more than two triangles", path,
            "remove inner faces and doubled geometry; such edges have no inside for shadows, physics and printing",
        )  # fmt: skip
    if turned:
        findings.warn(
            "mesh.winding", f"mesh {mesh.name!r}: at {turned:,} edges the triangles face opposite ways", path,
            "make the face orientation consistent; one side of such a surface is not drawn",
        )  # fmt: skip


def welded_triangles(mesh: MeshAsset) -> NDArray[np.int64]:
    """i8[t,3]: the triangles with area, by the number of their corners' place."""
    runs = [
        mesh.indices[s.first_index : s.first_index + s.index_count] for s in mesh.submeshes if s.topology == "triangles"
    ]
    if not runs:
        return np.zeros((0, 3), np.int64)
    positions = np.ascontiguousarray(mesh.streams["position"], np.float32) + np.float32(0.0)  # -0 becomes 0
    triangles = np.concatenate(runs).reshape(-1, 3)
    finite = np.isfinite(positions).all(axis=1)
    triangles = triangles[finite[triangles].all(axis=1)]
    triangles = triangles[~zero_area(positions, triangles)]
    _, place = np.unique(positions.view(np.void(12).dtype).reshape(-1), return_inverse=True)
    welded: NDArray[np.int64] = place.reshape(-1)[triangles].astype(np.int64)
    # one triangle that is there twice the same way is a doublet, not a fault of its edges
    rolled = np.stack([np.roll(welded, k, axis=1) for k in range(3)], 1)
    first = np.argmin(welded, axis=1)
    normal = rolled[np.arange(len(welded)), -first % 3]
    return np.unique(normal, axis=0) if len(normal) else normal


def edge_faults(triangles: NDArray[np.int64]) -> tuple[int, int]:
    """(edges of more than two triangles, edges of two that run along it in the same direction)."""
    ends = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    low, high = ends.min(axis=1), ends.max(axis=1)
    _, number = np.unique(low * (int(ends.max()) + 1) + high, return_inverse=True)
    number = number.reshape(-1)
    count = np.bincount(number)
    forward = np.bincount(number, weights=ends[:, 0] < ends[:, 1], minlength=len(count))
    return int(np.count_nonzero(count > 2)), int(np.count_nonzero((count == 2) & (forward != 1)))
