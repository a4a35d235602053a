"""Standing on surfaces: what is dragged with Shift stands on what is under the pointer; what is dropped, on what is
below. No imgui."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from editor import gizmo
from editor.gizmo import Grip
from engine.core.errors import LucarnaError

if TYPE_CHECKING:
    from editor.document import Document
    from editor.session import Session

F8 = NDArray[np.float64]


def foot_of(document: Document, grip: Grip) -> F8:
    """The point of what is held that shall touch: below its pivot, at the lowest of its box; the pivot of what has no
    size."""
    point: F8 = grip.pivot[:3, 3].copy()
    low, high = document.bounds(grip.rows)
    if np.isfinite(low).all() and np.isfinite(high).all():
        point[1] = low[1]
    return point


def under(session: Session, rows: Sequence[int], u: float, v: float) -> F8 | None:
    """Where (u, v) of the viewport, 0..1 from its top left, hits something that neither is nor hangs below `rows`."""
    document = session.document
    if document is None:
        return None
    held = {node for row in rows for node in document.subtree(row)}
    return next((np.asarray(point, np.float64) for row, point in session.hits(u, v) if row not in held), None)


def drop(session: Session) -> None:
    """Put each selected node straight down onto what is below it, else onto the ground at y = 0: one entry."""
    document = session.document
    if document is None:
        return
    alive = document.runtime.scene.nodes.alive
    grips = [Grip((row,), *_parts(document, row)) for row in gizmo.held_rows(document) if alive[row]]
    rows, values = [], []
    held = {node for grip in grips for node in document.subtree(grip.rows[0])}
    for grip in grips:
        foot = foot_of(document, grip)
        delta = np.eye(4)
        delta[1, 3] = _ground(document, foot, held) - foot[1]
        rows.append(grip.rows[0])
        values += gizmo.moved(grip, delta, "move")
    if rows:
        what = session.node_name(rows[0]) if len(rows) == 1 else f"{len(rows)} nodes"
        session.edit("nodes", "local", rows, values, label=f"Drop {what}")


def _parts(document: Document, row: int) -> tuple[F8, tuple[F8], tuple[F8], tuple[tuple[object, ...]]]:
    nodes = document.runtime.scene.nodes
    parent = int(nodes.parent[row])
    pivot = np.eye(4)
    pivot[:3, 3] = nodes.world_matrix(row)[:3, 3]
    above = nodes.world_matrix(parent) if parent >= 0 else np.eye(4)
    local = document.tables["nodes"].read("local", (row,))[0]
    return pivot, (nodes.world_matrix(row),), (above,), (local,)


def _ground(document: Document, foot: F8, held: set[int]) -> float:
    """The height of what is below `foot` (or no more than a hair above it), or 0."""
    from engine.app.picking import ray_hits

    runtime = document.runtime
    lift = 1e-4 * max(1.0, float(np.abs(foot).max()))
    origin = foot + np.array([0.0, lift, 0.0])
    try:
        hits = ray_hits(runtime.scene, runtime.residency, origin, np.array([0.0, -1.0, 0.0]))
    except LucarnaError:
        return 0.0
    return next((float(origin[1] - distance) for distance, row in hits if row not in held), 0.0)
