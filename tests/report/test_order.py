from __future__ import annotations

import numpy as np
import pytest

from engine.core.errors import UsageError
from engine.report.order import fit_order


@pytest.mark.parametrize("order", [0.5, 1.0, 2.0, 4.0, 0.0, -1.0])
def test_exact_powers(order: float) -> None:
    h = 2.0 ** -np.arange(1.0, 8.0)
    fit = fit_order(h, 3.0 * h**order)
    assert fit.slope == pytest.approx(order, abs=1e-12)
    assert fit.constant == pytest.approx(3.0)
    assert fit.residual == pytest.approx(0.0, abs=1e-12)
    assert fit.at(0.1) == pytest.approx(3.0 * 0.1**order)


def test_a_noisy_second_order_is_seen() -> None:
    h = np.geomspace(1e-3, 1.0, 30)
    noise = np.exp(np.random.default_rng(3).normal(0.0, 0.2, 30))
    assert fit_order(h, h**2 * noise).slope == pytest.approx(2.0, abs=0.1)


def test_the_floor_is_left_out() -> None:
    h = 2.0 ** -np.arange(0.0, 10.0)
    floored = np.maximum(h**2, 1e-3)
    assert fit_order(h, floored).slope < 1.6, "with the floor the order looks lower"
    fit = fit_order(h, floored, floor=1e-3)
    assert fit.slope == pytest.approx(2.0)
    assert fit.used == 5


def test_bad_points_do_not_count() -> None:
    assert fit_order([1.0, 0.5, 0.25, 0.0], [1.0, np.nan, 0.0625, 5.0]).slope == pytest.approx(2.0)
    for step, error in (([1.0], [1.0]), ([1.0, 1.0], [1.0, 2.0]), ([1.0, 0.5], [0.0, np.inf])):
        with pytest.raises(UsageError, match="no order"):
            fit_order(step, error)
