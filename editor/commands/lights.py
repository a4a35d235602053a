"""Edits that make many lights: scattered over a box, or whatever is selected repeated along three steps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from editor.commands.structure import change, copy_nodes, tops
from engine.core.errors import InputError
from engine.scene.scatter import ScatterSettings, scatter_lights

if TYPE_CHECKING:
    from editor.document import Document

#: nodes that an array may make
MOST_COPIES = 5_000


def scatter(document: Document, settings: ScatterSettings) -> None:
    """Scatter lights over the box of the selection, or of the whole scene; one entry, their parent selected."""
    low, high = document.bounds(document.selection) if document.selection else document.bounds()
    if not (np.isfinite(low).all() and np.isfinite(high).all()) or (high <= low).all():
        low, high = np.full(3, -1.0), np.full(3, 1.0)  # an empty scene
    change(
        document, f"Scatter {settings.count} lights",
        lambda: [scatter_lights(document.runtime.scene, settings, low, high)],
    )  # fmt: skip


def array(document: Document, rows: Sequence[int], counts: Sequence[int], step: ArrayLike) -> None:
    """Repeat nodes, with all below them, `counts` [3] times along world X, Y and Z, `step` f8[3] metres apart.

    The originals are the first of them. One entry, all selected. Raises InputError for more than MOST_COPIES nodes.
    """
    nodes = document.runtime.scene.nodes
    heads = tops(document, rows)
    places = np.stack(np.meshgrid(*[np.arange(max(int(c), 1)) for c in counts], indexing="ij"), -1).reshape(-1, 3)[1:]
    total = len(places) * sum(len(document.subtree(head)) for head in heads)
    if total > MOST_COPIES:
        raise InputError(f"an array of {total:,} nodes", hint=f"{MOST_COPIES:,} can be made at once")
    offsets = places * np.asarray(step, np.float64)

    def make() -> list[int]:
        made = list(heads)
        for offset in offsets:
            copies = copy_nodes(document, heads)
            for old, new in zip(heads, copies, strict=True):
                parent = int(nodes.parent[old])
                local = offset if parent < 0 else np.linalg.solve(nodes.world_matrix(parent)[:3, :3], offset)
                if nodes.has_matrix[new]:
                    matrix = nodes.local_matrix(new)
                    matrix[:3, 3] += local
                    nodes.set_matrix(new, matrix)
                else:
                    nodes.set_translation([new], [nodes.translation[old] + local])
            made += copies
        return made

    if len(offsets):
        change(document, f"Array of {len(places) + 1}", make)
