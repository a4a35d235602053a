"""Linearly transformed cosines: polygons with known form factors, and a fit that is near the lobe it stands for."""

from __future__ import annotations

import math

import numpy as np
import pytest

from engine.assets.dds import read_dds
from engine.core.paths import shaders_dir
from engine.math import ggx, ltc


def rectangle(center: tuple[float, ...], right: tuple[float, ...], up: tuple[float, ...]) -> np.ndarray:
    c, x, y = (np.array(v, float) for v in (center, right, up))
    return np.stack([c + x + y, c - x + y, c - x - y, c + x - y])


def test_known_form_factors() -> None:
    above = ltc.form_factor(rectangle((0, 0, 1), (1e6, 0, 0), (0, 1e6, 0)))
    assert above == pytest.approx(1.0, abs=1e-5), "the whole sky"
    wall = ltc.form_factor(rectangle((1, 0, 0), (0, 1e6, 0), (0, 0, 1e6)))
    assert wall == pytest.approx(0.5, abs=1e-5), "half of it, the other half below the horizon"
    a = 0.5  # a square of width 2a at height 1: Howell, configuration factor B-3, four times
    corner = 2.0 * a / math.sqrt(1 + a * a) * math.atan(a / math.sqrt(1 + a * a)) / (2 * math.pi)
    assert ltc.form_factor(rectangle((0, 0, 1), (a, 0, 0), (0, a, 0))) == pytest.approx(4 * corner, rel=1e-12)
    assert ltc.form_factor(rectangle((0, 0, -1), (a, 0, 0), (0, a, 0))) == 0.0
    turned = ltc.form_factor(rectangle((0, 0, 1), (-a, 0, 0), (0, a, 0)))
    assert turned == pytest.approx(-4 * corner), "the other way round: seen from behind"


def test_clipping_is_that_of_the_polygon_cut_by_hand() -> None:
    whole = rectangle((1, 0.3, 0.2), (0, 1, 0), (0, 0, 1))
    cut = rectangle((1, 0.3, 0.6), (0, 1, 0), (0, 0, 0.6))
    assert ltc.form_factor(whole) == pytest.approx(ltc.form_factor(cut), rel=1e-9)


@pytest.mark.parametrize("points", [np.zeros((4, 3)), np.ones((4, 3)), rectangle((0, 0, 0), (1, 0, 0), (0, 1, 0))])
def test_what_has_no_extent_gives_nothing(points: np.ndarray) -> None:
    assert ltc.form_factor(points) == pytest.approx(0.0, abs=1e-12)


def test_density_is_one_over_the_sphere() -> None:
    inverse = ltc.matrix_of([0.6, 0.4, -0.1, 0.5])
    z = (np.arange(400) + 0.5) / 200 - 1
    phi = (np.arange(400) + 0.5) / 400 * 2 * np.pi
    z, phi = np.meshgrid(z, phi)
    ring = np.sqrt(1 - z * z)
    w = np.stack([ring * np.cos(phi), ring * np.sin(phi), z], -1)
    assert ltc.density(inverse, w).sum() * 4 * np.pi / 400**2 == pytest.approx(1.0, abs=1e-4)


def test_a_fit_is_near_its_lobe() -> None:
    """The same for every run; half the area between both densities, and what sinks below the horizon."""
    table = ltc.fit_table(4)
    assert np.isfinite(table).all()
    roughness, mu = float(ltc.rows(4)[2]), float(ltc.columns(4)[1])
    z, phi = np.meshgrid((np.arange(200) + 0.5) / 200, (np.arange(400) + 0.5) / 400 * 2 * np.pi)
    ring, v, alpha = np.sqrt(1 - z * z), np.array([math.sqrt(1 - mu * mu), 0.0, mu]), roughness**2
    l = np.stack([ring * np.cos(phi), ring * np.sin(phi), z], -1)
    h = (l + v) / np.linalg.norm(l + v, axis=-1, keepdims=True)
    lobe = ggx.D_GGX(h[..., 2], alpha) * ggx.V_SmithGGXCorrelated(mu, z, alpha) * z
    fitted = ltc.density(ltc.look_up(table, roughness, mu), l)
    cell = 2 * np.pi / (200 * 400)
    assert lobe.sum() * cell == pytest.approx(float(ggx.albedo(roughness, mu)), rel=1e-3)
    assert 0.5 * np.abs(lobe / (lobe.sum() * cell) - fitted).sum() * cell < 0.03
    assert fitted.sum() * cell > 0.99


def test_the_shipped_table_is_this_fit() -> None:
    """A corner of it, made anew: packaging/make_ltc.py makes the whole."""
    asset = read_dds(shaders_dir() / "data" / "ltc.dds")
    shipped = np.frombuffer(asset.levels[0][0], "<f2").reshape(asset.height, asset.width, 4).astype(float)
    some = [12, 50]
    made = ltc.fit_rows(ltc.rows(asset.height)[some], ltc.columns(asset.width)[:5])
    assert np.abs(made - shipped[some, :5]).max() < 1e-3
