from __future__ import annotations

import math

import numpy as np
import pytest

from engine.core.errors import InputError
from engine.math import tonemap

NAMES = tuple(tonemap.TONE_MAPS)
GREY = np.ones(3)


@pytest.mark.parametrize("name", NAMES)
def test_black_is_black_and_everything_is_in_range(name: str) -> None:
    tone = tonemap.TONE_MAPS[name]
    assert np.abs(tone(np.zeros(3))).max() < 1e-5
    rng = np.random.default_rng(2)
    out = tone(10.0 ** rng.uniform(-6, 6, size=(5000, 3)))
    assert ((out >= 0) & (out <= 1 + 1e-9)).all()


@pytest.mark.parametrize("name", NAMES)
def test_greys_rise_monotonically_and_stay_grey(name: str) -> None:
    out = tonemap.TONE_MAPS[name](np.geomspace(1e-3, 1e3, 400)[:, None] * GREY)
    assert (np.diff(out[:, 1]) >= -2e-4).all()
    assert np.abs(out - out.mean(axis=1, keepdims=True)).max() < 2e-3


@pytest.mark.parametrize("name", NAMES)
def test_nonsense_is_defined(name: str) -> None:
    out = tonemap.TONE_MAPS[name]([[math.nan, -1, 0], [math.inf, math.inf, math.inf], [-math.inf, 0, 0]])
    assert np.isfinite(out).all()
    assert out[1].min() > 0.9


def test_neutral_known_values() -> None:
    # below the bend only the 0.04 offset is taken off (f90 offset), in the toe x - 6.25 x^2
    assert np.allclose(tonemap.neutral([0.5, 0.4, 0.3]), [0.46, 0.36, 0.26])
    assert np.allclose(tonemap.neutral([0.04] * 3), [6.25 * 0.04**2] * 3)
    assert np.allclose(tonemap.neutral([0.8] * 3), [0.76] * 3)
    # white 1: peak 0.96 -> 1 - 0.24^2 / (0.96 + 0.24 - 0.76)
    assert np.allclose(tonemap.neutral([1.0] * 3), 1 - 0.24**2 / 0.44)
    # a bright red bleaches: peak p, g = 1 - 1 / (0.15 (p - p') + 1)
    p = 10.0
    bent = 1 - 0.24**2 / (p + 0.24 - 0.76)
    g = 1 - 1 / (0.15 * (p - bent) + 1)
    assert np.allclose(tonemap.neutral([p, 0.0, 0.0]), [bent, bent * g, bent * g])


def test_neutral_is_continuous_at_the_bend() -> None:
    assert np.allclose(tonemap.neutral([0.8 - 1e-9, 0.2, 0.2]), tonemap.neutral([0.8 + 1e-9, 0.2, 0.2]), atol=1e-8)


def test_agx_matrices_undo_each_other() -> None:
    assert np.allclose(tonemap.AGX_INSET.sum(axis=1), 1.0, atol=5e-3)
    assert np.allclose(tonemap.AGX_OUTSET @ tonemap.AGX_INSET, np.eye(3), atol=2e-3)


def test_agx_curve_fits_the_sigmoid() -> None:
    # Sobotka's curve: slope 2 at the pivot (10 / 16.5, 0.5), power 3 in the toe and 3.25 in the shoulder
    x = np.linspace(0.0, 1.0, 200)
    pivot_x, pivot_y, slope = 10 / 16.5, 0.5, 2.0

    def scale(px: float, py: float, power: float) -> float:
        return float(((slope * px) ** -power * ((slope * px / py) ** power - 1)) ** (-1 / power))

    def bend(distance: np.ndarray, size: float, power: float) -> np.ndarray:
        t = slope * distance / size
        return size * t / (1 + t**power) ** (1 / power)

    below = np.maximum(pivot_x - x, 0)
    above = np.maximum(x - pivot_x, 0)
    exact = (
        pivot_y
        - bend(below, scale(pivot_x, pivot_y, 3.0), 3.0)
        + bend(above, scale(1 - pivot_x, 1 - pivot_y, 3.25), 3.25)
    )
    assert np.abs(np.polyval(tonemap.AGX_CURVE, x) - exact).max() < 0.01


def test_agx_middle_grey() -> None:
    # 0.18 sits at the pivot, which the curve sends to 0.5 on a 2.2 display
    assert tonemap.agx(0.18 * GREY) == pytest.approx(0.5**2.2, abs=0.01)


def test_aces_known_values() -> None:
    # a grey v passes both matrices nearly unchanged: the rational fit of v itself
    fit = (0.18 * (0.18 + 0.0245786) - 0.000090537) / (0.18 * (0.983729 * 0.18 + 0.4329510) + 0.238081)
    assert tonemap.aces(0.18 * GREY) == pytest.approx(fit, rel=1e-3)
    assert np.allclose(tonemap.ACES_IN.sum(axis=1), 1.0, atol=1e-4)
    assert np.allclose(tonemap.ACES_OUT.sum(axis=1), 1.0, atol=1e-4)


def test_apply_by_name() -> None:
    assert np.allclose(tonemap.apply("none", [0.1, 0.2, 0.3], exposure=1.0), [0.2, 0.4, 0.6])
    with pytest.raises(InputError, match="filmic"):
        tonemap.apply("filmic", [0, 0, 0])
