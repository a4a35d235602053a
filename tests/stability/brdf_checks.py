"""What the shaders' BRDF functions must satisfy, as functions of a probe: also run on shaders with planted bugs."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from engine.math import ggx
from tests.support.shader_probe import ShaderProbe

F8 = NDArray[np.float64]

REFLECTED = """
Reflector r = Reflector(n, v, f0, f90, albedo, alpha, max(dot(n, v), 1e-4));
result = vec4(reflected(r, l, vec3(1.0)), 0.0);
"""


def unit(rows: F8) -> NDArray[np.float32]:
    return (rows / np.linalg.norm(rows, axis=1, keepdims=True)).astype(np.float32)


def around(n: NDArray[np.float32], angles: F8, seed: int) -> NDArray[np.float32]:
    """Vectors at `angles` from the unit rows `n`, in random directions about them."""
    side = np.cross(n, np.random.default_rng(seed).normal(size=n.shape))
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    return unit(np.cos(angles)[:, None] * n + np.sin(angles)[:, None] * side)


def ggx_resolves_its_lobe(probe: ShaderProbe, alpha: float, count: int = 20_000) -> None:
    """D over its lobe (sampled by its own density) against float64 of the same rounded vectors: p99 < 1e-3."""
    rng = np.random.default_rng(5)
    n = unit(rng.normal(size=(count, 3)))
    u = rng.random(count)
    theta = np.arctan(alpha * np.sqrt(u / np.maximum(1.0 - u, 1e-12)))
    h = around(n, theta, 6)
    got = probe("result.x = D_GGX(a, n_dot_h, n, h);", "lib/brdf.glsl",
                n=n, h=h, a=[alpha], n_dot_h=np.einsum("ij,ij->i", n, h, dtype=np.float32))[:, 0]  # fmt: skip
    n8, h8, a = n.astype(np.float64), h.astype(np.float64), float(np.float32(alpha))
    cross = np.cross(n8, h8)
    k = a / (np.einsum("ij,ij->i", cross, cross) + (np.einsum("ij,ij->i", n8, h8) * a) ** 2)
    expected = k * k / math.pi
    assert np.isfinite(got).all()
    error = np.abs(got / expected - 1.0)
    assert np.quantile(error, 0.99) < 1e-3, f"alpha {alpha}: p99 {np.quantile(error, 0.99):.2e}"


def brdf_over_the_hemisphere(
    probe: ShaderProbe, roughness: float, n_dot_v: float, f0: float, f90: float, albedo: float, order: int = 96
) -> float:
    """The directional albedo: the integral of brdf * n.l over light directions, by Gauss-Legendre about the peak."""
    nodes, weights = np.polynomial.legendre.leggauss(order)
    # mu = sin^2-spaced towards the horizon's end would miss the lobe: split the elevation at the mirror direction
    peak = math.acos(n_dot_v)
    pieces = [(0.0, peak), (peak, math.pi / 2)] if 0.0 < peak < math.pi / 2 else [(0.0, math.pi / 2)]
    theta = np.concatenate([(b - a) / 2 * (nodes + 1.0) + a for a, b in pieces])
    w_theta = np.concatenate([(b - a) / 2 * weights for a, b in pieces])
    phi = math.pi * (nodes + 1.0) / 2.0
    w_phi = math.pi * weights  # both halves
    t, p = (x.reshape(-1) for x in np.meshgrid(theta, phi, indexing="ij"))
    weight = (w_theta[:, None] * w_phi[None, :]).reshape(-1) * np.sin(t)
    # the mirror direction of v lies at phi = 0
    l = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], 1).astype(np.float32)
    v = np.array([[-math.sin(peak), 0.0, n_dot_v]], np.float32)
    got = probe(
        REFLECTED, "lib/lights.glsl", n=[[0.0, 0.0, 1.0]], v=v, l=l, f0=[[f0] * 3], f90=[f90], albedo=[[albedo] * 3],
        alpha=[max(roughness, ggx.MIN_ROUGHNESS) ** 2],
    )  # fmt: skip
    return float((got[:, 0].astype(np.float64) * weight).sum())


def lambert_reflects_its_albedo(probe: ShaderProbe) -> None:
    """A diffuse surface of albedo 1 under light from everywhere gives back 1, not pi, not 1/pi."""
    for n_dot_v in (0.1, 0.5, 0.9):
        total = brdf_over_the_hemisphere(probe, 1.0, n_dot_v, 0.0, 0.0, 1.0)
        assert abs(total - 1.0) < 1e-3, f"n.v {n_dot_v}: a white diffuser reflects {total:.3f}"


def coat_gains_no_energy(probe: ShaderProbe) -> None:
    """F = 1: the single-scattering albedo is at most 1, and equals the float64 quadrature of the same terms."""
    for roughness in (0.3, 0.5, 0.75, 1.0):
        for n_dot_v in (0.05, 0.3, 0.7, 0.98):
            total = brdf_over_the_hemisphere(probe, roughness, n_dot_v, 1.0, 1.0, 0.0)
            expected = float(ggx.albedo(roughness, n_dot_v))
            assert total <= 1.0 + 1e-3, f"roughness {roughness}, n.v {n_dot_v}: albedo {total:.4f}"
            assert abs(total - expected) < 4e-3, (
                f"roughness {roughness}, n.v {n_dot_v}: {total:.4f}, not {expected:.4f}"
            )


def least_roughness_is_bounded(probe: ShaderProbe) -> None:
    """Down to roughness 0, light straight into the mirror direction stays finite, and below what a half float holds."""
    angles = np.concatenate([np.zeros(1), np.geomspace(1e-8, 1.5, 400)])
    n = np.array([[0.0, 0.0, 1.0]], np.float32)
    v = np.stack([-np.sin(angles), np.zeros_like(angles), np.cos(angles)], 1).astype(np.float32)
    l = v * np.array([-1.0, 1.0, 1.0], np.float32)
    for alpha in (0.0, 1e-8, 0.002, 0.0079):
        got = probe(REFLECTED, "lib/lights.glsl", n=n, v=v, l=l, f0=[[1.0] * 3], f90=[1.0], albedo=[[0.0] * 3],
                    alpha=[alpha])  # fmt: skip
        assert np.isfinite(got).all(), f"alpha {alpha}"
        assert (got >= 0.0).all()
        assert got.max() <= 1e6, f"alpha {alpha}: {got.max():g}"
