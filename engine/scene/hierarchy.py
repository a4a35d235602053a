"""The order in which a forest is worked through: level by level, each node's children side by side."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

I4 = NDArray[np.int32]
I8 = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Hierarchy:
    """Breadth-first order of the living rows. A position is an index into `order`.

    `order` i8[m]: rows by level, siblings together. `level_start` i8[levels+1]: positions. `child_start`,
    `child_count` i8[m]: a position's children are positions child_start .. child_start + child_count. `is_identity`:
    order is 0, 1, 2, ..., so positions are rows.
    """

    order: I8
    level_start: I8
    child_start: I8
    child_count: I8
    is_identity: bool

    @property
    def levels(self) -> int:
        return len(self.level_start) - 1

    def children(self, positions: I8) -> I8:
        """Return the positions of all children of `positions`, parents in the given order."""
        return ranges(self.child_start[positions], self.child_count[positions])


def build(parent: I4, alive: NDArray[np.bool_]) -> Hierarchy:
    """Return the hierarchy of the living rows; a living row's parent is living or -1. O(n log n)."""
    rows = np.flatnonzero(alive)
    above = parent[rows]
    roots, inner = rows[above < 0], rows[above >= 0]
    by_parent = inner[np.argsort(parent[inner], kind="stable")]
    count = np.bincount(parent[inner], minlength=len(parent)) if inner.size else np.zeros(len(parent), np.int64)
    first = np.cumsum(count) - count
    levels, level_start, starts, counts = [roots], [0, len(roots)], [], []
    while levels[-1].size:
        frontier = levels[-1]
        c = count[frontier]
        counts.append(c)
        starts.append(level_start[-1] + np.cumsum(c) - c)
        levels.append(by_parent[ranges(first[frontier], c)])
        level_start.append(level_start[-1] + len(levels[-1]))
    order = np.concatenate(levels)
    assert len(order) == len(rows), "the parents form a cycle"
    return Hierarchy(
        order=order,
        level_start=np.array(level_start[:-1], np.int64),
        child_start=np.concatenate(starts) if starts else np.zeros(0, np.int64),
        child_count=np.concatenate(counts) if counts else np.zeros(0, np.int64),
        is_identity=bool(len(order) == len(parent) and np.array_equal(order, np.arange(len(order)))),
    )


def ranges(starts: I8, counts: I8) -> I8:
    """Return the concatenation of the ranges start .. start + count."""
    total = int(counts.sum())
    if total == 0:
        return np.zeros(0, np.int64)
    ends = np.cumsum(counts)
    result: I8 = np.arange(total) + np.repeat(starts - (ends - counts), counts)
    return result


def subtree(parent: I4, alive: NDArray[np.bool_], tops: I8) -> I8:
    """Return the living rows at or below `tops`, rising. O(n) per level of the tallest subtree."""
    inside = np.zeros(len(parent), np.bool_)
    inside[tops] = True
    rest = np.flatnonzero(alive & (parent >= 0) & ~inside)
    while rest.size:
        joins = inside[parent[rest]]
        if not joins.any():
            break
        inside[rest[joins]] = True
        rest = rest[~joins]
    return np.flatnonzero(inside & alive)
