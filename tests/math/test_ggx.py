from __future__ import annotations

import math

import numpy as np
import pytest

from engine.math import ggx, sphere

VIEW = np.array([0.02, 0.1, 0.3, 0.7, 1.0])
ROUGHNESS = np.array([0.045, 0.1, 0.3, 0.5, 0.8, 1.0])


@pytest.mark.parametrize("alpha", [0.002025, 0.01, 0.1, 0.5, 1.0])
def test_projected_area_of_D_is_one(alpha: float) -> None:
    # int D(n.h) n.h dw = 1; in t = tan(theta)^2 the integrand is smooth: substitute t = a^2 s / (1 - s)
    x, w = np.polynomial.legendre.leggauss(200)
    s, w = (x + 1) / 2, w / 2
    t = alpha**2 * s / (1 - s)
    cosine = 1 / np.sqrt(1 + t)
    dt = alpha**2 / (1 - s) ** 2
    integral = np.sum(w * ggx.D_GGX(cosine, alpha) * cosine * math.pi * dt * cosine**3)
    assert integral == pytest.approx(1.0, rel=1e-5)


def test_D_known_values() -> None:
    assert ggx.D_GGX(1.0, 1.0) == pytest.approx(1 / math.pi)
    assert ggx.D_GGX(0.3, 1.0) == pytest.approx(1 / math.pi)
    assert ggx.D_GGX(1.0, 0.01) == pytest.approx(1e4 / math.pi)
    assert ggx.D_GGX(-0.1, 0.5) == 0.0


def test_D_matches_walters_form() -> None:
    c, a = np.linspace(0.05, 0.999, 50), 0.2
    tan2 = (1 - c * c) / (c * c)
    assert np.allclose(ggx.D_GGX(c, a), a * a / (math.pi * c**4 * (a * a + tan2) ** 2))


def test_V_is_G2_over_4_and_symmetric() -> None:
    v, l = np.meshgrid(VIEW, VIEW)
    a = 0.3

    def smith_lambda(c: np.ndarray) -> np.ndarray:
        return (-1 + np.sqrt(1 + a * a * (1 - c * c) / (c * c))) / 2

    g2 = 1 / (1 + smith_lambda(v) + smith_lambda(l))
    assert np.allclose(ggx.V_SmithGGXCorrelated(v, l, a), g2 / (4 * v * l))
    assert np.array_equal(ggx.V_SmithGGXCorrelated(v, l, a), ggx.V_SmithGGXCorrelated(l, v, a))
    assert np.allclose(ggx.G1_Smith(VIEW, a), 1 / (1 + smith_lambda(VIEW)))


def test_grazing_and_negative_cosines_are_finite() -> None:
    grid = np.array([-1.0, 0.0, 1e-8, 1e-4, 1.0])
    v, l = np.meshgrid(grid, grid)
    for alpha in (0.0, 1e-8, 0.002, 1.0):
        assert np.isfinite(ggx.V_SmithGGXCorrelated(v, l, alpha)).all()


@pytest.mark.parametrize("v_dot_h", [-1.0, -1e-7, 0.0, 0.5, 1.0, 1.0 + 1e-7])
def test_schlick_stays_between_f0_and_one(v_dot_h: float) -> None:
    assert 0.04 <= ggx.F_Schlick(v_dot_h, 0.04) <= 1.0
    assert ggx.F_Schlick(0.0, 0.04) == 1.0
    assert ggx.F_Schlick(0.5, 0.04) == pytest.approx(0.04 + 0.96 / 32)


def test_furnace_alpha_one_at_normal_incidence_keeps_1_minus_ln_2() -> None:
    assert ggx.albedo(1.0, 1.0) == pytest.approx(1 - math.log(2), abs=1e-10)


def test_single_scattering_never_gains_energy() -> None:
    e = ggx.albedo(ROUGHNESS[:, None], VIEW)
    assert (e <= 1.0 + 1e-9).all()
    assert (np.diff(e[:, -1]) < 0).all(), "at normal incidence rougher loses more"


def test_compensation_restores_a_white_furnace() -> None:
    e = ggx.environment_brdf(1.0, ROUGHNESS[:, None], VIEW)
    assert np.allclose(e, 1.0, atol=1e-12)
    coloured = ggx.environment_brdf(0.5, ROUGHNESS[:, None], VIEW)
    assert (coloured < 1.0).all()
    single, multiple = ggx.multiple_scattering(0.5, ggx.dfg(1.0, 0.7))
    assert multiple > 0.1 * single


@pytest.mark.parametrize("roughness", [0.3, 0.6, 1.0])
@pytest.mark.parametrize("mu", [0.1, 0.5, 0.95])
def test_dfg_against_importance_sampling(roughness: float, mu: float) -> None:
    alpha = roughness**2
    view = np.array([math.sqrt(1 - mu * mu), 0, mu])
    u = sphere.hammersley(1 << 16)
    for sample in (ggx.sample_half, ggx.sample_visible_half):
        h = sample(u, alpha) if sample is ggx.sample_half else ggx.sample_visible_half(u, view, alpha)
        vh = h @ view
        nl = 2 * vh * h[:, 2] - mu
        up = (nl > 0) & (vh > 0)
        nl = np.where(up, nl, 1.0)
        v = ggx.V_SmithGGXCorrelated(mu, nl, alpha)
        if sample is ggx.sample_half:
            weight = 4 * v * nl * vh / h[:, 2]
        else:
            weight = v * 4 * nl * mu / ggx.G1_Smith(mu, alpha)
        weight = np.where(up, weight, 0.0)
        fresnel = (1 - np.clip(vh, 0, 1)) ** 5
        expected = [(weight * (1 - fresnel)).mean(), (weight * fresnel).mean()]
        assert ggx.dfg(roughness, mu) == pytest.approx(expected, abs=2e-3)


def test_dfg_is_converged() -> None:
    r, mu = np.meshgrid(ROUGHNESS, [0.1, 0.4, 1.0])
    assert np.allclose(ggx.dfg(r, mu), ggx.dfg(r, mu, order=192), atol=1e-5)
    assert np.allclose(ggx.dfg(ROUGHNESS, 0.02), ggx.dfg(ROUGHNESS, 0.02, order=192), atol=3e-4)
