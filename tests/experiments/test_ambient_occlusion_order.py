"""The spiral of places against places at random, on a wall whose occlusion is known: which order their error has."""

from __future__ import annotations

import pytest

from engine.experiments.harness.occlusion_order import errors, slope


def test_places_at_random_have_order_one_half_and_the_spiral_three_quarters() -> None:
    random, better = errors(spiral=False), errors(spiral=True)
    assert slope(random) == pytest.approx(-0.5, abs=0.05)
    assert slope(better) == pytest.approx(-0.75, abs=0.1)
    assert all(b < 0.7 * a for a, b in zip(random, better, strict=True))
