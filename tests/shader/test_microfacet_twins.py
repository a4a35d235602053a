"""shaders/lib/microfacet.glsl, sheen.glsl, thin_film.glsl against their float64 twins, and at their ends."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.experiments.harness.shader_eval import ShaderEval
from engine.gpu.types import Device
from engine.math import microfacet, sheen, thin_film

pytestmark = pytest.mark.gl
N = 2048
LOBE = {"alpha": "float", "n": "vec3", "h": "vec3"}
ANGLES = {"alpha": "float", "nv": "float", "nl": "float"}


@pytest.fixture
def shaders(gl_device: Device) -> ShaderEval:
    return ShaderEval(gl_device)


def run(shaders: ShaderEval, expression: str, inputs: dict[str, str], output: str = "float", **arrays: Any) -> Any:
    include = ["lib/microfacet.glsl", "lib/sheen.glsl", "lib/thin_film.glsl"]
    return shaders.kernel(expression, inputs, output, include=include)(**arrays)


def tilted(theta: NDArray[np.float64]) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float64]]:
    """n, h at that angle about +Z, and the exact cosine of the rounded vectors."""
    phi = np.random.default_rng(2).uniform(0, 2 * math.pi, len(theta))
    h = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1).astype(np.float32)
    w = h.astype(np.float64)
    n = np.tile(np.array([0, 0, 1], np.float32), (len(theta), 1))
    return n, h, w[:, 2] / np.linalg.norm(w, axis=1)


@pytest.mark.parametrize("name", ["Beckmann", "BlinnPhong"])
@pytest.mark.parametrize("alpha", [0.002025, 0.0142, 0.1, 0.5, 1.0])
def test_distributions(shaders: ShaderEval, name: str, alpha: float) -> None:
    """Within 1e-3 where D is above a thousandth of its peak; down there an alpha of 0.002 is an exponent of 500,000."""
    u = np.linspace(0, 0.999, N)
    n, h, cosine = tilted(np.arctan(alpha * np.sqrt(-np.log(1 - u))))
    a = np.full(N, alpha, np.float32)
    got = run(shaders, f"D_{name}(alpha, dot(n, h), n, h)", LOBE, alpha=a, n=n, h=h)
    # the twin takes the cosine, which has no digits left near 1 for the narrowest lobe: sin^2 from the vectors instead
    sine2 = (h[:, 0].astype(np.float64) ** 2 + h[:, 1].astype(np.float64) ** 2) / np.sum(
        h.astype(np.float64) ** 2, axis=1
    )
    a8 = float(np.float32(alpha))
    if name == "Beckmann":
        want = np.exp(-sine2 / (1 - sine2) / a8**2) / (math.pi * a8**2 * (1 - sine2) ** 2)
    else:
        p = 2 / a8**2 - 2
        want = (p + 2) / (2 * math.pi) * np.exp(0.5 * p * np.log1p(-sine2))
    seen = want > 1e-3 * want.max()
    np.testing.assert_allclose(got[seen], want[seen], rtol=1e-3)
    twin = getattr(microfacet, f"D_{name}")(cosine, a8)
    np.testing.assert_allclose(twin[seen], want[seen], rtol=1e-6)


def test_distributions_at_the_edges(shaders: ShaderEval) -> None:
    """n.h of 0, below 0 and 1, alpha from 0 to 1: finite, not negative; nothing from behind."""
    c = np.array([-1.0, -1e-7, 0.0, 1e-12, 1e-6, 0.1, 1.0])
    alpha, cosine = (m.ravel() for m in np.meshgrid([0.0, 1e-8, 0.002025, 0.3, 1.0], c))
    n = np.tile(np.array([0, 0, 1], np.float32), (len(cosine), 1))
    h = np.stack([np.sqrt(1 - cosine**2), 0 * cosine, cosine], -1).astype(np.float32)
    for name in ("Beckmann", "BlinnPhong"):
        got = run(shaders, f"D_{name}(alpha, h.z, n, h)", LOBE, alpha=alpha.astype(np.float32), n=n, h=h)
        assert np.isfinite(got).all()
        assert (got >= 0).all()
        assert (got[cosine <= 0] == 0).all()


def test_exponents_up_to_a_million(shaders: ShaderEval) -> None:
    for p in (1e2, 1e4, 1e6):
        alpha = math.sqrt(2 / (p + 2))
        n, h, _ = tilted(np.sqrt(np.linspace(0, 13 / p, N)))
        got = run(shaders, "D_BlinnPhong(alpha, dot(n, h), n, h)", LOBE, alpha=np.full(N, alpha, np.float32), n=n, h=h)
        s2 = h[:, 0].astype(np.float64) ** 2 + h[:, 1].astype(np.float64) ** 2
        exact = 2 / float(np.float32(alpha)) ** 2 - 2
        want = (exact + 2) / (2 * math.pi) * np.exp(0.5 * exact * np.log1p(-s2))
        np.testing.assert_allclose(got, want, rtol=1e-3)


@pytest.mark.parametrize(
    ("expression", "name"),
    [("V_Walter(alpha, nv, nl)", "walter"), ("V_SmithSchlick(0.5 * alpha, nv, nl)", "schlick")],
)
def test_maskings(shaders: ShaderEval, expression: str, name: str) -> None:
    rng = np.random.default_rng(4)
    nv, nl = np.maximum(rng.uniform(size=(2, N)) ** 3, 1e-4).astype(np.float32)
    alpha = rng.choice(np.array([0.002025, 0.05, 0.3, 1.0], np.float32), N)
    got = run(shaders, expression, ANGLES, alpha=alpha, nv=nv, nl=nl)
    want = microfacet.visibility(name, "ggx", nv, nl, 1.0, 1.0, alpha)
    np.testing.assert_allclose(got, want, rtol=2e-4)
    zero = np.zeros(3, np.float32)
    edge = run(shaders, expression, ANGLES, alpha=np.array([0, 1e-8, 1], np.float32), nv=zero, nl=zero)
    assert np.isfinite(edge).all()


def test_cook_torrance(shaders: ShaderEval) -> None:
    rng = np.random.default_rng(5)
    nv, nl, nh, vh = rng.uniform(0.0, 1.0, size=(4, N)).astype(np.float32)
    nv[:4], nl[:4], vh[:4] = 0, 0, 0
    inputs = {"nv": "float", "nl": "float", "nh": "float", "vh": "float"}
    got = run(shaders, "V_CookTorrance(nv, nl, nh, vh)", inputs, nv=nv, nl=nl, nh=nh, vh=vh)
    np.testing.assert_allclose(got, microfacet.V_CookTorrance(nv, nl, nh, vh), rtol=1e-5)


def test_exact_fresnel(shaders: ShaderEval) -> None:
    f0, c = (m.ravel().astype(np.float32) for m in np.meshgrid([0, 0.02, 0.04, 0.3, 0.9, 1], np.linspace(0, 1, 101)))
    got = run(shaders, "F_Dielectric(f0, c)", {"f0": "float", "c": "float"}, f0=f0, c=c)
    np.testing.assert_allclose(got, microfacet.F_dielectric(c, f0), atol=3e-5)
    assert (got[f0 == 0] == 0).all(), "an index of 1 reflects nothing"
    for tint in (0.0, 0.5, 1.0):
        inputs = {"f0": "float", "tint": "float", "c": "float"}
        got = run(shaders, "F_Conductor(f0, tint, c)", inputs, f0=f0, tint=np.full_like(f0, tint), c=c)
        n, k = microfacet.conductor_of(f0, tint)
        np.testing.assert_allclose(got, microfacet.F_conductor(c, n, k), atol=2e-4)
    out = np.array([-1.0, -1e-7, 1.0 + 1e-6, np.nan], np.float32)
    got = run(shaders, "F_Dielectric(f0, c)", {"f0": "float", "c": "float"}, f0=np.full(4, 0.04, np.float32), c=out)
    assert ((got[:3] >= 0.0) & (got[:3] <= 1.0)).all()


def test_anisotropy_is_isotropic_where_both_widths_are_equal(shaders: ShaderEval) -> None:
    alpha = np.full(N, 0.2, np.float32)
    n, h, _ = tilted(np.linspace(0, 1.2, N))
    round_lobe = run(shaders, "D_GGX(alpha, h.z, n, h)", LOBE, alpha=alpha, n=n, h=h)
    stretched = run(shaders, "D_GGXAnisotropic(alpha, alpha, h.z, h.x, h.y)", LOBE, alpha=alpha, n=n, h=h)
    np.testing.assert_allclose(stretched, round_lobe, rtol=2e-5)
    nv, nl = np.random.default_rng(1).uniform(0.01, 1, (2, N)).astype(np.float32)
    along = "vec2(sqrt(1.0 - nv * nv), 0.0), vec2(0.0, sqrt(1.0 - nl * nl))"
    got = run(shaders, f"V_SmithGGXAnisotropic(alpha, alpha, nv, nl, {along})", ANGLES, alpha=alpha, nv=nv, nl=nl)
    want = run(shaders, "V_SmithGGXCorrelated(alpha, nv, nl)", ANGLES, alpha=alpha, nv=nv, nl=nl)
    np.testing.assert_allclose(got, want, rtol=2e-5)


def test_stretched_lobe_keeps_its_normalisation(shaders: ShaderEval) -> None:
    x, w = np.polynomial.legendre.leggauss(128)
    c, phi = (m.ravel() for m in np.meshgrid((x + 1) / 2, np.arange(64) * 2 * math.pi / 64))
    weight = (np.tile(w, 64) / 2) * 2 * math.pi / 64
    s = np.sqrt(1 - c * c)
    h = np.stack([s * np.cos(phi), s * np.sin(phi), c], -1).astype(np.float32)
    got = run(shaders, "D_GGXAnisotropic(0.6, 0.25, h.z, h.x, h.y)", {"h": "vec3"}, h=h)
    assert np.sum(got * c * weight) == pytest.approx(1.0, rel=1e-3)


def test_sheen(shaders: ShaderEval) -> None:
    rng = np.random.default_rng(6)
    alpha = rng.choice(np.array([0.0, 0.01, 0.2, 1.0], np.float32), N)
    c, nl = np.concatenate([[[0, 1], [0, 1]], rng.uniform(size=(2, N - 2))], axis=1).astype(np.float32)
    got = run(shaders, "D_Charlie(alpha, c)", {"alpha": "float", "c": "float"}, alpha=alpha, c=c)
    want = sheen.D_Charlie(c, alpha)
    np.testing.assert_allclose(got, want, rtol=2e-3, atol=1e-6)
    got = run(shaders, "V_Charlie(alpha, nv, nl)", ANGLES, alpha=alpha, nv=c, nl=nl)
    np.testing.assert_allclose(got, sheen.V_Charlie(c, nl, alpha), rtol=1e-3)


def test_albedo_of_sheen_is_fitted(shaders: ShaderEval) -> None:
    r, v = (m.ravel().astype(np.float32) for m in np.meshgrid(np.linspace(0.07, 1, 12), np.linspace(0.03, 1, 12)))
    got = run(shaders, "sheen_albedo(v, r)", {"v": "float", "r": "float"}, v=v, r=r)
    error = got - np.minimum(sheen.albedo(r, v), 1.0)
    assert np.abs(error).max() < 0.04
    assert np.sqrt(np.mean(error**2)) < 0.007


def test_thin_film(shaders: ShaderEval) -> None:
    rng = np.random.default_rng(7)
    c, nm = rng.uniform(0.0, 1.0, N).astype(np.float32), rng.uniform(0, 1200, N).astype(np.float32)
    f0 = rng.uniform(0, 1, (N, 3)).astype(np.float32)
    nm[:3], f0[:3] = 0, [[0, 0, 0], [1, 1, 1], [0.04, 0.04, 0.04]]
    inputs = {"c": "float", "nm": "float", "f0": "vec3"}
    got = run(shaders, "thin_film_fresnel(1.33, c, nm, f0)", inputs, "vec3", c=c, nm=nm, f0=f0)
    np.testing.assert_allclose(got, thin_film.fresnel(float(np.float32(1.33)), c, nm, f0), atol=2e-3)
