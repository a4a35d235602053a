"""Practical splits: known answers, and ranges that would divide by zero."""

from __future__ import annotations

import math

import numpy as np
import pytest

from engine.render.shadows.splits import practical_splits


def test_ends_are_exact_and_half_of_each_is_their_mean() -> None:
    logarithmic = practical_splits(1.0, 81.0, 4, 1.0)
    even = practical_splits(1.0, 81.0, 4, 0.0)
    assert logarithmic == pytest.approx([1, 3, 9, 27, 81])
    assert even == pytest.approx([1, 21, 41, 61, 81])
    assert practical_splits(1.0, 81.0, 4, 0.5) == pytest.approx((logarithmic + even) / 2)
    assert practical_splits(0.3, 7.1, 3, 0.37)[[0, -1]].tolist() == [0.3, 7.1]


def test_a_range_that_no_view_should_have_and_the_same_clamped() -> None:
    """Near 1 mm, far 1000 km: the even part would put the first cut at 125 km, or at 12.5 km; as little of it as such a
    range gets, it lies within a metre. Within 0.5 to 500 m it is 8.9 m."""
    assert 0.17 < practical_splits(1e-3, 1e6, 4, 0.5)[1] < 1.0
    assert 0.17 < practical_splits(1e-3, 1e6, 4, 0.95)[1] < 1.0
    assert practical_splits(0.5, 500.0, 4, 0.95)[1:] == pytest.approx([8.9, 27.5, 103, 500], rel=0.01)


@pytest.mark.parametrize("count", [1, 2, 3, 8])
@pytest.mark.parametrize("weight", [0.0, 0.5, 0.8, 1.0])
@pytest.mark.parametrize(
    ("near", "far"),
    [
        (1.0, 1.0), (1.0, 1.0 + 1e-12), (2.0, 1.0), (0.0, 0.0), (-1.0, 5.0), (1e-9, 1e12), (1e-30, 1e30), (1e6, 1e6),
        (math.nan, 1.0), (1.0, math.nan), (1.0, math.inf),
    ],
)  # fmt: skip
def test_cuts_rise_strictly_whatever_the_range(near: float, far: float, weight: float, count: int) -> None:
    cuts = practical_splits(near, far, count, weight)
    assert cuts.shape == (count + 1,)
    assert np.isfinite(cuts).all()
    assert (np.diff(cuts) > 0.0).all()
