"""What to select, hide and lock: pure functions on a document. No imgui."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from editor.camera_controls import OrbitCamera, project

if TYPE_CHECKING:
    from editor.document import Document


def nodes_in_box(
    document: Document, camera: OrbitCamera, a: tuple[float, float], b: tuple[float, float], aspect: float
) -> list[int]:
    """Rows of the visible, unlocked nodes with a mesh, light or camera whose middle projects between the corners `a`
    and `b` (0..1 from the top left), rising."""
    scene = document.runtime.scene
    table = scene.instances
    drawn = np.flatnonzero(table.drawn)
    carriers = [t.node[t.alive] for t in (scene.lights, scene.cameras)]
    others = np.unique(np.concatenate(carriers)).astype(np.int64)
    others = others[scene.nodes.visible_world[others]]
    rows = np.concatenate([table.node[drawn].astype(np.int64), others])
    points = np.concatenate([table.world_center[drawn], scene.nodes.world[others, :, 3]])
    if not len(rows):
        return []
    pixels, depth = project(camera, points, aspect, 1.0)
    u, v = pixels[:, 0] / aspect, pixels[:, 1]
    inside = (u >= min(a[0], b[0])) & (u <= max(a[0], b[0])) & (v >= min(a[1], b[1])) & (v <= max(a[1], b[1]))
    found = np.unique(rows[inside & (depth > camera.znear)])
    return [int(row) for row in found if int(row) not in document.locked]


def hidden_by_isolating(document: Document, rows: Sequence[int]) -> list[int]:
    """Rows to hide so that only `rows`, what is below them and what is needed to show them is visible. Lights stay."""
    scene = document.runtime.scene
    keep: set[int] = set()
    for row in rows:
        keep.update(document.subtree(row))
        at = int(scene.nodes.parent[row])
        while at >= 0:
            keep.add(at)
            at = int(scene.nodes.parent[at])
    lights = {int(n) for n in scene.lights.node[scene.lights.alive]}
    drawn = np.unique(scene.instances.node[scene.instances.alive])
    visible = scene.nodes.visible
    return [int(r) for r in drawn if int(r) not in keep and int(r) not in lights and visible[r]]
