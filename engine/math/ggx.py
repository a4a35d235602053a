"""GGX microfacet reflection in float64: the twins of shaders/lib's functions, and quadrature for what they tabulate.

Walter et al. 2007 (D, sampling), Heitz 2014 (height-correlated Smith), Karis 2013 (split sum), Fdez-Aguera 2019
(multiple scattering). alpha = roughness^2 for perceptual roughness. All cosines are of unit vectors; scalars broadcast.
"""

from __future__ import annotations

import itertools
import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

F8 = NDArray[np.float64]

#: Perceptual roughness below this is raised to it in shaders: float32 D stays finite and smooth.
MIN_ROUGHNESS = 0.045


def D_GGX(n_dot_h: ArrayLike, alpha: ArrayLike) -> F8:
    """Return the normal distribution D [1/sr] (Walter et al. 2007, eq. 33). Zero for n.h <= 0.

    Written with sin^2 = 1 - (n.h)^2 as k^2 / pi, k = alpha / (sin^2 + (alpha n.h)^2), which keeps digits near n.h = 1.
    """
    c, a = np.broadcast_arrays(np.asarray(n_dot_h, np.float64), np.asarray(alpha, np.float64))
    k = a / ((1.0 - c) * (1.0 + c) + (a * c) ** 2)
    return np.where(c > 0.0, k * k / math.pi, 0.0)


def V_SmithGGXCorrelated(n_dot_v: ArrayLike, n_dot_l: ArrayLike, alpha: ArrayLike) -> F8:
    """Return V = G2 / (4 n.v n.l), height-correlated Smith (Heitz 2014, eq. 99). Zero where either is below 0."""
    v, l, a = np.broadcast_arrays(*(np.asarray(x, np.float64) for x in (n_dot_v, n_dot_l, alpha)))
    a2 = a * a
    v, l = np.maximum(v, 0.0), np.maximum(l, 0.0)
    bottom = l * np.sqrt(v * v * (1.0 - a2) + a2) + v * np.sqrt(l * l * (1.0 - a2) + a2)
    return np.where(bottom > 0.0, 0.5 / np.where(bottom > 0.0, bottom, 1.0), 0.0)


def F_Schlick(v_dot_h: ArrayLike, f0: ArrayLike, f90: ArrayLike = 1.0) -> F8:
    """Return the Fresnel reflectance f0 + (f90 - f0)(1 - v.h)^5 (Schlick 1994); v.h is clamped to [0, 1]."""
    x = 1.0 - np.clip(np.asarray(v_dot_h, np.float64), 0.0, 1.0)
    f0 = np.asarray(f0, np.float64)
    result: F8 = f0 + (np.asarray(f90, np.float64) - f0) * x**5
    return result


def G1_Smith(n_dot_v: ArrayLike, alpha: ArrayLike) -> F8:
    """Return Smith's masking G1 for GGX (Walter et al. 2007, eq. 34)."""
    c, a = np.broadcast_arrays(np.asarray(n_dot_v, np.float64), np.asarray(alpha, np.float64))
    c = np.maximum(c, 0.0)
    bottom = c + np.sqrt(a * a + (1.0 - a * a) * c * c)
    return np.where(bottom > 0.0, 2.0 * c / np.where(bottom > 0.0, bottom, 1.0), 0.0)


def sample_half(u: ArrayLike, alpha: ArrayLike) -> F8:
    """Return half vectors [..., 3] about +Z with density D (n.h) from `u` [..., 2] (Walter et al. 2007, eq. 35-36)."""
    u = np.asarray(u, np.float64)
    a = np.asarray(alpha, np.float64)
    cosine = np.sqrt((1.0 - u[..., 0]) / (1.0 + (a * a - 1.0) * u[..., 0]))
    sine = np.sqrt(np.maximum(0.0, 1.0 - cosine * cosine))
    phi = 2.0 * math.pi * u[..., 1]
    return np.stack([sine * np.cos(phi), sine * np.sin(phi), cosine], axis=-1)


def sample_visible_half(u: ArrayLike, v: ArrayLike, alpha: ArrayLike) -> F8:
    """Return half vectors [..., 3] about +Z with the density of normals visible from `v` [..., 3].

    Spherical caps (Dupuy and Benyoub 2023): the same density as Heitz 2018, JCGT 7(4), with fewer steps.
    """
    u, v = np.asarray(u, np.float64), np.asarray(v, np.float64)
    a = np.asarray(alpha, np.float64)[..., None] * np.array([1.0, 1.0, 0.0]) + np.array([0.0, 0.0, 1.0])
    stretched = v * a
    stretched = stretched / np.linalg.norm(stretched, axis=-1, keepdims=True)
    z = (1.0 - u[..., 0]) * (1.0 + stretched[..., 2]) - stretched[..., 2]
    ring = np.sqrt(np.clip(1.0 - z * z, 0.0, 1.0))
    phi = 2.0 * math.pi * u[..., 1]
    half = np.stack([ring * np.cos(phi), ring * np.sin(phi), z], axis=-1) + stretched
    half = half * a
    result: F8 = half / np.linalg.norm(half, axis=-1, keepdims=True)
    return result


def dfg(roughness: ArrayLike, n_dot_v: ArrayLike, order: int = 48) -> F8:
    """Return [..., 2] = (A, B) with specular albedo f0 A + B for f90 = 1 (Karis 2013, the split sum's second factor).

    `roughness` perceptual in (0, 1], `n_dot_v` in (0, 1], broadcast. Quadrature, not sampling: the half vector's
    elevation is warped by D's distribution, the azimuth ends where the light would sink below the horizon, and both
    are Gauss-Legendre with `order` points between the kinks. Error with the default: below
    1e-5 for n.v >= 0.1, below 3e-4 at grazing n.v = 0.02.
    """
    rough, mu = np.broadcast_arrays(np.asarray(roughness, np.float64), np.asarray(n_dot_v, np.float64))
    alpha, mu = (rough * rough)[..., None, None], np.clip(mu, 1e-6, 1.0)[..., None, None]
    nodes, weights = np.polynomial.legendre.leggauss(order)
    nodes = (nodes + 1.0) / 2.0
    # points drawn towards both ends of each piece, where roots begin and the light meets the horizon
    s, ds = nodes * nodes * (3.0 - 2.0 * nodes), 3.0 * nodes * (1.0 - nodes) * weights
    view = np.arccos(mu)
    # the light stays above the horizon for every azimuth up to the first angle, and for none beyond the second
    ends = [np.zeros_like(view), (math.pi / 2.0 - view) / 2.0, (math.pi / 2.0 + view) / 2.0]
    total = np.zeros((*rough.shape, 2))
    for start, end in itertools.pairwise(ends):
        # D cos sin dtheta = du / (2 pi): integrate in u
        u0, u1 = _distribution(start, alpha), _distribution(end, alpha)
        u = u0 + (u1 - u0) * s[:, None]
        du = (u1 - u0) * ds[:, None]
        nh = np.sqrt((1.0 - u) / (1.0 + (alpha * alpha - 1.0) * u))
        sh = np.sqrt(np.maximum(1.0 - nh * nh, 0.0))
        sv = np.sqrt(1.0 - mu * mu)
        product = np.maximum(sv * sh, 1e-300)
        last = np.arccos(np.clip((mu / (2.0 * nh) - mu * nh) / product, -1.0, 1.0))
        phi = last * s
        vh = sv * sh * np.cos(phi) + mu * nh
        nl = np.maximum(2.0 * vh * nh - mu, 0.0)
        # both halves of the azimuth; the density of h over phi is 1 / (2 pi)
        value = 4.0 * V_SmithGGXCorrelated(mu, nl, alpha) * nl * vh / nh * (du * last * ds / math.pi)
        fresnel = (1.0 - np.clip(vh, 0.0, 1.0)) ** 5
        total[..., 0] += np.sum(value * (1.0 - fresnel), axis=(-2, -1))
        total[..., 1] += np.sum(value * fresnel, axis=(-2, -1))
    return total


def albedo(roughness: ArrayLike, n_dot_v: ArrayLike, order: int = 48) -> F8:
    """Return the single-scattering directional albedo [...] with F = 1: A + B of `dfg`. At most 1."""
    result: F8 = dfg(roughness, n_dot_v, order).sum(axis=-1)
    return result


def multiple_scattering(f0: ArrayLike, dfg_ab: ArrayLike) -> tuple[F8, F8]:
    """Return (single, multiple) specular albedo [...] of `f0` [...] with `dfg_ab` [..., 2], f90 = 1.

    Fdez-Aguera 2019, JCGT 8(1), eq. 5 to 10: light that single scattering loses leaves after further bounces, coloured
    by the average Fresnel f0 + (1 - f0) / 21.
    """
    f0, ab = np.asarray(f0, np.float64), np.asarray(dfg_ab, np.float64)
    a, b = ab[..., 0], ab[..., 1]
    single = f0 * a + b
    lost = 1.0 - (a + b)
    average = f0 + (1.0 - f0) / 21.0
    multiple: F8 = lost * single * average / (1.0 - lost * average)
    return single, multiple


def environment_brdf(f0: ArrayLike, roughness: ArrayLike, n_dot_v: ArrayLike) -> F8:
    """Return the specular albedo [...] under uniform light, single plus multiple scattering: 1 where f0 = 1."""
    single, multiple = multiple_scattering(f0, dfg(roughness, n_dot_v))
    return single + multiple


def _distribution(theta: F8, alpha: F8) -> F8:
    """Return u in [0, 1]: the part of D cos within elevation `theta`, the inverse of `sample_half`'s warp."""
    c2 = np.cos(theta) ** 2
    result: F8 = (1.0 - c2) / (1.0 + (alpha * alpha - 1.0) * c2)
    return result
