"""Each function of shaders/lib against its float64 twin in NumPy, over its whole range."""

from __future__ import annotations

import math

import numpy as np
import pytest

from engine.experiments.harness.shader_eval import ShaderEval
from engine.gpu.types import Device
from engine.math import color, ggx, tonemap

ALPHAS = (2.025e-3, 0.01, 0.1, 0.5, 1.0)


@pytest.fixture
def shaders(gl_device: Device) -> ShaderEval:
    return ShaderEval(gl_device)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(20)


@pytest.mark.parametrize("alpha", ALPHAS)
def test_d_ggx(shaders: ShaderEval, rng: np.random.Generator, alpha: float) -> None:
    """Half vectors in the lobe about a fixed normal: n.h from the same rounded vectors."""
    n = np.broadcast_to(np.array([0.0, 0.0, 1.0], np.float32), (4096, 3))
    theta = np.arctan(alpha * np.sqrt(rng.uniform(size=4096) / rng.uniform(0.01, 1.0, 4096)))
    phi = rng.uniform(0.0, 2.0 * math.pi, 4096)
    h = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1).astype(np.float32)
    kernel = shaders.kernel(
        "D_GGX(alpha, dot(n, h), n, h)",
        {"alpha": "float", "n": "vec3", "h": "vec3"},
        "float",
        include=["lib/brdf.glsl"],
    )
    got = kernel(alpha=np.full(4096, alpha, np.float32), n=n, h=h)
    exact = h.astype(np.float64)
    sine2 = exact[:, 0] ** 2 + exact[:, 1] ** 2
    a = float(np.float32(alpha))
    want = (a / (sine2 + (a * exact[:, 2]) ** 2)) ** 2 / math.pi
    np.testing.assert_allclose(got, want, rtol=1e-5)
    np.testing.assert_allclose(ggx.D_GGX(np.cos(np.arcsin(np.sqrt(sine2))), a), want, rtol=1e-4)


@pytest.mark.parametrize("alpha", ALPHAS)
def test_v_smith(shaders: ShaderEval, rng: np.random.Generator, alpha: float) -> None:
    nv, nl = np.maximum(rng.uniform(size=(2, 4096)) ** 3, 1e-4).astype(np.float32)
    kernel = shaders.kernel(
        "V_SmithGGXCorrelated(alpha, nv, nl)", {"alpha": "float", "nv": "float", "nl": "float"}, "float",
        include=["lib/brdf.glsl"],
    )  # fmt: skip
    got = kernel(alpha=np.full(4096, alpha, np.float32), nv=nv, nl=nl)
    np.testing.assert_allclose(got, ggx.V_SmithGGXCorrelated(nv, nl, np.float32(alpha)), rtol=2e-6)


def test_f_schlick(shaders: ShaderEval, rng: np.random.Generator) -> None:
    f0 = rng.uniform(size=(2048, 3)).astype(np.float32)
    f90 = np.maximum(f0, rng.uniform(0.5, 1.0, (2048, 3))).astype(np.float32)
    c = rng.uniform(-0.1, 1.1, 2048).astype(np.float32)
    kernel = shaders.kernel(
        "F_Schlick(f0, f90, c)", {"f0": "vec3", "f90": "vec3", "c": "float"}, "vec3", include=["lib/brdf.glsl"]
    )
    got = kernel(f0=f0, f90=f90, c=c)
    np.testing.assert_allclose(got, ggx.F_Schlick(c[:, None], f0, f90), rtol=1e-6, atol=1e-7)
    assert (got >= f0 - 1e-7).all()
    assert (got <= f90 + 1e-7).all()


@pytest.mark.parametrize("name", ["agx", "aces", "neutral"])
def test_tone_maps(shaders: ShaderEval, rng: np.random.Generator, name: str) -> None:
    rgb = (rng.uniform(size=(8192, 3)) * 2.0 ** rng.uniform(-12.0, 10.0, (8192, 1))).astype(np.float32)
    got = shaders.kernel(f"tone_map_{name}(c)", {"c": "vec3"}, "vec3", include=["lib/tone_map.glsl"])(c=rgb)
    # 2e-5 is a two-hundredth of a step of 8 bits: AgX takes a logarithm
    np.testing.assert_allclose(got, tonemap.TONE_MAPS[name](rgb), atol=2e-5 if name == "agx" else 2e-6)


def test_srgb(shaders: ShaderEval) -> None:
    linear = np.concatenate([np.linspace(0.0, 1.0, 4001), [0.0031308, 0.0031309, -1.0, 2.0]]).astype(np.float32)
    rgb = np.repeat(linear[:, None], 3, axis=1)
    got = shaders.kernel("srgb_from_linear(c)", {"c": "vec3"}, "vec3", include=["lib/color.glsl"])(c=rgb)
    np.testing.assert_allclose(got, color.linear_to_srgb(np.clip(rgb.astype(np.float64), 0.0, 1.0)), atol=1e-6)


def test_sanitise(shaders: ShaderEval) -> None:
    """Whatever comes in, a radiance comes out."""
    values = np.array([np.nan, np.inf, -np.inf, -1.0, 0.0, 1e-40, 1.5, 31999.0, 65504.0, 1e38], np.float32)
    got = shaders.kernel("sanitise(vec3(x)).x", {"x": "float"}, "float", include=["lib/math.glsl"])(x=values)
    np.testing.assert_allclose(got, [0.0, 32000.0, 0.0, 0.0, 0.0, 0.0, 1.5, 31999.0, 32000.0, 32000.0], atol=1e-37)


def test_safe_normalize(shaders: ShaderEval) -> None:
    v = np.array([[0, 0, 0], [3, 4, 0], [1e-12, 0, 0], [0, -1e12, 0]], np.float32)
    got = shaders.kernel("safe_normalize(v)", {"v": "vec3"}, "vec3", include=["lib/math.glsl"])(v=v)
    np.testing.assert_allclose(got, [[0, 0, 0], [0.6, 0.8, 0], [1, 0, 0], [0, -1, 0]], rtol=1e-6)
