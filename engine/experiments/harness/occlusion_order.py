"""Which order the error of occlusion has in the number of places, on a wall whose occlusion is known.

What depth does not show is left out here: places are on the disc below the hemisphere, each sees or does not.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.experiments.truth.visibility import disc_points

F8 = NDArray[np.float64]

COUNTS = (8, 16, 32, 64, 128, 256)
#: patterns of each count, turned or drawn at random
TRIES = 400
#: of a wall of height 1
DISTANCES = (0.2, 0.5, 1.0)


def errors(*, spiral: bool) -> list[float]:
    """rmse for each of COUNTS: places on Vogel's spiral, or at random."""
    rng, found = np.random.default_rng(1), []
    for count in COUNTS:
        points = disc_points(count, 2.0 * np.pi * rng.random(TRIES)) if spiral else _at_random(count, rng)
        off = [_open_part(points, d, 1.0) - (1.0 + d / np.hypot(d, 1.0)) / 2.0 for d in DISTANCES]
        found.append(float(np.sqrt(np.mean(np.square(off)))))
    return found


def slope(found: list[float]) -> float:
    """Of the logarithms, over COUNTS."""
    return float(np.polyfit(np.log(COUNTS), np.log(found), 1)[0])


def _open_part(points: F8, d: float, height: float) -> F8:
    """Part f8[k] of cosine-weighted directions, points [k,n,2] of the disc below them (Nusselt 1928), that pass over an
    endless wall of that height at distance d."""
    x, y = points[..., 0], points[..., 1]
    up = np.sqrt(np.maximum(1.0 - x * x - y * y, 0.0))
    found: F8 = 1.0 - ((x > 0.0) & (d * up < height * x)).mean(axis=-1)
    return found


def _at_random(count: int, rng: np.random.Generator) -> F8:
    radius, angle = np.sqrt(rng.random((TRIES, count))), 2.0 * np.pi * rng.random((TRIES, count))
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)
