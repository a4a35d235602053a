from __future__ import annotations

import math

import numpy as np
import pytest

from engine.report.front import gain, pareto_front


def test_known_front() -> None:
    cost = [1.0, 2.0, 3.0, 2.0, 4.0]
    error = [9.0, 4.0, 5.0, 4.0, 1.0]
    assert pareto_front(cost, error).tolist() == [True, True, False, True, True]


def test_what_is_not_finite_is_never_on_the_front() -> None:
    assert pareto_front([1.0, 2.0, math.nan], [math.inf, 1.0, 0.0]).tolist() == [False, True, False]
    assert pareto_front([], []).tolist() == []


def test_one_better_point_takes_all() -> None:
    rng = np.random.default_rng(1)
    cost, error = rng.uniform(1.0, 2.0, (2, 50))
    assert pareto_front([*cost, 0.5], [*error, 0.5]).tolist() == [False] * 50 + [True]


def test_no_point_of_the_front_beats_another_and_each_other_is_beaten() -> None:
    rng = np.random.default_rng(2)
    cost, error = rng.uniform(size=(2, 200))
    front = pareto_front(cost, error)
    for i in range(200):
        beaten = ((cost <= cost[i]) & (error < error[i])) | ((cost < cost[i]) & (error <= error[i]))
        assert beaten.any() != front[i]


def test_gain_is_error_removed_per_cost() -> None:
    got = gain([1.0, 2.0, 5.0, 3.0], [10.0, 4.0, 1.0, 6.0])
    assert got[1] == pytest.approx(6.0)
    assert got[2] == pytest.approx(1.0)
    assert np.isnan(got[[0, 3]]).all()
