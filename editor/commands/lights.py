"""Edits that make many lights: scattered over a box, or whatever is selected repeated in a line, grid or ring."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from editor.commands.structure import change, copy_nodes, tops
from engine.scene.arrays import ArraySettings, check_total, moves, placed
from engine.scene.drift import drift_clip
from engine.scene.scatter import ScatterSettings, scatter_lights

if TYPE_CHECKING:
    from editor.document import Document

#: the table under which a document's overrides keep what drifts: (table, "distance", top row) -> (metres, seed)
DRIFTS = "drifts"


def scatter(document: Document, settings: ScatterSettings) -> None:
    """Scatter lights over the settings' own box, that of the selection, or that of the whole scene; one entry, their
    parent selected. Drifting ones move as soon as time goes on; the clip is written when the scene is saved."""
    low, high = box_of(document)

    def make() -> list[int]:
        top = scatter_lights(document.runtime.scene, settings, low, high)
        if settings.drift > 0.0:
            document.overrides[DRIFTS, "distance", top] = (settings.drift, settings.seed)
        return [top]

    change(document, f"Scatter {settings.count} lights", make)


def box_of(document: Document) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The world box (low, high) of the selection, or of the whole scene; a metre each way where that is empty."""
    low, high = document.bounds(document.selection) if document.selection else document.bounds()
    if not (np.isfinite(low).all() and np.isfinite(high).all()) or (high <= low).all():
        low, high = np.full(3, -1.0), np.full(3, 1.0)
    return low, high


def follow_drifts(document: Document) -> None:
    """Let the runtime play the drifts that the document has now: after a structural edit, an undo, a redo."""
    runtime: Any = document.runtime
    playing: dict[Any, Any] | None = getattr(runtime, "beside", None)
    if playing is None:
        return
    generation = runtime.scene.nodes.generation
    wanted = {
        (DRIFTS, top, int(generation[top]), *values): (top, *values)
        for (table, _column, top), values in document.overrides.items()
        if table == DRIFTS
    }
    for key in [k for k in playing if k[0] == DRIFTS and k not in wanted]:
        runtime.play_beside(key, None)
    for key, (top, distance, seed) in wanted.items():
        if key not in playing:
            runtime.play_beside(key, drift_clip(runtime.scene, top, distance, seed))


def array(document: Document, rows: Sequence[int], settings: ArraySettings) -> None:
    """Repeat nodes, with all below them, in a line, a grid or a ring; the originals are the first of it.

    One entry, all selected. Raises InputError for too many nodes."""
    nodes = document.runtime.scene.nodes
    heads = tops(document, rows)
    check_total((settings.total - 1) * sum(len(document.subtree(head)) for head in heads))
    at = np.mean([nodes.world_matrix(head)[:3, 3] for head in heads], axis=0)
    turned = settings.shape == "ring" and settings.turn

    def make() -> list[int]:
        made = list(heads)
        while len(made) < settings.total * len(heads):  # twice as many a turn
            made += copy_nodes(document, made[: settings.total * len(heads) - len(made)])
        above = [np.eye(4) if nodes.parent[h] < 0 else nodes.world_matrix(int(nodes.parent[h])) for h in heads]
        news = iter(made[len(heads) :])
        for move in moves(settings, at):
            for old, parent in zip(heads, above, strict=True):
                new, local = next(news), placed(move, nodes.local_matrix(old), parent)
                if turned:
                    nodes.set_matrix(new, local)
                elif nodes.has_matrix[new]:
                    nodes.set_matrix(new, np.hstack([nodes.local_matrix(new)[:, :3], local[:, 3:]]))
                else:
                    nodes.set_translation([new], [local[:3, 3]])
        return made

    if settings.total > 1:
        change(document, f"{settings.shape.capitalize()} of {settings.total}", make)
