"""The shaders' BRDF terms where they are hardest, against float64."""

from __future__ import annotations

import numpy as np
import pytest

from engine.assets.primitives import card, uv_sphere
from engine.assets.scene import LightAsset
from engine.core.errors import InputError
from engine.experiments import brdf_half
from engine.experiments.harness.context import Context
from engine.math import ggx, microfacet
from tests.stability import brdf_checks as checks
from tests.stability.rows import covers
from tests.support.shader_probe import ShaderProbe
from tests.support.stage import Stage, front_camera, surface

pytestmark = pytest.mark.gl

GRAZING = [0.0, 1e-8, 1e-4, 1e-3, 0.02, 0.3, 0.7, 1.0]


@covers("brdf.ggx-small-alpha")
@pytest.mark.parametrize("alpha", [1e-4, 1e-3, 0.002025, 0.01, 0.1, 0.5, 1.0])
def test_ggx_resolves_its_lobe(probe: ShaderProbe, alpha: float) -> None:
    checks.ggx_resolves_its_lobe(probe, alpha)


@covers("brdf.ggx-least-alpha")
def test_least_roughness_is_bounded(probe: ShaderProbe) -> None:
    checks.least_roughness_is_bounded(probe)


@covers("brdf.ggx-least-alpha")
def test_ggx_peak_falls_with_alpha(probe: ShaderProbe) -> None:
    alpha = np.geomspace(1e-6, 1.0, 200)
    up = [[0.0, 0.0, 1.0]]
    got = probe("result.x = D_GGX(a, 1.0, n, n);", "lib/brdf.glsl", a=alpha, n=up)[:, 0]
    assert np.isfinite(got).all()
    assert (np.diff(got) < 0.0).all()
    np.testing.assert_allclose(got, 1.0 / (np.pi * alpha**2), rtol=1e-5)


@covers("brdf.roughness-of-a-file")
@pytest.mark.parametrize("roughness", [0.0, 1e-8])
def test_a_perfect_mirror_of_a_file_is_drawn(stage: Stage, roughness: float) -> None:
    stage.look(kind="uniform", sun_illuminance=5.0)
    stage.add(uv_sphere(), surface(base_color=(1, 1, 1, 1), metallic=1.0, roughness=roughness))
    picture = stage.hdr()
    assert np.isfinite(picture).all()
    assert (picture[..., :3] >= 0.0).all()
    assert picture[..., :3].max() > 1.0  # the sun's reflection is there


@covers("brdf.roughness-of-a-file")
@pytest.mark.parametrize("roughness", [-1.0, 1.5, float("nan"), float("inf")])
def test_impossible_roughness_is_refused_with_its_name(stage: Stage, roughness: float) -> None:
    with pytest.raises(InputError, match="roughness"):
        stage.add(uv_sphere(), surface(roughness=roughness))


@covers("brdf.ggx-half-arithmetic")
@pytest.mark.parametrize("term", sorted(brdf_half.TERMS))
def test_terms_in_half_arithmetic_are_finite_and_near(term: str) -> None:
    """Where the textbook form of GGX is no number in one of six, the robust ones stay within a tenth of float64."""
    ctx = Context(quick=True)
    x = brdf_half.inputs(ctx, 400, np.float16)
    forms, truth = brdf_half.TERMS[term]
    got = forms["robust"](x)
    assert got.dtype == np.float16
    assert np.isfinite(got).all()
    assert np.quantile(np.abs(got.astype(float) / np.maximum(truth(x), 1e-4) - 1.0), 0.99) < 0.1
    if term == "D GGX":
        with np.errstate(all="ignore"):
            assert (~np.isfinite(forms["textbook"](x))).mean() > 0.05
    assert all(extreme.ok for extreme in brdf_half.extremes(ctx) if extreme.what.startswith(term))


@covers("brdf.beckmann")
def test_beckmann_where_the_half_vector_lies_in_the_surface(probe: ShaderProbe) -> None:
    """The textbook form is infinity times zero there."""
    cosine, alpha = (
        x.reshape(-1) for x in np.meshgrid([-0.5, 0.0, 1e-12, 1e-6, 0.1, 0.5, 1.0], [0.002025, 0.05, 0.4, 1.0])
    )
    h = np.stack([np.sqrt(1.0 - cosine**2), 0.0 * cosine, cosine], 1)
    up = [[0.0, 0.0, 1.0]]
    got = probe("result.x = D_Beckmann(a, c, n, h);", "lib/microfacet.glsl", a=alpha, c=cosine, n=up, h=h)[:, 0]
    assert np.isfinite(got).all()
    a, c = alpha.astype(np.float32).astype(float), cosine.astype(np.float32).astype(float)
    np.testing.assert_allclose(got, microfacet.D_Beckmann(c, a), rtol=1e-4, atol=1e-5)


@covers("brdf.blinn-phong")
@pytest.mark.parametrize("exponent", [0.0, 1.0, 1e2, 1e3, 1e4, 1e5, 1e6])
def test_blinn_phong_with_any_exponent(probe: ShaderProbe, exponent: float) -> None:
    """Near float64 where it is not small, and its projected area is 1."""
    alpha = float(np.float32(np.sqrt(2.0 / (exponent + 2.0))))
    nodes, weights = np.polynomial.legendre.leggauss(256)
    s, ds = (nodes + 1.0) / 2.0, weights / 2.0
    t, dt = alpha**2 * s / (1.0 - s), alpha**2 / (1.0 - s) ** 2  # tan^2, as GGX falls
    cosine = 1.0 / np.sqrt(1.0 + t)
    h = np.stack([np.sqrt(t) * cosine, 0.0 * cosine, cosine], 1).astype(np.float32)
    up = [[0.0, 0.0, 1.0]]
    got = probe("result.x = D_BlinnPhong(a, c, n, h);", "lib/microfacet.glsl", a=[alpha], c=h[:, 2], n=up, h=h)[:, 0]
    assert np.isfinite(got).all()
    h8 = h.astype(float) / np.linalg.norm(h.astype(float), axis=1, keepdims=True)
    p = max(2.0 / alpha**2 - 2.0, 0.0)
    expected = (p + 2.0) / (2.0 * np.pi) * np.exp(0.5 * p * np.log1p(-(h8[:, 0] ** 2)))
    tall = expected > 1e-3 * expected.max()
    np.testing.assert_allclose(got[tall], expected[tall], rtol=1e-3)
    assert np.sum(ds * got * cosine * np.pi * dt * cosine**3) == pytest.approx(1.0, abs=1e-3)
    least = probe(
        "result.x = D_BlinnPhong(a, c, n, h);", "lib/microfacet.glsl",
        a=[alpha], c=[-1.0, 0.0], n=up, h=[[0.0, 0.0, -1.0], [1.0, 0.0, 0.0]],
    )[:, 0]  # fmt: skip
    assert np.isfinite(least).all()
    assert (least >= 0.0).all()


@covers("brdf.grazing")
def test_visibility_at_grazing_angles(probe: ShaderProbe) -> None:
    """Finite with n.v and n.l of 0, and the float64 twin's where the twin is below the clamp's bound."""
    v, l, a = (x.reshape(-1) for x in np.meshgrid(GRAZING, GRAZING, [0.002025, 0.01, 0.25, 1.0], indexing="ij"))
    got = probe("result.x = V_SmithGGXCorrelated(a, v, l);", "lib/brdf.glsl", a=a, v=v, l=l)[:, 0]
    assert np.isfinite(got).all()
    assert (got >= 0.0).all()
    expected = ggx.V_SmithGGXCorrelated(v.astype(np.float32), l.astype(np.float32), a.astype(np.float32))
    inside = (v >= 1e-4) & (l >= 1e-4)  # shaders raise n.v to 1e-4, and n.l = 0 is multiplied away
    np.testing.assert_allclose(got[inside], expected[inside], rtol=2e-5)


@covers("brdf.grazing")
def test_brdf_is_reciprocal(probe: ShaderProbe) -> None:
    """f(l, v) = f(v, l) of the coat; the diffuse part's (1 - F) is symmetric as well."""
    rng = np.random.default_rng(2)
    v = rng.normal(size=(4000, 3))
    l = rng.normal(size=(4000, 3))
    v[:, 2], l[:, 2] = np.abs(v[:, 2]) + 1e-3, np.abs(l[:, 2]) + 1e-3
    v32, l32 = checks.unit(v), checks.unit(l)
    common = {
        "n": [[0.0, 0.0, 1.0]],
        "f0": [[0.04, 0.5, 0.9]],
        "f90": [1.0],
        "albedo": [[0.5, 0.5, 0.0]],
        "alpha": [0.09],
    }
    there = probe(checks.REFLECTED, "lib/lights.glsl", v=v32, l=l32, **common)[:, :3] / l32[:, 2:]
    back = probe(checks.REFLECTED, "lib/lights.glsl", v=l32, l=v32, **common)[:, :3] / v32[:, 2:]
    np.testing.assert_allclose(there, back, rtol=5e-6)


@covers("brdf.fresnel-range")
def test_fresnel_stays_between_f0_and_f90(probe: ShaderProbe) -> None:
    cosine = np.array([-1.0, -1e-3, -1e-7, 0.0, 1e-7, 0.5, 1.0, 1.0 + 1e-7, 1.5, 1e30])
    got = probe("result.x = F_Schlick(vec3(0.04), vec3(1.0), c).x;", "lib/brdf.glsl", c=cosine)[:, 0]
    assert ((got >= np.float32(0.04) - 1e-7) & (got <= 1.0)).all()
    np.testing.assert_allclose(got, ggx.F_Schlick(cosine, 0.04), rtol=1e-6)


@covers("brdf.half-of-opposites")
def test_light_straight_against_the_view(probe: ShaderProbe) -> None:
    """l = -v: the half vector is zero. With both on the horizon this passes the n.l test."""
    v = checks.unit(np.array([[1.0, 0.0, 0.0], [1.0, 0.0, 1e-4], [0.6, 0.0, 0.8], [0.0, 0.0, 1.0]]))
    flipped = np.concatenate([-v, v * np.array([-1.0, 1.0, 1.0], np.float32)])
    got = probe(
        checks.REFLECTED, "lib/lights.glsl", n=[[0.0, 0.0, 1.0]], v=np.concatenate([v, v]), l=flipped,
        f0=[[1.0] * 3], f90=[1.0], albedo=[[1.0] * 3], alpha=[0.002025],
    )  # fmt: skip
    assert np.isfinite(got).all()
    assert (got[: len(v)] == 0.0).all()  # from below, or along the horizon


@covers("brdf.half-of-opposites")
def test_safe_normalize_of_anything(probe: ShaderProbe) -> None:
    size = np.array([0.0, 1e-30, 1e-20, 1e-14, 1e-4, 1.0, 1e4, 1e15, 1e18])
    direction = checks.unit(np.random.default_rng(0).normal(size=(len(size), 3)))
    given = direction * size[:, None]
    got = probe("result.xyz = safe_normalize(v);", "lib/math.glsl", v=given)[:, :3]
    length = np.linalg.norm(got, axis=1)
    assert np.isfinite(got).all()
    assert (length <= 1.0 + 1e-6).all()
    np.testing.assert_allclose(length[size >= 1e-14], 1.0, atol=1e-6)


@covers("brdf.light-at-distance-0")
def test_falloff_from_zero_to_infinity(probe: ShaderProbe) -> None:
    d2, reach = (
        x.reshape(-1)
        for x in np.meshgrid([0.0, 1e-38, 1e-30, 1e-12, 1.0, 1e12, 1e38], [0.0, 1e-30, 1e-15, 1.0, 1e9], indexing="ij")
    )
    got = probe("result.x = distance_falloff(d2, reach);", "lib/lights.glsl", d2=d2, reach=reach)[:, 0]
    assert np.isfinite(got).all()
    assert (got >= 0.0).all()
    outside = (reach > 0.0) & (d2 > np.maximum(reach * 1.001, 1e-15) ** 2)  # below 1e-15 m it counts as that
    assert (got[outside] == 0.0).all()
    assert got[(d2 == 1.0) & (reach == 0.0)] == 1.0


@covers("brdf.light-at-distance-0")
@pytest.mark.parametrize("kind", ["point", "spot"])
@pytest.mark.parametrize("height", [0.0, 1e-30, 1e-6])
def test_light_on_the_surface_is_finite(stage: Stage, kind: str, height: float) -> None:
    stage.add(card(2.0), surface(base_color=(0.5, 0.5, 0.5, 1), metallic=0.0, roughness=0.0))
    light = LightAsset(kind, intensity=1e6, range=1.0, inner_angle=0.5, outer_angle=0.5)
    stage.lamp(light, (0.0, 0.0, height))
    picture = stage.hdr((33, 33), front_camera())
    assert np.isfinite(picture).all()
    assert picture.max() <= 32000.0


@covers("brdf.energy")
def test_lambert_reflects_its_albedo(probe: ShaderProbe) -> None:
    checks.lambert_reflects_its_albedo(probe)


@covers("brdf.energy")
def test_coat_gains_no_energy(probe: ShaderProbe) -> None:
    checks.coat_gains_no_energy(probe)
