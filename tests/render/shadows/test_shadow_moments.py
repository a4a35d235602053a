"""Moments of depth: bounds whose right answer is known, formats at their limits, and the shader against its twin."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from engine.experiments.harness.shader_eval import ShaderEval
from engine.gpu.types import Device
from engine.render.shadows import moments
from engine.render.shadows.quality import FILTERS

KINDS = tuple(moments.COUNTS)


def mix(filter: str, parts: list[tuple[float, float]], c: float) -> np.ndarray:
    """Moments of weights and depths."""
    return np.sum([w * moments.moments(filter, z, c) for w, z in parts], axis=0)


def lit(filter: str, parts: list[tuple[float, float]], t: float, c: float = 42.0, leak: float = 0.0, **more) -> float:
    return float(moments.visibility(filter, mix(filter, parts, c), t, c=c, leak=leak, **more))


@pytest.mark.parametrize("filter", KINDS)
@pytest.mark.parametrize("w", [0.0, 0.2, 0.5, 0.9])
def test_one_caster_over_a_receiver_is_exact(filter: str, w: float) -> None:
    """A part w of the lookup at -0.5, the rest the receiver itself at 0.5: 1 - w is lit. One-sided bounds are equal
    there, as two depths have no other distribution (Cantelli's inequality is sharp)."""
    got = lit(filter, [(w, -0.5), (1.0 - w, 0.5)], 0.5)
    assert got == pytest.approx(1.0 - w, abs=2e-5)


@pytest.mark.parametrize("filter", KINDS)
def test_a_flat_plane_is_lit(filter: str) -> None:
    """Row `VSM` of the cases: flat depth 0.99, in the format's own numbers."""
    for precision, kind in (("single", np.float32), ("half", np.float16)):
        c = moments.usable_exponent(42.0, precision)
        for z in (0.99, -0.99, 0.98, 0.0, 1.0, -1.0):
            stored = moments.moments(filter, z, c).astype(kind)
            assert np.isfinite(stored).all()
            seen = moments.visibility(filter, stored, z - 1e-3, c=c, leak=0.15, precision=precision)
            assert seen == pytest.approx(1.0, abs=1e-3 if precision == "single" else 0.12), (z, precision)


def test_light_leaks_of_two_casters_are_those_known() -> None:
    """A caster at 0.2, one at 0.5, a receiver at 0.55 of the depth range: 0 is right. Chebyshev alone leaks most; the
    larger the exponent, the less; four moments know three depths and leak nothing."""
    parts, t = [(0.5, -0.6), (0.5, 0.0)], 0.1
    assert lit("vsm", parts, t) == pytest.approx(0.09 / (0.09 + 0.16), abs=1e-6)  # variance 0.3^2, mean 0.4 off
    half, single = lit("evsm2", parts, t, c=5.54), lit("evsm2", parts, t, c=42.0)
    assert half == pytest.approx(0.135, abs=1e-3)
    assert single == pytest.approx(0.25 / (math.exp(4.2) - 0.5) ** 2, rel=0.05)  # below 1e-4
    assert lit("esm", parts, t, c=40.0) == pytest.approx(0.5 * math.exp(-4.0), abs=1e-6)  # 0.009
    assert lit("msm", parts, t) < 1e-4
    assert lit("evsm4", parts, t) <= single
    assert lit("vsm", parts, t, leak=0.4) == 0.0


@pytest.mark.parametrize("filter", ["vsm", "evsm2", "evsm4", "msm"])
def test_no_bound_takes_light_away(filter: str) -> None:
    """Random distributions: never darker than the part that lies at the receiver or beyond it."""
    rng = np.random.default_rng(3)
    for _ in range(300):
        weight = rng.dirichlet(np.ones(4))
        z = np.sort(rng.uniform(-1.0, 1.0, 4))
        t = float(rng.uniform(-1.0, 1.0))
        c = float(rng.uniform(1.0, 10.0))
        assert lit(filter, list(zip(weight, z, strict=True)), t, c=c) >= weight[z >= t].sum() - 2e-4


def test_four_moments_against_the_least_of_all_distributions() -> None:
    """By a linear programme over a grid of depths: the least part before t among all with these moments."""
    optimize = pytest.importorskip("scipy.optimize")
    grid = np.linspace(-3.0, 3.0, 6001)  # wide enough for the nodes of the least one
    powers = np.stack([grid**k for k in range(5)])
    weight, z = np.array([0.3, 0.3, 0.4]), np.array([-0.7, -0.2, 0.5])
    b = powers[:, np.searchsorted(grid, z - 1e-9)] @ weight
    for t in (-0.5, 0.0, 0.3):
        least = optimize.linprog((grid < t - 1e-9).astype(float), A_eq=powers, b_eq=b, bounds=(0, None)).fun
        assert float(moments.hamburger(b[1:], t, 0.0)) == pytest.approx(1.0 - least, abs=5e-3)


@pytest.mark.parametrize(("precision", "kind"), [("single", np.float32), ("half", np.float16)])
@pytest.mark.parametrize("filter", ["esm", "evsm2", "evsm4"])
def test_exponents_are_kept_below_overflow(filter: str, precision: str, kind: type) -> None:
    """Row `EVSM exponent`: c = 44 is clamped, and a 9 x 9 blur with weights that add up to 1 stays finite at both ends
    of depth; the numbers are not, a little beyond the limit."""
    c = moments.usable_exponent(44.0, precision)
    assert c == moments.LIMIT[precision]
    weights = moments.blur_weights(8.0)
    assert len(weights) == 9
    with np.errstate(over="ignore"):
        for z in (-1.0, 1.0):
            texel = moments.moments(filter, z, c).astype(kind)
            row = sum((kind(w) * texel for w in weights[1:] for _ in (0, 1)), kind(weights[0]) * texel)
            total = sum((kind(w) * row for w in weights[1:] for _ in (0, 1)), kind(weights[0]) * row)
            assert np.isfinite(total).all()
        if filter != "esm":
            assert np.isinf(moments.moments(filter, 1.0, moments.LIMIT[precision] * 1.07).astype(kind)).any()


@pytest.mark.parametrize("depth", [0.0, 1.0])
def test_esm_at_the_ends_of_depth(depth: float) -> None:
    """Row `ESM`: d in {0, 1} is finite, in single numbers too, and what lies before the casters is lit."""
    c = moments.usable_exponent(88.0, "single")
    z = 1.0 - 2.0 * depth
    stored = moments.moments("esm", z, c).astype(np.float32)
    assert np.isfinite(stored).all()
    assert moments.visibility("esm", stored, z, c=c, leak=0.0) == pytest.approx(1.0, abs=1e-4)
    assert moments.visibility("esm", stored, max(z - 0.5, -1.0), c=c, leak=0.0) == pytest.approx(1.0, abs=1e-6)


def test_exponents_that_are_no_numbers() -> None:
    for wanted in (math.nan, math.inf, -math.inf):
        assert moments.usable_exponent(wanted, "single") == moments.LIMIT["single"]
    assert moments.usable_exponent(-5.0, "half") == 1.0


@pytest.mark.parametrize("radius", [0.0, 0.4, 1.0, 1.5, 8.0, 12.0, 1e9])
def test_blur_weights_add_up_to_one(radius: float) -> None:
    weights = moments.blur_weights(radius)
    assert weights[0] + 2.0 * sum(weights[1:]) == pytest.approx(1.0, abs=1e-12)
    assert len(weights) - 1 <= min(radius, moments.MOST_TAPS)
    assert sorted(weights, reverse=True) == weights


@pytest.mark.gl
@pytest.mark.parametrize("half", [0, 1])
@pytest.mark.parametrize("filter", KINDS)
def test_the_shader_is_its_twin(gl_device: Device, filter: str, half: int) -> None:
    """Random texels of up to three depths, random receivers: as the float64 twin, given the same stored numbers."""
    rng = np.random.default_rng(11)
    n, precision = 4096, ("single", "half")[half]
    c = moments.usable_exponent(20.0, precision)
    z = rng.uniform(-1.0, 1.0, (n, 3))
    weight = rng.dirichlet(np.ones(3), n)
    m = (weight[..., None] * moments.moments(filter, z, c)).sum(axis=1).astype(np.float32)
    t = rng.uniform(-1.0, 1.0, n).astype(np.float32)
    header = f"#define SHADOW_FILTER {FILTERS.index(filter)}\n#define SHADOW_HALF {half}\n"
    text = (Path(moments.__file__).parents[3] / "shaders/lib/shadow_moments.glsl").read_text(encoding="utf-8")
    kernel = ShaderEval(gl_device).kernel(
        f"vec2(moment_visibility(m, t, {c!r}, 0.1, 0.01, 0.3), moments_of(t, {c!r}).x)", {"m": "vec4", "t": "float"},
        "vec2", functions=header + text,
    )  # fmt: skip
    got = kernel(m=m, t=t)
    want = moments.visibility(filter, m, t, c=c, leak=0.1, precision=precision, texel=0.01, steep=0.3)
    np.testing.assert_allclose(got[:, 1], moments.moments(filter, t, c)[:, 0], rtol=2e-5)
    off = np.abs(got[:, 0] - want)
    assert np.isfinite(got).all()
    assert np.quantile(off, 0.99) < (2e-2 if filter == "msm" else 2e-3)
    assert off.mean() < 1e-3


@pytest.mark.gl
@pytest.mark.parametrize("filter", KINDS)
def test_poison_stays_in_range(gl_device: Device, filter: str) -> None:
    """NaN, infinities, zeros and the largest numbers as moments, receivers from all of depth: 0 to 1."""
    bad = np.array([np.nan, np.inf, -np.inf, 0.0, -1.0, 65504.0, 1e38, 1e-45], np.float32)
    m = np.stack(np.meshgrid(bad, bad, bad, bad, indexing="ij"), axis=-1).reshape(-1, 4)
    t = np.resize(np.array([-1.0, 0.0, 0.3, 1.0], np.float32), len(m) + 1)[: len(m)]
    header = f"#define SHADOW_FILTER {FILTERS.index(filter)}\n#define SHADOW_HALF 0\n"
    text = (Path(moments.__file__).parents[3] / "shaders/lib/shadow_moments.glsl").read_text(encoding="utf-8")
    kernel = ShaderEval(gl_device).kernel(
        "moment_visibility(m, t, 42.0, 0.15, 0.01, 0.0)", {"m": "vec4", "t": "float"}, "float", functions=header + text
    )
    got = kernel(m=m, t=t)
    assert np.isfinite(got).all()
    assert ((got >= 0.0) & (got <= 1.0)).all()
