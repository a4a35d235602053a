"""How the atlas of local shadows is divided: which lights get tiles, how wide, and where. Equal input, equal tiles.

A light's importance on the screen is s = reach / distance from the camera, at most 1: about the part of the picture's
height that what it lights can fill. It does not ask where the camera looks, so turning the camera moves no tile; and
it is rounded to powers of two, so that walking seldom does. Brightness x s^2 decides who gives way when the atlas is
full: the least important tiles are halved first, and at MIN_TILE the least important lights go without shadow.

Widths are powers of two, so that laying them out from wide to narrow along a Morton curve leaves no gap (Morton 1966):
whatever fits by area fits.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

#: texels; a narrower map shows nothing of use
MIN_TILE = 32


@dataclass(frozen=True, slots=True)
class Tiles:
    """`width` i8[n]: texels of each light's tiles, 0 = none; `corner` i8[n,6,2]: left and top of each (a light with one
    tile has the first)."""

    width: NDArray[np.int64]
    corner: NDArray[np.int64]


def divide(
    share: NDArray[np.float64], weight: NDArray[np.float64], faces: NDArray[np.int64], atlas: int, most: int
) -> Tiles:
    """Tiles of lights: `share` f8[n] in (0, 1] of the widest tile (half the atlas for one face, a quarter for six),
    `weight` f8[n]: who gives way last, `faces` i8[n]: 1 or 6. `atlas`: its width, a power of two; `most` lights."""
    n = len(share)
    width = np.zeros(n, np.int64)
    order = np.argsort(-weight, kind="stable")[: max(most, 0)]  # from the most important
    widest = np.where(faces > 1, atlas // 4, atlas // 2)
    steps = np.ceil(-np.log2(np.clip(share, 1e-9, 1.0)) - 1e-9).astype(np.int64)
    least = min(MIN_TILE, atlas)
    width[order] = np.maximum(widest[order] >> np.minimum(steps[order], 40), least)
    while len(order) and _area(width, faces) > atlas * atlas:
        top = width.max()
        if top <= least:
            width[order[-1]], order = 0, order[:-1]
            continue
        for i in order[::-1]:  # one step for the widest ones, from the least important
            if width[i] == top:
                width[i] //= 2
                if _area(width, faces) <= atlas * atlas:
                    break
    return Tiles(width, _corners(width, faces))


def _area(width: NDArray[np.int64], faces: NDArray[np.int64]) -> int:
    return int((width * width * faces).sum())


def _corners(width: NDArray[np.int64], faces: NDArray[np.int64]) -> NDArray[np.int64]:
    corner = np.zeros((len(width), 6, 2), np.int64)
    used = np.flatnonzero(width)
    if len(used) == 0:
        return corner
    unit = int(width[used].min())
    light = np.repeat(used, faces[used])
    face = np.concatenate([np.arange(k) for k in faces[used]])
    order = np.argsort(-width[light], kind="stable")
    cells = (width[light[order]] // unit) ** 2
    at = np.cumsum(cells) - cells
    x, y = np.zeros_like(at), np.zeros_like(at)
    for bit in range(16):
        x |= ((at >> (2 * bit)) & 1) << bit
        y |= ((at >> (2 * bit + 1)) & 1) << bit
    corner[light[order], face[order]] = np.stack([x, y], axis=1) * unit
    return corner
