"""Topology: strips, fans and loops become lists of triangles and lines.

Source: glTF 2.0 specification (Khronos, 2021), section 3.7.2.1 (topology types and their vertex order).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Indices = NDArray[np.uint32]

#: glTF primitive mode -> (name, topology it ends as, least number of indices)
MODES = {
    0: ("points", "points", 1),
    1: ("lines", "lines", 2),
    2: ("line loop", "lines", 2),
    3: ("line strip", "lines", 2),
    4: ("triangles", "triangles", 3),
    5: ("triangle strip", "triangles", 3),
    6: ("triangle fan", "triangles", 3),
}


def to_list(indices: Indices, mode: int) -> Indices:
    """u4[m] indices of any mode as a plain list: points, pairs of lines, or triples of triangles; the rest is cut.

    Winding is kept: every second triangle of a strip is turned round.
    """
    count = len(indices)
    if count < MODES[mode][2]:
        return indices[:0]
    if mode == 1:
        return indices[: count // 2 * 2]
    if mode in (2, 3):
        ends = np.roll(indices, -1) if mode == 2 else indices[1:]
        return np.stack([indices[: len(ends)], ends], 1).reshape(-1)
    if mode == 4:
        return indices[: count // 3 * 3]
    if mode == 5:
        # p_i = {v_i, v_(i + 1 + i % 2), v_(i + 2 - i % 2)}
        i = np.arange(count - 2)
        return indices[np.stack([i, i + 1 + i % 2, i + 2 - i % 2], 1)].reshape(-1)
    if mode == 6:
        # p_i = {v_(i + 1), v_(i + 2), v_0}
        i = np.arange(count - 2)
        return indices[np.stack([i + 1, i + 2, np.zeros_like(i)], 1)].reshape(-1)
    return indices


def zero_area(positions: NDArray[np.float32], triangles: Indices) -> NDArray[np.bool_]:
    """bool[t]: whether a triangle of u4[t,3] has no area, to the precision of its own size.

    |e1 x e2| <= 1e-7 |longest edge|^2 (float64): thinner than float32 positions can say.
    """
    a, b, c = (positions[triangles[:, k]].astype(np.float64) for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    longest = np.maximum(np.maximum(_squared(b - a), _squared(c - b)), _squared(a - c))
    return np.asarray(area <= 1e-7 * longest)


def _squared(v: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(np.einsum("ij,ij->i", v, v))
