"""The gizmo's arithmetic: from a moved pivot to new local transforms of all that is selected. No imgui.

begin(document, local) -> Grip          when a drag starts: the pivot and every node's place
moved(grip, delta, mode) -> locals      delta = pivot_now @ inv(pivot_start), world space
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from editor.camera_controls import OrbitCamera
from editor.commands.structure import tops
from editor.tables import plain
from engine.math import transform

if TYPE_CHECKING:
    from editor.document import Document

F8 = NDArray[np.float64]
MODES = ("select", "move", "rotate", "scale")
#: what Ctrl snaps to: degrees, and a factor
SNAP_DEGREES, SNAP_FACTOR = 15.0, 0.1


@dataclass(frozen=True, slots=True)
class Grip:
    """`pivot` f8[4,4] rigid; per row of `rows` its world f8[4,4], its parent's, its `local` in the tables."""

    rows: tuple[int, ...]
    pivot: F8
    world: tuple[F8, ...]
    parent: tuple[F8, ...]
    local: tuple[tuple[Any, ...], ...]


def held_rows(document: Document) -> tuple[int, ...]:
    """The selection's topmost nodes that are not locked: what a drag moves."""
    return tuple(row for row in tops(document, document.selection) if row not in document.locked)


def pivot_of(document: Document, rows: tuple[int, ...], *, local: bool) -> F8:
    """Rigid f8[4,4]: in the middle of the nodes, turned as the last selected one or as the world."""
    nodes = document.runtime.scene.nodes
    pivot = np.eye(4)
    pivot[:3, 3] = nodes.world[list(rows), :, 3].mean(axis=0)
    if local:
        _t, q, _s = transform.decompose(nodes.world_matrix(rows[-1]))
        pivot[:3, :3] = transform.compose(np.zeros(3), q, np.ones(3))[:3, :3]
    return pivot


def begin(document: Document, *, local: bool) -> Grip | None:
    """Take hold of the selection; None when there is nothing to hold."""
    rows = held_rows(document)
    if not rows:
        return None
    nodes = document.runtime.scene.nodes
    above = [int(nodes.parent[row]) for row in rows]
    return Grip(
        rows,
        pivot_of(document, rows, local=local),
        tuple(nodes.world_matrix(row) for row in rows),
        tuple(nodes.world_matrix(p) if p >= 0 else np.eye(4) for p in above),
        document.tables["nodes"].read("local", rows),
    )


def moved(grip: Grip, delta: F8, mode: str) -> list[tuple[Any, ...]]:
    """New `local` values (see tables.NodeColumns) of the grip's rows after the pivot moved by `delta` (world f8[4,4]).

    What a gesture does not touch stays bit for bit: moving keeps rotation and scale, turning keeps the scale. A node
    that is a TRS stays one: turned inside a skewed parent it gets the nearest."""
    found = []
    for world, parent, (translation, rotation, scale, matrix) in zip(grip.world, grip.parent, grip.local, strict=True):
        local = transform.inverse_affine(parent) @ delta @ world
        place = plain(local[:3, 3]) if not np.array_equal(delta @ world[:, 3], world[:, 3]) else translation
        if mode == "move":
            kept = None if matrix is None else plain(_with_place(matrix, place))
            found.append((place, rotation, scale, kept))
            continue
        _t, q, s = transform.decompose(local)
        if mode == "rotate":
            found.append(
                (place, plain(q), scale, None) if matrix is None else (place, plain(q), plain(s), plain(local))
            )
        else:
            s = np.where(np.abs(s) > 1e-6, s, np.copysign(1e-6, s))  # a zero scale has no inverse, and nothing to see
            turned = plain(q) if len(grip.rows) > 1 else rotation
            found.append((place, turned, plain(s), None if matrix is None else plain(local)))
    return found


def scaling(grip: Grip, factors: tuple[float, float, float]) -> F8:
    """The world delta f8[4,4] that scales by `factors` along the pivot's axes."""
    diagonal = np.diag([*factors, 1.0])
    result: F8 = grip.pivot @ diagonal @ transform.inverse_affine(grip.pivot)
    return result


def scaled_alone(grip: Grip, factors: tuple[float, float, float]) -> list[tuple[Any, ...]]:
    """One node scaled along its own axes: exactly its scale times the factors."""
    translation, rotation, scale, matrix = grip.local[0]
    new = tuple(s * f if abs(s * f) > 1e-6 else math.copysign(1e-6, s * f) for s, f in zip(scale, factors, strict=True))
    if matrix is not None:
        matrix = plain(np.array(matrix) @ np.diag([*factors, 1.0]))
    return [(translation, rotation, new, matrix)]


def snap_step(camera: OrbitCamera) -> float:
    """Metres that Ctrl snaps a move to: a power of ten, about a hundredth of what is seen."""
    return float(10.0 ** math.floor(math.log10(max(camera.distance, 1e-6) * 0.1)))


def camera_matrices(camera: OrbitCamera, aspect: float) -> tuple[F8, F8]:
    """(camera_from_eye, clip_from_camera) f8[4,4] for the widget, in a space whose origin is the eye.

    Relative to the eye float32 suffices anywhere; depth is -1..1 between finite planes, as the widget wants it."""
    view = np.eye(4)
    view[:3, :3] = camera.rotation().T
    near, far = 0.01 * camera.distance, 1000.0 * camera.distance
    clip = np.zeros((4, 4))
    if camera.orthographic:
        clip[0, 0], clip[1, 1] = 1.0 / (camera.ymag * aspect), 1.0 / camera.ymag
        clip[2, 2], clip[2, 3], clip[3, 3] = -2.0 / (far - near), -(far + near) / (far - near), 1.0
    else:
        focal = 1.0 / math.tan(0.5 * camera.yfov)
        clip[0, 0], clip[1, 1] = focal / aspect, focal
        clip[2, 2], clip[2, 3], clip[3, 2] = -(far + near) / (far - near), -2.0 * far * near / (far - near), -1.0
    return view, clip


def _with_place(matrix: Any, place: Any) -> F8:
    result = np.array(matrix, np.float64)
    result[:3, 3] = place
    return result
