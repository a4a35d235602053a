"""What a surface material reflects, in float64, from its parameters: slices of its lobe, its albedo, its terms.

The sum is that of shaders/lib/surface_model.glsl: diffuse under specular, under sheen, under a coat. Colours come as
luminance. Angles are radians from the normal.

    Lobe(effect, features, params) ─► slice(theta)      f n.l by outgoing angle, part by part
                                   ─► albedo(theta)     what is sent back of light from there, part by part
                                   ─► furnace(theta)    albedo of the white specular lobe: 1 keeps all energy
                                   ─► terms(theta)      D, V, F
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.math import ggx, microfacet, sheen, thin_film

F8 = NDArray[np.float64]

_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
_COAT_F0 = 0.04
#: what params are where a material says nothing
_DEFAULTS: dict[str, Any] = {
    "base_color": (1.0, 1.0, 1.0, 1.0), "metallic": 1.0, "roughness": 1.0, "ior": 1.5, "specular": 1.0,
    "specular_color": (1.0, 1.0, 1.0), "edge_tint": (0.5, 0.5, 0.5), "exponent": 64.0, "clearcoat": 1.0,
    "clearcoat_roughness": 0.0, "sheen_color": (1.0, 1.0, 1.0), "sheen_roughness": 0.5, "anisotropy": 0.5,
    "iridescence": 1.0, "iridescence_ior": 1.3, "iridescence_thickness_max": 400.0, "transmission": 1.0,
}  # fmt: skip


def directional_albedo(
    distribution: str, masking: str, alpha: ArrayLike, n_dot_v: ArrayLike, order: int = 64,
    fresnel: Callable[[F8], F8] | None = None,
) -> F8:  # fmt: skip
    """Albedo [...] of a lobe by Gauss-Legendre over the half vector, warped by GGX's elevation, which resolves
    the others too. `fresnel`: of v.h, one number; None: F = 1."""
    a, m = (np.asarray(x, np.float64)[..., None, None] for x in np.broadcast_arrays(alpha, n_dot_v))
    m = np.clip(m, 1e-4, 1.0)
    nodes, weights = np.polynomial.legendre.leggauss(order)
    u, du = (nodes + 1.0) / 2.0, weights / 2.0
    # a cubic warp towards both ends: roots and the horizon lie there
    s, ds = (u * u * (3.0 - 2.0 * u))[:, None], (6.0 * u * (1.0 - u) * du)[:, None]
    phi, dphi = (u * math.pi)[None, :], du[None, :]
    nh = np.sqrt((1.0 - s) / (1.0 + (a * a - 1.0) * s))
    vh = np.sqrt(1.0 - m * m) * np.sqrt(1.0 - nh * nh) * np.cos(phi) + m * nh
    nl = 2.0 * vh * nh - m
    valid = (vh > 0.0) & (nl > 1e-9)
    light = np.where(valid, nl, 1.0)
    relative = microfacet.D_TERMS[distribution](nh, a) / np.maximum(ggx.D_GGX(nh, a), 1e-300)
    value = relative * microfacet.visibility(masking, distribution, m, light, nh, vh, a) * 4.0 * light * vh / nh
    if fresnel is not None:
        value = value * fresnel(np.clip(vh, 0.0, 1.0))
    result: F8 = np.sum(np.where(valid, value, 0.0) * ds * dphi, axis=(-2, -1))
    return result


def _luminance(color: Any) -> Any:
    return np.asarray(color, np.float64)[..., :3] @ _LUMINANCE


@dataclass(frozen=True, slots=True)
class Lobe:
    """The numbers of a material that its lobe depends on. `across`: slices lie across the grain of a stretched lobe."""

    distribution: str = "ggx"
    masking: str = "smith"
    fresnel: str = "schlick"
    alpha: float = 1.0
    base: F8 = field(default_factory=lambda: np.ones(3))
    metallic: float = 0.0
    f0_dielectric: F8 = field(default_factory=lambda: np.full(3, 0.04))
    f90: float = 1.0
    edge_tint: F8 = field(default_factory=lambda: np.full(3, 0.5))
    compensated: bool = False
    stretched: float = 0.0
    coat: float = 0.0
    coat_alpha: float = 0.002
    sheen_color: float = 0.0
    sheen_roughness: float = 0.5
    film: tuple[float, float, float] = (0.0, 1.3, 400.0)
    transmission: float = 0.0
    across: bool = False

    # --- terms ---

    def f(self, v_dot_h: ArrayLike) -> F8:
        """Fresnel reflectance [..., 3] of the base."""
        c = np.asarray(v_dot_h, np.float64)[..., None]
        dielectric, metal = self.f0_dielectric, self.base
        if self.fresnel == "none":
            plain: F8 = dielectric + (metal - dielectric) * self.metallic + 0.0 * c
            return plain
        if self.fresnel in ("dielectric", "conductor"):
            low = microfacet.F_dielectric(c, dielectric)
            if self.fresnel == "conductor":
                high = microfacet.F_conductor(c, *microfacet.conductor_of(metal, self.edge_tint))
            else:
                high = ggx.F_Schlick(c, metal)
            return low + (high - low) * self.metallic
        f0 = dielectric + (metal - dielectric) * self.metallic
        if self.film[0] > 0.0:
            strength, ior, nanometres = self.film
            seen = thin_film.fresnel(ior, c[..., 0], nanometres, np.broadcast_to(f0, (*c.shape[:-1], 3)))
            return (1.0 - strength) * ggx.F_Schlick(c, f0) + strength * seen
        return ggx.F_Schlick(c, f0, self.f90)

    def d(self, theta: ArrayLike) -> F8:
        """D by the half vector's angle, in the plane of the slice."""
        t = np.asarray(theta, np.float64)
        if not self.stretched:
            return microfacet.D_TERMS[self.distribution](np.cos(t), self.alpha)
        along, other = self._widths()
        k = 1.0 / ((np.sin(t) / along) ** 2 + np.cos(t) ** 2)
        result: F8 = k * k / (math.pi * along * other)
        return result

    def v(self, n_dot_v: ArrayLike, n_dot_l: ArrayLike, n_dot_h: ArrayLike, v_dot_h: ArrayLike) -> F8:
        """V of directions in the plane of the slice."""
        width = self._widths()[0] if self.stretched else self.alpha
        return microfacet.visibility(self.masking, self.distribution, n_dot_v, n_dot_l, n_dot_h, v_dot_h, width)

    def _widths(self) -> tuple[float, float]:
        wide = self.alpha + (1.0 - self.alpha) * self.stretched**2
        return (self.alpha, wide) if self.across else (wide, self.alpha)

    # --- what is plotted ---

    def slice(self, theta_in: float, theta_out: ArrayLike) -> dict[str, F8]:
        """f n.l by part and outgoing angle; light comes at `theta_in`, its mirror direction is +theta_in."""
        out = np.asarray(theta_out, np.float64)
        half = 0.5 * (out - theta_in)
        nl, nv = math.cos(theta_in), np.cos(out)
        nh, vh = np.cos(half), np.cos(0.5 * (out + theta_in))
        lit = (nv > 0.0) & (nl > 0.0)
        gain = self._gain(np.maximum(nv, 1e-4))
        f = self.f(vh)
        specular = _luminance(f * gain) * self.d(half) * self.v(nv, nl, nh, vh) * nl
        diffuse = _luminance((1.0 - f) * self._diffuse) * (nl / math.pi)
        parts = {"diffuse": diffuse, "specular": specular}
        if self.sheen_color:
            alpha = max(self.sheen_roughness, sheen.MIN_SHEEN_ROUGHNESS) ** 2
            under = 1.0 - self.sheen_color * np.minimum(sheen.albedo(self.sheen_roughness, nv.clip(0.01), 24), 1.0)
            parts = {name: part * under for name, part in parts.items()}
            parts["sheen"] = self.sheen_color * sheen.D_Charlie(nh, alpha) * sheen.V_Charlie(nv, nl, alpha) * nl
        if self.coat:
            under = 1.0 - self._coat_albedo(nv)
            parts = {name: part * under for name, part in parts.items()}
            lobe = ggx.D_GGX(nh, self.coat_alpha) * ggx.V_SmithGGXCorrelated(nv, nl, self.coat_alpha)
            parts["coat"] = self.coat * ggx.F_Schlick(vh, _COAT_F0) * lobe * nl
        return {name: np.where(lit, part, 0.0) for name, part in parts.items()}

    def albedo(self, theta: ArrayLike, order: int = 32) -> dict[str, F8]:
        """Albedo by part and angle; of a stretched lobe that of its mean width. `passes`: what is let through."""
        mu = np.maximum(np.cos(np.asarray(theta, np.float64)), 1e-3)
        alpha = math.sqrt(self._widths()[0] * self._widths()[1]) if self.stretched else self.alpha
        gain = _luminance(self._gain(mu))
        specular = gain * directional_albedo(
            self.distribution, self.masking, alpha, mu, order, lambda c: np.asarray(_luminance(self.f(c)))
        )
        # what the specular lobe lets in, light by light, as the shader has it: (1 - F) of the half vector
        below = _luminance(self.base) * (1.0 - self.metallic)
        let_in = self._let_in(mu, order)
        parts = {"diffuse": below * (1.0 - self.transmission) * let_in, "specular": specular}
        if self.transmission:
            parts["passes"] = below * self.transmission * let_in
        if self.sheen_color:
            cloth = np.minimum(sheen.albedo(self.sheen_roughness, mu, 48), 1.0) * self.sheen_color
            parts = {name: part * (1.0 - cloth) for name, part in parts.items()} | {"sheen": cloth}
        if self.coat:
            coat = self._coat_albedo(mu)
            parts = {name: part * (1.0 - coat) for name, part in parts.items()} | {"coat": coat}
        return parts

    def furnace(self, theta: ArrayLike, order: int = 32) -> F8:
        """Albedo [...] of the specular lobe with F = 1: below 1 it loses, above it makes light."""
        mu = np.maximum(np.cos(np.asarray(theta, np.float64)), 1e-3)
        alpha = math.sqrt(self._widths()[0] * self._widths()[1]) if self.stretched else self.alpha
        found = directional_albedo(self.distribution, self.masking, alpha, mu, order)
        if self.compensated:
            found = found * microfacet.compensation(1.0, ggx.albedo(math.sqrt(alpha), mu, order))
        return found

    def _let_in(self, mu: F8, order: int) -> F8:
        """Mean of 1 - F over a diffuse hemisphere of light seen from each angle."""
        nodes, weights = np.polynomial.legendre.leggauss(max(order // 2, 8))
        l, dl = (nodes + 1.0) / 2.0, weights / 2.0
        phi, dphi = (nodes + 1.0) * (math.pi / 2.0), weights / 2.0
        m = mu[..., None, None]
        l_, p_ = l[:, None], phi[None, :]
        vl = m * l_ + np.sqrt(1.0 - m * m) * np.sqrt(1.0 - l_ * l_) * np.cos(p_)
        f = _luminance(self.f(np.sqrt(np.clip(0.5 * (1.0 + vl), 0.0, 1.0))))
        result: F8 = np.sum((1.0 - f) * (2.0 * l * dl)[:, None] * dphi[None, :], axis=(-2, -1))
        return result

    @property
    def _diffuse(self) -> F8:
        return self.base * (1.0 - self.metallic) * (1.0 - self.transmission)

    def _gain(self, mu: F8) -> F8:
        """[..., 3] by which the specular lobe is multiplied."""
        if not self.compensated or (self.distribution, self.masking) != ("ggx", "smith"):
            return np.ones((*np.shape(mu), 3))
        e = ggx.albedo(math.sqrt(self.alpha), np.maximum(mu, 1e-3), 24)
        f0 = self.f0_dielectric + (self.base - self.f0_dielectric) * self.metallic
        return microfacet.compensation(f0, np.asarray(e)[..., None])

    def _coat_albedo(self, mu: F8) -> F8:
        ab = ggx.dfg(math.sqrt(self.coat_alpha), np.clip(mu, 1e-3, 1.0), 24)
        result: F8 = self.coat * (_COAT_F0 * ab[..., 0] + ab[..., 1])
        return result


def lobe_of(effect: str, features: Iterable[str], params: Mapping[str, Any], *, across: bool = False) -> Lobe | None:
    """The lobe of a material, its textures taken as white; None for effects that have none (unlit, toon, one's own)."""
    on = set(features)
    if effect not in ("surface", "microfacet", "layered", "blinn_phong") or "unlit" in on:
        return None
    p = {**_DEFAULTS, **params}
    roughness = float(np.clip(p["roughness"], ggx.MIN_ROUGHNESS, 1.0))
    distribution, masking, fresnel = microfacet.chosen(on)
    if effect == "blinn_phong":
        distribution, masking = "blinn_phong", "implicit"
        roughness = float(np.clip((2.0 / (max(p["exponent"], 0.0) + 2.0)) ** 0.25, ggx.MIN_ROUGHNESS, 1.0))
    elif effect == "surface":
        distribution, masking, fresnel = "ggx", "smith", "schlick"
    elif "anisotropy" in on:
        distribution, masking = "ggx", "smith"
    plain = ((p["ior"] - 1.0) / (p["ior"] + 1.0)) ** 2
    metallic = float(p["metallic"])
    return Lobe(
        distribution, masking, fresnel, roughness**2, np.asarray(p["base_color"], np.float64)[:3], metallic,
        np.minimum(plain * np.asarray(p["specular_color"], np.float64), 1.0) * p["specular"],
        float(p["specular"] * (1.0 - metallic) + metallic), np.asarray(p["edge_tint"], np.float64),
        "energy_compensation" in on and (distribution, masking) == ("ggx", "smith"),
        float(p["anisotropy"]) if "anisotropy" in on else 0.0,
        float(p["clearcoat"]) if "clearcoat" in on else 0.0,
        float(np.clip(p["clearcoat_roughness"], ggx.MIN_ROUGHNESS, 1.0)) ** 2,
        float(_luminance(p["sheen_color"])) if "sheen" in on else 0.0,
        float(np.clip(p["sheen_roughness"], sheen.MIN_SHEEN_ROUGHNESS, 1.0)),
        (float(p["iridescence"]) if "iridescence" in on else 0.0, float(p["iridescence_ior"]),
         float(p["iridescence_thickness_max"])),
        float(p["transmission"]) if "transmission" in on else 0.0, across,
    )  # fmt: skip
