"""Known answers of the microfacet terms, and what is left of them where textbook forms break."""

from __future__ import annotations

import math

import numpy as np
import pytest

from engine.math import ggx, microfacet, sheen, thin_film
from engine.math.microfacet import D_TERMS, MASKINGS, MATCHED

EXTREME = np.array([-1.0, -1e-7, 0.0, 1e-12, 1e-6, 0.1, 1.0, 1.0 + 1e-7])


@pytest.mark.parametrize("name", sorted(D_TERMS))
@pytest.mark.parametrize("alpha", [0.002025, 0.05, 0.4, 1.0])
def test_projected_area_is_one(name: str, alpha: float) -> None:
    x, w = np.polynomial.legendre.leggauss(400)
    s, w = (x + 1) / 2, w / 2
    # t = tan^2 = alpha^2 s / (1 - s), as GGX falls: resolves every lobe of that width
    t, dt = alpha**2 * s / (1 - s), alpha**2 / (1 - s) ** 2
    cosine = 1 / np.sqrt(1 + t)
    integral = np.sum(w * D_TERMS[name](cosine, alpha) * cosine * math.pi * dt * cosine**3)
    assert integral == pytest.approx(1.0, rel=2e-3 if alpha < 0.01 else 1e-3)


@pytest.mark.parametrize("name", sorted(D_TERMS))
@pytest.mark.parametrize("alpha", [0.05, 0.4, 1.0])
def test_samples_are_spread_as_the_distribution(name: str, alpha: float) -> None:
    """Of D (n.h), the part within an angle is what quadrature gives; stratified, so that chance has little say."""
    u = np.stack([(np.arange(20000) + 0.5) / 20000, np.zeros(20000)], axis=1)
    h = microfacet.sample_half(name, u, alpha)
    np.testing.assert_allclose(np.linalg.norm(h, axis=1), 1.0, rtol=1e-12)
    x, w = np.polynomial.legendre.leggauss(400)
    for tangent in (0.3 * alpha, alpha, 2.0 * alpha):
        t, dt = tangent**2 * (x + 1) / 2, tangent**2 * w / 2
        cosine = 1 / np.sqrt(1 + t)
        within = np.sum(D_TERMS[name](cosine, alpha) * cosine * math.pi * dt * cosine**3)
        assert np.mean(h[:, 2] >= 1 / math.sqrt(1 + tangent**2)) == pytest.approx(within, abs=2e-4)


def test_peaks_and_exponents() -> None:
    assert microfacet.exponent_of(math.sqrt(2 / (10 + 2))) == pytest.approx(10)
    assert microfacet.D_BlinnPhong(1.0, math.sqrt(2 / 12)) == pytest.approx(12 / (2 * math.pi))
    assert microfacet.D_BlinnPhong(0.0, 1.0) == 0.0
    assert microfacet.D_Beckmann(1.0, 0.1) == pytest.approx(1 / (math.pi * 0.01))
    # the textbook form at 60 degrees
    assert microfacet.D_Beckmann(0.5, 0.5) == pytest.approx(math.exp(-3 / 0.25) / (math.pi * 0.25 / 16))


def test_normalised_blinn_phong_keeps_energy_where_the_common_factor_does_not() -> None:
    """F = 1, implicit masking, normal incidence: (p + 2) / (8 pi) gives 0.717 at p = 10; p + 8 makes light."""
    x, w = np.polynomial.legendre.leggauss(200)
    mu, w = (x + 1) / 2, w / 2
    lobe = 2 * math.pi * np.sum(w * mu * ((1 + mu) / 2) ** 5)  # n.h = cos(theta / 2)
    assert 12 / (8 * math.pi) * lobe == pytest.approx(0.717, abs=1e-3)
    assert 18 / (8 * math.pi) * lobe == pytest.approx(1.075, abs=1e-3)
    alpha = math.sqrt(2 / 12)
    half = np.sqrt((1 + mu) / 2)
    ours = 2 * math.pi * np.sum(w * mu * microfacet.D_BlinnPhong(half, alpha) * microfacet.V_implicit(1.0, mu))
    assert ours == pytest.approx(0.717, abs=1e-3)


def test_fresnel_of_glass_and_of_nothing() -> None:
    assert microfacet.F_dielectric([1.0, 0.0], 0.04) == pytest.approx([0.04, 1.0])
    # Brewster's angle of index 1.5: half of what is reflected across
    c = math.cos(math.atan(1.5))
    assert microfacet.F_dielectric(c, 0.04) == pytest.approx(0.5 * ((1.5**2 - 1) / (1.5**2 + 1)) ** 2)
    assert (microfacet.F_dielectric(EXTREME, 0.0) == 0.0).all(), "an index of 1 reflects nothing"
    for f0 in (0.0, 0.04, 0.5, 1.0):
        f = microfacet.F_dielectric(EXTREME, f0)
        assert ((f >= 0.0) & (f <= 1.0)).all()


def test_fresnel_of_gold() -> None:
    """n = 0.18, k = 3.07 near 600 nm reflect 0.93; through f0 and edge tint the same metal comes back."""
    assert microfacet.F_conductor(1.0, 0.18, 3.07) == pytest.approx((0.82**2 + 3.07**2) / (1.18**2 + 3.07**2))
    assert microfacet.F_conductor(0.0, 0.18, 3.07) == pytest.approx(1.0)
    for f0, tint in ((0.9, 0.2), (0.5, 1.0), (0.04, 0.0)):
        n, k = microfacet.conductor_of(f0, tint)
        assert microfacet.F_conductor(1.0, n, k) == pytest.approx(f0, rel=1e-9)
    n, k = microfacet.conductor_of(0.04, 0.0)
    # without absorption it is the dielectric
    assert k == pytest.approx(0.0, abs=1e-6)
    c = np.linspace(0, 1, 9)
    assert microfacet.F_conductor(c, n, k) == pytest.approx(microfacet.F_dielectric(c, 0.04), abs=1e-9)


@pytest.mark.parametrize("masking", MASKINGS)
def test_masking_at_the_edges(masking: str) -> None:
    v, l, a = (m.ravel() for m in np.meshgrid([0.0, 1e-8, 0.1, 1.0], [0.0, 1e-8, 0.1, 1.0], [1e-6, 0.1, 1.0]))
    value = microfacet.visibility(masking, "beckmann", v, l, 0.9, 0.5, a)
    assert np.isfinite(value).all()
    assert (value >= 0.0).all()
    back = microfacet.visibility(masking, "beckmann", l, v, 0.9, 0.5, a)
    assert value == pytest.approx(back, rel=1e-12), "reciprocity"
    # seen and lit head-on nothing is masked
    assert microfacet.visibility(masking, "ggx", 1.0, 1.0, 1.0, 1.0, 0.3) == pytest.approx(0.25, rel=1e-9)


def test_walter_fits_smith_for_beckmann() -> None:
    c, a = np.meshgrid(np.linspace(0.02, 1.0, 40), [0.1, 0.3, 0.7])
    t = c / (a * np.sqrt(np.maximum(1 - c * c, 1e-30)))
    erf = np.vectorize(math.erf)
    exact = 2 / (1 + erf(t) + np.exp(-(t**2)) / (t * math.sqrt(math.pi)))
    ours = 2 * np.sqrt(microfacet.V_Walter(c, c, a)) * c
    assert np.abs(ours - exact).max() < 4e-3


def test_what_belongs_together() -> None:
    assert "smith" in MATCHED["ggx"]
    assert "walter" not in MATCHED["ggx"]
    assert microfacet.chosen(["distribution_beckmann", "masking_walter"]) == ("beckmann", "walter", "schlick")
    assert microfacet.chosen([]) == ("ggx", "smith", "schlick")


def test_compensation_closes_the_furnace() -> None:
    e = ggx.albedo([0.3, 1.0], [0.3, 0.7])
    assert microfacet.compensation(1.0, e) * e == pytest.approx(1.0)
    assert microfacet.compensation(0.0, e) == pytest.approx(1.0)


def test_sheen() -> None:
    x, w = np.polynomial.legendre.leggauss(400)
    c, w = (x + 1) / 2, w / 2
    for alpha in (0.05, 0.3, 1.0):
        # the distribution's own normalisation: int D cos = 1
        assert 2 * math.pi * np.sum(w * sheen.D_Charlie(c, alpha) * c) == pytest.approx(1.0, rel=1e-3)
    assert np.isfinite(sheen.V_Charlie([0.0, 0.0, 1.0], [0.0, 1.0, 1.0], [0.0, 0.5, 1.0])).all()
    assert (sheen.albedo([0.3, 0.6, 1.0], [0.1, 0.5, 1.0]) <= 1.0).all()


def test_no_film_changes_nothing_and_a_film_shows_colours() -> None:
    f0 = np.array([0.04, 0.3, 0.9])
    plain = thin_film.fresnel(1.3, [0.2, 0.7, 1.0], 0.0, f0)
    assert plain == pytest.approx(ggx.F_Schlick(np.array([[0.2], [0.7], [1.0]]), f0), abs=2e-3)
    film = thin_film.fresnel(1.33, 1.0, [300.0, 400.0, 500.0], np.full(3, 0.5))
    assert (film.max(axis=1) - film.min(axis=1) > 0.1).all()
    assert ((film >= 0) & (film <= 1)).all()
