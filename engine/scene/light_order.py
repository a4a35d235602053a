"""One order for a set of lights, whatever order they are stored in: sums made in it have the same bits.

Along a Morton curve (Morton 1966, "A Computer Oriented Geodetic Data Base"), so that neighbours in the list are
neighbours in space, which hierarchies and clusters live on; among equal positions by all other values.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

#: bits of a Morton code per axis
_BITS = 20
#: what tells lights apart besides where they are, in the order in which it counts
_VALUES = (
    "type", "range", "radiant", "direction", "right", "half_size", "cos_inner", "cos_outer", "two_sided", "profile",
    "casts_shadow", "position",
)  # fmt: skip


def canonical_order(world: NDArray[np.void]) -> NDArray[np.int64]:
    """Return i8[n]: the rows of WORLD_LIGHT in the order that depends on their values alone, not on the rows' order."""
    codes = _morton(world["position"])
    order = np.argsort(codes, kind="stable")
    ordered = codes[order]
    same = ordered[1:] == ordered[:-1]
    if same.any():
        tied = np.append(same, False) | np.insert(same, 0, False)
        rows = order[tied]
        keys = [column for name in reversed(_VALUES) for column in _columns(world[name][rows])]
        order[tied] = rows[np.lexsort([*keys, codes[rows]])]
    return order


def _morton(position: NDArray[np.float64]) -> NDArray[np.uint64]:
    if len(position) == 0:
        return np.zeros(0, np.uint64)
    low = position.min(axis=0)
    extent = float((position.max(axis=0) - low).max())
    scale = (2**_BITS - 1) / extent if 0.0 < extent < np.inf else 0.0
    cells = ((position - low) * scale).astype(np.uint64)
    code = np.zeros(len(position), np.uint64)
    for axis in range(3):
        code |= _spread(cells[:, axis]) << np.uint64(axis)
    return code


def _spread(x: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """Return each of the low 21 bits of `x` at three times its place."""
    for shift, mask in (
        (32, 0x1F00000000FFFF),
        (16, 0x1F0000FF0000FF),
        (8, 0x100F00F00F00F00F),
        (4, 0x10C30C30C30C30C3),
        (2, 0x1249249249249249),
    ):
        x = (x | (x << np.uint64(shift))) & np.uint64(mask)
    return x


def _columns(values: NDArray[np.generic]) -> list[NDArray[np.generic]]:
    """Return [k, ...] as columns [k], the last first, as lexsort wants them."""
    return list(values.reshape(len(values), -1).T[::-1])
