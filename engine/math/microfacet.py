"""The choices of distribution, Fresnel and masking that a surface can be made of, in float64: twins of
shaders/lib/microfacet.glsl, and which of them belong together.

Cosines are of unit vectors, scalars broadcast; alpha = roughness^2. Masking comes as visibility V = G / (4 n.l n.v),
which has no division by what goes to zero at grazing. GGX and the correlated Smith term are in ggx.py.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.math import ggx

F8 = NDArray[np.float64]

#: below this the masking terms take a cosine as this: they are bounded there, and n.l multiplies them
GRAZING = 1e-4
#: reflectance from which no index of refraction is taken: the one of 1 is infinite
GREATEST_F0 = 0.9999


def _f8(*values: ArrayLike) -> list[F8]:
    return [np.asarray(v, np.float64) for v in np.broadcast_arrays(*values)]


# --- distributions ---


def exponent_of(alpha: ArrayLike) -> F8:
    """Blinn-Phong's exponent for a roughness: 2 / alpha^2 - 2 (Walter et al. 2007, section 5.2)."""
    a = np.asarray(alpha, np.float64)
    result: F8 = np.maximum(2.0 / np.maximum(a * a, 1e-12) - 2.0, 0.0)
    return result


def D_BlinnPhong(n_dot_h: ArrayLike, alpha: ArrayLike) -> F8:
    """D [1/sr] = (p + 2) / (2 pi) (n.h)^p: int D n.h is 1 (Walter et al. 2007, eq. 30). Zero for n.h <= 0."""
    c, a = _f8(n_dot_h, alpha)
    p = exponent_of(a)
    power = np.exp(p * np.log(np.maximum(c, 1e-300)))
    return np.where(c > 0.0, (p + 2.0) / (2.0 * math.pi) * power, 0.0)


def D_Beckmann(n_dot_h: ArrayLike, alpha: ArrayLike) -> F8:
    """D [1/sr] (Walter et al. 2007, eq. 25). Zero for n.h <= 0, where the exponential outweighs the poles."""
    c, a = _f8(n_dot_h, alpha)
    c2 = np.maximum(c * c, 1e-7)
    a2 = np.maximum(a * a, 1e-12)
    value = np.exp(-(1.0 - c2) / (a2 * c2)) / (math.pi * a2 * c2 * c2)
    return np.where(c > 0.0, value, 0.0)


def sample_half(distribution: str, u: ArrayLike, alpha: ArrayLike) -> F8:
    """Half vectors [..., 3] about +Z with density D (n.h) from `u` [..., 2] in [0, 1): `beckmann` (Walter et al. 2007,
    eq. 28), `blinn_phong` (eq. 31), `ggx` (eq. 35)."""
    uniform = np.asarray(u, np.float64)
    a2 = np.asarray(alpha, np.float64) ** 2
    if distribution == "beckmann":
        cosine = 1.0 / np.sqrt(1.0 - a2 * np.log1p(-uniform[..., 0]))
    elif distribution == "blinn_phong":
        cosine = (1.0 - uniform[..., 0]) ** (1.0 / (exponent_of(np.sqrt(a2)) + 2.0))
    else:
        return ggx.sample_half(uniform, np.sqrt(a2))
    sine, phi = np.sqrt(np.maximum(1.0 - cosine * cosine, 0.0)), 2.0 * math.pi * uniform[..., 1]
    return np.stack([sine * np.cos(phi), sine * np.sin(phi), cosine], axis=-1)


# --- Fresnel ---


def F_none(v_dot_h: ArrayLike, f0: ArrayLike) -> F8:
    """f0, whatever the angle."""
    return _f8(v_dot_h, f0)[1] + 0.0


def ior_of(f0: ArrayLike) -> F8:
    """Index of refraction of a dielectric with that reflectance at normal incidence."""
    root = np.sqrt(np.clip(np.asarray(f0, np.float64), 0.0, GREATEST_F0))
    result: F8 = (1.0 + root) / (1.0 - root)
    return result


def F_dielectric(v_dot_h: ArrayLike, f0: ArrayLike) -> F8:
    """Unpolarised reflectance of a dielectric (Cook and Torrance 1982, appendix), its index taken from `f0`."""
    c, r0 = _f8(v_dot_h, f0)
    c, n = np.clip(c, 0.0, 1.0), ior_of(r0)
    g = np.sqrt(np.maximum(n * n - 1.0 + c * c, 0.0))
    # an index of 1 reflects nothing, at grazing too, where both are 0
    a = (g - c) / np.maximum(g + c, 1e-30)
    b = ((g + c) * c - 1.0) / np.maximum((g - c) * c + 1.0, 1e-30)
    return np.where(r0 > 0.0, np.clip(0.5 * a * a * (1.0 + b * b), 0.0, 1.0), 0.0)


def conductor_of(f0: ArrayLike, edge_tint: ArrayLike) -> tuple[F8, F8]:
    """(n, k) of a metal that reflects `f0` at normal incidence; `edge_tint` in [0, 1] chooses among them: 1 the least n
    (Gulbrandsen 2014, "Artist Friendly Metallic Fresnel", eq. 2 and 3)."""
    r, g = _f8(f0, edge_tint)
    r = np.clip(r, 0.0, GREATEST_F0)
    root = np.sqrt(r)
    n = g * (1.0 - r) / (1.0 + r) + (1.0 - g) * (1.0 + root) / (1.0 - root)
    k2 = (r * (n + 1.0) ** 2 - (n - 1.0) ** 2) / (1.0 - r)
    return n, np.sqrt(np.maximum(k2, 0.0))


def F_conductor(v_dot_h: ArrayLike, n: ArrayLike, k: ArrayLike) -> F8:
    """Unpolarised reflectance of a metal of complex index n + ik (Born and Wolf 1999, section 14.2)."""
    c, n_, k_ = _f8(v_dot_h, n, k)
    c = np.clip(c, 0.0, 1.0)
    c2, s2 = c * c, 1.0 - c * c
    t0 = n_ * n_ - k_ * k_ - s2
    ab = np.sqrt(t0 * t0 + 4.0 * n_ * n_ * k_ * k_)
    t1, t2 = ab + c2, 2.0 * c * np.sqrt(np.maximum(0.5 * (ab + t0), 0.0))
    across = (t1 - t2) / np.maximum(t1 + t2, 1e-30)
    t3, t4 = c2 * ab + s2 * s2, t2 * s2
    along = across * (t3 - t4) / np.maximum(t3 + t4, 1e-30)
    result: F8 = np.clip(0.5 * (across + along), 0.0, 1.0)
    return result


# --- visibilities ---


def V_implicit(n_dot_v: ArrayLike, n_dot_l: ArrayLike, alpha: ArrayLike = 1.0) -> F8:
    """1/4: G = (n.l)(n.v), no masking that any microsurface has (Hoffman 2013, "Background: Physics and Math")."""
    return np.full_like(_f8(n_dot_v, n_dot_l, alpha)[0], 0.25)


def V_CookTorrance(n_dot_v: ArrayLike, n_dot_l: ArrayLike, n_dot_h: ArrayLike, v_dot_h: ArrayLike) -> F8:
    """V-cavities (Cook and Torrance 1982, eq. 4), whatever the roughness."""
    v, l, h, vh = _f8(n_dot_v, n_dot_l, n_dot_h, v_dot_h)
    v, l, vh = np.maximum(v, GRAZING), np.maximum(l, GRAZING), np.maximum(vh, GRAZING)
    result: F8 = np.minimum(1.0, 2.0 * np.maximum(h, 0.0) * np.minimum(v, l) / vh) / (4.0 * v * l)
    return result


def schlick_k(alpha: ArrayLike, distribution: str) -> F8:
    """k of Schlick's masking: alpha / 2 stands for GGX (Karis 2013), alpha sqrt(2 / pi) for Beckmann (Schlick 1994)."""
    scale = 0.5 if distribution == "ggx" else math.sqrt(2.0 / math.pi)
    result: F8 = np.asarray(alpha, np.float64) * scale
    return result


def V_SmithSchlick(n_dot_v: ArrayLike, n_dot_l: ArrayLike, k: ArrayLike) -> F8:
    """Each direction alone, Smith's term by Schlick's fraction (Schlick 1994, eq. 19)."""
    v, l, k_ = _f8(n_dot_v, n_dot_l, k)
    v, l = np.maximum(v, 0.0), np.maximum(l, 0.0)
    result: F8 = 0.25 / np.maximum((v * (1.0 - k_) + k_) * (l * (1.0 - k_) + k_), 1e-7)
    return result


def V_Walter(n_dot_v: ArrayLike, n_dot_l: ArrayLike, alpha: ArrayLike) -> F8:
    """Each direction alone, Smith's term for Beckmann by Walter et al. 2007's fraction (below their eq. 27)."""
    v, l, a = _f8(n_dot_v, n_dot_l, alpha)
    result: F8 = 0.25 * _walter_part(v, a) * _walter_part(l, a)
    return result


def _walter_part(cosine: F8, alpha: F8) -> F8:
    """G1 / cosine, finite at grazing; at normal incidence 1."""
    c = np.maximum(cosine, 0.0)
    s = np.maximum(alpha, 1e-6) * np.sqrt(np.maximum(1.0 - c * c, 0.0))
    far = c >= 1.6 * s
    safe = np.where(far, 1.0, s)
    t = np.where(far, 0.0, c / safe)
    near = (3.535 + 2.181 * t) / (safe * (1.0 + 2.276 * t + 2.577 * t * t))
    return np.where(far, 1.0 / np.where(far, np.maximum(c, 1e-30), 1.0), near)


def compensation(f0: ArrayLike, albedo: ArrayLike) -> F8:
    """By what the specular lobe is multiplied to give back what one bounce loses (Turquin 2019, "Practical
    multiple scattering compensation for microfacet models", eq. 16). `albedo` of the lobe with F = 1."""
    f, e = _f8(f0, albedo)
    result: F8 = 1.0 + f * (1.0 / np.clip(e, 0.05, 1.0) - 1.0)
    return result


# --- what belongs together ---

DISTRIBUTIONS = ("ggx", "beckmann", "blinn_phong")
MASKINGS = ("smith", "schlick", "walter", "cook_torrance", "implicit")
FRESNELS = ("schlick", "none", "dielectric", "conductor")

#: distribution -> the maskings derived for it. V-cavities are a microsurface of their own and take any distribution.
MATCHED = {
    "ggx": ("smith", "schlick", "cook_torrance"),
    "beckmann": ("walter", "schlick", "cook_torrance"),
    "blinn_phong": ("walter", "schlick", "cook_torrance"),
}

D_TERMS: dict[str, Callable[[ArrayLike, ArrayLike], F8]] = {
    "ggx": ggx.D_GGX, "beckmann": D_Beckmann, "blinn_phong": D_BlinnPhong,
}  # fmt: skip


def visibility(
    masking: str, distribution: str, n_dot_v: ArrayLike, n_dot_l: ArrayLike, n_dot_h: ArrayLike, v_dot_h: ArrayLike,
    alpha: ArrayLike,
) -> F8:  # fmt: skip
    """V of the masking of that name."""
    if masking == "smith":
        return ggx.V_SmithGGXCorrelated(n_dot_v, n_dot_l, alpha)
    if masking == "schlick":
        return V_SmithSchlick(n_dot_v, n_dot_l, schlick_k(alpha, distribution))
    if masking == "walter":
        return V_Walter(n_dot_v, n_dot_l, alpha)
    if masking == "cook_torrance":
        return V_CookTorrance(n_dot_v, n_dot_l, n_dot_h, v_dot_h)
    return V_implicit(n_dot_v, n_dot_l, alpha)


def chosen(features: Iterable[str]) -> tuple[str, str, str]:
    """(distribution, masking, fresnel) that a material's features choose; of several the first counts, as in the
    shader."""
    on = set(features)

    def first(kind: str, names: Iterable[str], default: str) -> str:
        return next((name for name in names if f"{kind}_{name}" in on), default)

    return (
        first("distribution", DISTRIBUTIONS[1:], "ggx"), first("masking", MASKINGS[1:], "smith"),
        first("fresnel", FRESNELS[1:], "schlick"),
    )  # fmt: skip
