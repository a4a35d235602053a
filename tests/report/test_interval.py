from __future__ import annotations

import numpy as np
import pytest

from engine.core.errors import UsageError
from engine.report.interval import ratio_interval


def test_equal_samples_give_one() -> None:
    got = ratio_interval([2.0] * 9, [2.0] * 9)
    assert (got.value, got.low, got.high) == (1.0, 1.0, 1.0)
    assert got.to_json() == {"value": 1.0, "low": 1.0, "high": 1.0, "confidence": 0.95}


def test_a_clear_difference_excludes_one() -> None:
    rng = np.random.default_rng(1)
    got = ratio_interval(list(rng.normal(2.0, 0.05, 30)), list(rng.normal(1.0, 0.05, 25)))
    assert got.low < 2.0 < got.high
    assert got.low > 1.8


def test_covers_the_truth_about_as_often_as_it_says() -> None:
    rng = np.random.default_rng(2)
    hits = 0
    for i in range(100):
        a, b = np.exp(rng.normal(0.0, 0.3, (2, 31)))
        got = ratio_interval(list(a), list(b), seed=i, resamples=400)
        hits += got.low <= 1.0 <= got.high
    assert hits >= 88


def test_a_disturbance_of_both_does_not_widen_it() -> None:
    common = np.exp(np.random.default_rng(3).normal(0.0, 0.5, 31))
    paired = ratio_interval(list(2.0 * common), list(common))
    assert paired.low == pytest.approx(2.0)
    assert paired.high == pytest.approx(2.0)


def test_few_samples_are_not_trusted() -> None:
    """Five runs that happen to agree prove little: the interval is all that was seen."""
    got = ratio_interval([1.0, 1.1, 1.2, 1.1, 1.0], [2.0, 2.2, 4.0, 2.1, 2.0])
    assert (got.low, got.high) == (pytest.approx(0.25), pytest.approx(0.6))
    assert got.value == pytest.approx(1.1 / 2.1)


def test_none_is_an_error() -> None:
    with pytest.raises(UsageError, match="no samples"):
        ratio_interval([], [1.0])
