"""Cloth: the "Charlie" sheen in float64, twin of shaders/lib/sheen.glsl, and its albedo by quadrature.

Estevez and Kulla 2017, "Production Friendly Microfacet Sheen BRDF". Without their soft terminator: it breaks
reciprocity.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

F8 = NDArray[np.float64]

#: perceptual roughness below this is raised to it: the lobe would be a line at the horizon
MIN_SHEEN_ROUGHNESS = 0.07


def D_Charlie(n_dot_h: ArrayLike, alpha: ArrayLike) -> F8:
    """D [1/sr] = (2 + 1/alpha) sin^(1/alpha) / (2 pi) (Estevez and Kulla 2017, eq. 2)."""
    c, a = (np.asarray(v, np.float64) for v in np.broadcast_arrays(n_dot_h, alpha))
    power = 1.0 / np.maximum(a, MIN_SHEEN_ROUGHNESS**2)
    sine2 = np.clip(1.0 - c * c, 1e-12, 1.0)
    result: F8 = (2.0 + power) * np.exp(0.5 * power * np.log(sine2)) / (2.0 * math.pi)
    return result


#: a, b, c, d, e of Estevez and Kulla's fit at alpha 0 and 1 (their table 1)
_SMOOTH = (25.3245, 3.32435, 0.16801, -1.27393, -4.85967)
_ROUGH = (21.5473, 3.82987, 0.19823, -1.97760, -4.32054)


def _exponent(x: F8, alpha: F8) -> F8:
    """Their L(x): the logarithm of Smith's lambda below 60 degrees."""
    t = (1.0 - alpha) ** 2
    a, b, c, d, e = (rough + t * (smooth - rough) for smooth, rough in zip(_SMOOTH, _ROUGH, strict=True))
    result: F8 = a / (1.0 + b * x**c) + d * x + e
    return result


def smith_lambda(cosine: ArrayLike, alpha: ArrayLike) -> F8:
    """Smith's lambda of the distribution by their fit (section 3): mirrored about cosine 1/2."""
    c, a = (np.asarray(v, np.float64) for v in np.broadcast_arrays(cosine, alpha))
    c = np.clip(c, 0.0, 1.0)
    low = np.exp(_exponent(np.minimum(c, 0.5), a))
    high = np.exp(2.0 * _exponent(np.full_like(c, 0.5), a) - _exponent(np.minimum(1.0 - c, 0.5), a))
    return np.where(c < 0.5, low, high)


def V_Charlie(n_dot_v: ArrayLike, n_dot_l: ArrayLike, alpha: ArrayLike) -> F8:
    """V = 1 / ((1 + lambda(v) + lambda(l)) 4 n.l n.v); cosines from 1e-4, as n.l multiplies it."""
    v, l, a = (np.asarray(x, np.float64) for x in np.broadcast_arrays(n_dot_v, n_dot_l, alpha))
    a = np.maximum(a, MIN_SHEEN_ROUGHNESS**2)
    v, l = np.maximum(v, 1e-4), np.maximum(l, 1e-4)
    result: F8 = 0.25 / ((1.0 + smith_lambda(v, a) + smith_lambda(l, a)) * v * l)
    return result


def albedo(roughness: ArrayLike, n_dot_v: ArrayLike, order: int = 64) -> F8:
    """Directional albedo [...] of the lobe with colour 1, by Gauss-Legendre over the hemisphere of the light."""
    rough, mu = (np.asarray(v, np.float64) for v in np.broadcast_arrays(roughness, n_dot_v))
    alpha = (np.maximum(rough, MIN_SHEEN_ROUGHNESS) ** 2)[..., None, None]
    v = np.clip(mu, 1e-6, 1.0)[..., None, None]
    nodes, weights = np.polynomial.legendre.leggauss(order)
    u = (nodes + 1.0) / 2.0
    # the lobe hugs the horizon: more points there
    l, dl = (u * u)[:, None], (u * weights)[:, None]
    phi, dphi = (math.pi * u)[None, :], (math.pi * weights / 2.0)[None, :]
    vl = v * l + np.sqrt(1.0 - v * v) * np.sqrt(1.0 - l * l) * np.cos(phi)
    h = (v + l) / np.sqrt(np.maximum(2.0 + 2.0 * vl, 1e-12))
    value = D_Charlie(np.clip(h, 0.0, 1.0), alpha) * V_Charlie(v, l, alpha) * l
    result: F8 = 2.0 * np.sum(value * dl * dphi, axis=(-2, -1))
    return result
