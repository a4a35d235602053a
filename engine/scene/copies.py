"""Copies: nodes that clips move as they move another one, as of now."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from engine.assets.clip_nodes import ClipNodes, clip_number
from engine.scene.scene import Scene

I8 = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Copies:
    """Pair i: what clips do to the node that row `leader[i]` held when the scene was opened happens to `row[i]` too.

    `placed` bool[k]: these take only morph weights."""

    leader: I8 = field(default_factory=lambda: np.zeros(0, np.int64))
    row: I8 = field(default_factory=lambda: np.zeros(0, np.int64))
    placed: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, np.bool_))

    def __len__(self) -> int:
        return len(self.row)

    @property
    def moving(self) -> Copies:
        """Those whose transforms follow."""
        keep = ~self.placed
        return self if keep.all() else Copies(self.leader[keep], self.row[keep], self.placed[keep])

    def repeat(self, rows: I8) -> tuple[I8, I8]:
        """(which of `rows`, as indices; copies' rows): every pair whose leader is among `rows`."""
        order = np.argsort(rows, kind="stable")
        at = np.searchsorted(rows[order], self.leader)
        found = np.flatnonzero(at < len(rows))
        found = found[rows[order[at[found]]] == self.leader[found]]
        return order[at[found]], self.row[found]


def copies_of(scene: Scene, lead: ClipNodes | None, opened: I8) -> Copies:
    """The scene's copies: `lead` and `opened` i8[nodes], rows by index, are as when it was opened.

    Runs after structural changes only, so a plain loop is fine here."""
    index_of = {int(row): i for i, row in enumerate(scene.row_of_node.tolist()) if row >= 0}
    found: list[tuple[int, int, bool]] = []
    for row, source in scene.sources.items():
        if source.clip_node is None:
            continue
        number = clip_number(source, -1)
        leader = number if lead is None else lead.weighed.get(number, -1)
        if 0 <= leader < len(opened) and index_of.get(row, -1) != leader:
            found.append((int(opened[leader]), row, source.placed))
    if not found:
        return Copies()
    table = np.array(found, np.int64)
    return Copies(table[:, 0], table[:, 1], table[:, 2].astype(np.bool_))
