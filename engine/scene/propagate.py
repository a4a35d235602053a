"""From local to world transforms: one batched product per level of the hierarchy, only where something changed.

A node's world translation is kept as its parent's plus `reach` (the parent's linear part times the node's
translation), so a subtree that is only carried along costs one addition per node.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.scene.hierarchy import Hierarchy
from engine.scene.table import blocks

F8 = NDArray[np.float64]
Bool = NDArray[np.bool_]
I4 = NDArray[np.int32]
I8 = NDArray[np.int64]

#: vectors up to which `apply` costs its calls rather than its work
_FEW = 64


@dataclass(slots=True)
class Columns:
    """The arrays that `propagate` works on, by row. Read: parent, translation, linear (R S). Written: reach, world."""

    parent: I4
    translation: F8
    linear: F8
    reach: F8
    world: F8


def propagate(hierarchy: Hierarchy, columns: Columns, moved: Bool, turned: Bool) -> tuple[I8, I8]:
    """Bring `world` up to date; return (rows whose world changed, rows among them whose linear part changed).

    `moved`, `turned` bool[n] by row: whose own translation or linear part changed. Both results are in level order.
    """
    order = hierarchy.order
    own = moved if hierarchy.is_identity else moved[order]
    turn = turned.copy() if hierarchy.is_identity else turned[order]
    touch = own | turn
    for level in range(hierarchy.levels):
        start, stop = int(hierarchy.level_start[level]), int(hierarchy.level_start[level + 1])
        amount = int(np.count_nonzero(touch[start:stop]))
        if amount == 0:
            continue
        whole = amount == stop - start
        positions = slice(start, stop) if whole else start + np.flatnonzero(touch[start:stop])
        rows = positions if hierarchy.is_identity else order[positions]
        turning = turn[positions]
        if level == 0:
            _place_roots(columns, rows, turning)
        else:
            _place_children(columns, rows, turning, own[positions] | turning)
        if level + 1 < hierarchy.levels:
            _mark_children(hierarchy, level, positions, whole, turning, touch, turn)
    return _rows(hierarchy, touch), _rows(hierarchy, turn)


def _place_roots(c: Columns, rows: slice | I8, turning: Bool) -> None:
    c.world[rows, :, 3] = c.translation[rows]
    if turning.any():
        some = rows if turning.all() else _pick(rows, turning)
        c.world[some, :, :3] = c.linear[some]


def _place_children(c: Columns, rows: slice | I8, turning: Bool, reaching: Bool) -> None:
    if turning.all():
        for some in blocks(rows):
            above = c.world.take(c.parent[some], axis=0)
            world = np.empty_like(above)
            np.matmul(above[:, :, :3], c.linear[some], out=world[:, :, :3])
            reach = apply(above[:, :, :3], c.translation[some])
            np.add(above[:, :, 3], reach, out=world[:, :, 3])
            c.world[some] = world
            c.reach[some] = reach
        return
    if turning.any():
        for some in blocks(_pick(rows, turning)):
            c.world[some, :, :3] = c.world.take(c.parent[some], axis=0)[:, :, :3] @ c.linear[some]
    if reaching.any():
        for some in blocks(_pick(rows, reaching)):
            c.reach[some] = apply(c.world.take(c.parent[some], axis=0)[:, :, :3], c.translation[some])
    for some in blocks(rows):
        c.world[some, :, 3] = c.world.take(c.parent[some], axis=0)[:, :, 3] + c.reach[some]


def _mark_children(
    h: Hierarchy, level: int, positions: slice | I8, whole: bool, turning: Bool, touch: Bool, turn: Bool
) -> None:
    if whole:
        below = slice(int(h.level_start[level + 1]), int(h.level_start[level + 2]))
        touch[below] = True
        if turning.all():
            turn[below] = True
            return
        if not turning.any():
            return
    where = np.arange(positions.start, positions.stop) if isinstance(positions, slice) else positions
    if not whole:
        touch[h.children(where)] = True
    if turning.any():
        turn[h.children(where[turning])] = True


def apply(linear: F8, v: F8) -> F8:
    """Return linear @ v for [n,3,3] and [n,3]. Written out: numpy has no fast path for batches this small."""
    if len(v) <= _FEW:  # two operations instead of twenty; the sums are the same
        few: F8 = np.add.reduce(linear * v[:, None, :], axis=2)
        return few
    out = np.empty_like(v)
    x, y, z = v[:, 0], v[:, 1], v[:, 2]
    for i in range(3):
        row = linear[:, i, 0] * x
        row += linear[:, i, 1] * y
        row += linear[:, i, 2] * z
        out[:, i] = row
    return out


def _pick(rows: slice | I8, mask: Bool) -> I8:
    if isinstance(rows, slice):
        return int(rows.start) + np.flatnonzero(mask)
    return rows[mask]


def _rows(h: Hierarchy, mask: Bool) -> I8:
    positions = np.flatnonzero(mask)
    return positions if h.is_identity else h.order[positions]
