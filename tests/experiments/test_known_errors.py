"""Numbers that are known from elsewhere: what an experiment finds must agree."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from engine.experiments import agx_curve, brdf_energy, irradiance_sh, mip_filter, normal_storage
from engine.experiments.harness import registry
from engine.experiments.harness.context import Context
from engine.math import sh, tonemap
from engine.math.sphere import fibonacci


def outcome(name: str, ctx: Context, **knobs: object) -> dict[str, float]:
    trial = registry.get(name).run(ctx, knobs)
    try:
        return trial.judge(trial.work() if trial.work is not None else None).error
    finally:
        if trial.close is not None:
            trial.close()


@pytest.mark.parametrize(("bits", "degrees"), [(8, 0.944), (10, 0.235), (12, 0.059), (16, 0.0037)])
@pytest.mark.usefixtures("gl_device")
def test_octahedral_normals(quick: Callable[[], Context], bits: int, degrees: float) -> None:
    """Cigolle et al. 2014, table 3: the greatest angle by bits a coordinate."""
    error = outcome("normal_storage", quick(), kind="octahedral", bits=bits)
    assert error["max_angle"] == pytest.approx(degrees, rel=0.05)


def test_octahedral_axes_are_exact() -> None:
    words = normal_storage.encode_octahedral(np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]), 16)
    assert words.tolist() == [[0, 0], [32767, 0]]


def test_white_furnace() -> None:
    """GGX of alpha 1 seen head-on keeps 0.307 of the light, Beckmann 0.462; a mismatched pair makes light."""
    one, up = np.array([1.0]), np.array([1.0])
    assert brdf_energy.albedo("GGX, Smith", one, up, 128)[0] == pytest.approx(0.3069, abs=2e-4)
    assert brdf_energy.albedo("Beckmann, Walter", one, up, 128)[0] == pytest.approx(0.462, abs=2e-3)
    alpha, mu = np.full(2, 0.5), np.array([0.3, 0.05])
    assert brdf_energy.albedo("GGX, Walter (mismatched)", alpha, mu, 128).max() > 1.2


@pytest.mark.parametrize(("degrees", "error"), [(30.0, 0.033), (60.0, 0.27), (90.0, 0.92), (120.0, 2.2)])
@pytest.mark.usefixtures("gl_device")
def test_nlerp(quick: Callable[[], Context], degrees: float, error: float) -> None:
    trial = registry.get("quaternion").run(quick(), {"method": "nlerp", "digits": 64})
    assert trial.work is not None
    profile = {round(x, 6): y for x, y in trial.judge(trial.work()).profile}
    assert profile[degrees] == pytest.approx(error, rel=0.03)


def test_cosine_factors() -> None:
    """Ramamoorthi and Hanrahan 2001: pi, 2 pi / 3, pi / 4, 0, -pi / 24."""
    found = [irradiance_sh.cosine_factor(band) for band in range(6)]
    assert found == pytest.approx([math.pi, 2 * math.pi / 3, math.pi / 4, 0.0, -math.pi / 24, 0.0])


def test_harmonics_are_orthonormal_and_span_the_renderer_s() -> None:
    d = fibonacci(20000)
    y = irradiance_sh.harmonics(d, 6)
    np.testing.assert_allclose(y.T @ y * (4.0 * math.pi / len(d)), np.eye(36), atol=5e-3)
    ours = sh.basis9(d)
    inside = y[:, :9] @ np.linalg.lstsq(y[:, :9], ours, rcond=None)[0]
    np.testing.assert_allclose(inside, ours, atol=1e-10)


def test_agx_sigmoid() -> None:
    """It goes through the corners and the pivot with slope 2; the published polynomial is close to it."""
    x = np.linspace(0.0, 1.0, 1001)
    y = agx_curve.sigmoid(x)
    assert (y[0], y[-1]) == pytest.approx((0.0, 1.0), abs=1e-12)
    assert (np.diff(y) > 0.0).all()
    pivot = np.array([agx_curve.PIVOT_X - 1e-6, agx_curve.PIVOT_X, agx_curve.PIVOT_X + 1e-6])
    low, middle, high = agx_curve.sigmoid(pivot)
    assert middle == pytest.approx(0.5)
    assert (high - low) / 2e-6 == pytest.approx(2.0, rel=1e-4)
    assert np.sqrt(np.mean((np.polyval(tonemap.AGX_CURVE, x) - y) ** 2)) < 3e-3


@pytest.mark.usefixtures("gl_device")
def test_box_mips_dim_a_wave_by_its_cosine(quick: Callable[[], Context]) -> None:
    trial = registry.get("mip_filter").run(quick(), {"kernel": "importer box", "radius": 1})
    assert trial.work is not None
    for f, error in trial.judge(trial.work()).profile[:8]:
        assert error == pytest.approx(1.0 - math.cos(math.pi * f), abs=2e-6)


def test_mip_kernels_keep_a_constant() -> None:
    for kind in ("tent", "lanczos", "kaiser"):
        for radius in (1, 3):
            flat = np.full((16, 16, 1), 0.7, np.float32)
            np.testing.assert_allclose(mip_filter.halve(flat, mip_filter.weights(kind, radius)), 0.7, rtol=1e-6)


@pytest.mark.parametrize(("distance", "pixels"), [(1e6, 50.0), (1e7, 500.0)])
@pytest.mark.usefixtures("gl_device")
def test_far_from_the_origin(quick: Callable[[], Context], distance: float, pixels: float) -> None:
    """float32 resolves 0.06 m at 10⁶ m: tens of pixels for what is 5 m away; relative to the camera, none."""
    for method, low, high in (("world float32", pixels / 4, pixels * 4), ("grid origin", 0.0, 0.02)):
        trial = registry.get("camera_relative").run(quick(), {"method": method})
        profile = dict(trial.judge(None).profile)
        assert low <= profile[distance] <= high


@pytest.mark.usefixtures("gl_device")
def test_depth(quick: Callable[[], Context]) -> None:
    """Reversed float keeps 1e-7 of any distance; 24 bits with near 1 mm keep 6e-3 at 100 m."""
    good = outcome("depth_format", quick(), mapping="reversed, infinite", format="float32")
    assert good["max_relative"] < 2e-7
    for mapping in ("reversed, infinite", "forward"):
        assert outcome("depth_format", quick(), mapping=mapping, format="unorm24")["at_100_m"] > 3e-3
