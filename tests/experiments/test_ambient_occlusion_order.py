"""The spiral of places against places at random, on a wall whose occlusion is known: which order their error has."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.experiments.truth.visibility import disc_points

F8 = NDArray[np.float64]
COUNTS = (8, 16, 32, 64, 128, 256)
TRIES = 400


def open_part(points: F8, d: float, height: float) -> F8:
    """Part f8[k] of cosine-weighted directions, points [k,n,2] of the disc below them (Nusselt 1928), that pass over an
    endless wall of that height at distance d."""
    x, y = points[..., 0], points[..., 1]
    up = np.sqrt(np.maximum(1.0 - x * x - y * y, 0.0))
    found: F8 = 1.0 - ((x > 0.0) & (d * up < height * x)).mean(axis=-1)
    return found


def at_random(count: int, rng: np.random.Generator) -> F8:
    radius, angle = np.sqrt(rng.random((TRIES, count))), 2.0 * np.pi * rng.random((TRIES, count))
    return np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)


def slope(spiral: bool) -> tuple[float, list[float]]:
    rng, errors = np.random.default_rng(1), []
    for count in COUNTS:
        points = disc_points(count, 2.0 * np.pi * rng.random(TRIES)) if spiral else at_random(count, rng)
        off = [open_part(points, d, 1.0) - (1.0 + d / np.hypot(d, 1.0)) / 2.0 for d in (0.2, 0.5, 1.0)]
        errors.append(float(np.sqrt(np.mean(np.square(off)))))
    return float(np.polyfit(np.log(COUNTS), np.log(errors), 1)[0]), errors


def test_places_at_random_have_order_one_half_and_the_spiral_three_quarters() -> None:
    random, errors = slope(False)
    spiral, better = slope(True)
    assert random == pytest.approx(-0.5, abs=0.05)
    assert spiral == pytest.approx(-0.75, abs=0.1)
    assert all(b < 0.7 * a for a, b in zip(errors, better, strict=True))
