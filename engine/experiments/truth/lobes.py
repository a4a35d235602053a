"""The surface as the path tracer has it: Lambert under GGX, with what GGX loses put back, so that white stays white.

    f(v, l) = F D V + (Fms(v) + kd(v)) / pi
    Fms = Fss Favg Ems / (1 - Favg Ems)        Fss = f0 A + f90 B,  Ems = 1 - (A + B),  (A, B) of engine.math.ggx.dfg
    kd  = albedo (1 - Fss - Fms)

This is the surface that Fdez-Aguera 2019 (JCGT 8(1)) gives an environment, taken as a BRDF: the light that microfacets
pass on to each other leaves evenly. Energy is kept: in a white furnace
f0 = f90 = 1, or a white albedo, gives 1.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from engine.math import ggx
from engine.math.sphere import basis, cosine_hemisphere

F8 = NDArray[np.float64]

#: texels of the table of (A, B) along the root of n.v and along roughness
TABLE = 48


@cache
def _table() -> F8:
    """f8[TABLE,TABLE,2] over sqrt(n.v) and perceptual roughness, ends included."""
    t = np.linspace(0.0, 1.0, TABLE)
    rough = np.maximum(t, ggx.MIN_ROUGHNESS)
    return ggx.dfg(rough[None, :], np.maximum(t * t, 1e-4)[:, None], order=24)


def split_sum(roughness: F8, n_dot_v: F8) -> F8:
    """(A, B) f8[n,2] out of the table, bilinear."""
    table = _table()
    x = np.sqrt(np.clip(n_dot_v, 0.0, 1.0)) * (TABLE - 1)
    y = np.clip(roughness, 0.0, 1.0) * (TABLE - 1)
    i, j = (np.minimum(v.astype(np.int64), TABLE - 2) for v in (x, y))
    a, b = (x - i)[:, None], (y - j)[:, None]
    low = table[i, j] * (1.0 - b) + table[i, j + 1] * b
    high = table[i + 1, j] * (1.0 - b) + table[i + 1, j + 1] * b
    result: F8 = low * (1.0 - a) + high * a
    return result


@dataclass(slots=True)
class Lobes:
    """Surfaces seen from `v`, row by row: unit `n` and `v` [n,3], `alpha` [n], f0, even part [n,3], f90 [n].

    `even`: Fms + kd, what leaves as a Lambert surface's light does. `specular_part`: chance to sample the GGX lobe.
    """

    n: F8
    v: F8
    alpha: F8
    f0: F8
    f90: F8
    even: F8
    specular_part: F8
    n_dot_v: F8

    @classmethod
    def make(cls, n: F8, v: F8, roughness: F8, f0: F8, f90: F8, albedo: F8) -> Lobes:
        """`roughness` perceptual [n]; `albedo` [n,3] of the diffuse part."""
        rough = np.clip(roughness, ggx.MIN_ROUGHNESS, 1.0)
        n_dot_v = np.maximum(np.einsum("ij,ij->i", n, v), 1e-4)
        ab = split_sum(rough, n_dot_v)
        single = f0 * ab[:, :1] + f90[:, None] * ab[:, 1:]
        lost = 1.0 - ab.sum(axis=1)[:, None]
        average = f0 + (f90[:, None] - f0) / 21.0
        again = single * average * lost / np.maximum(1.0 - average * lost, 1e-6)
        even = again + albedo * np.maximum(1.0 - single - again, 0.0)
        mirror, rest = single.max(axis=1), even.max(axis=1)
        part = mirror / np.maximum(mirror + rest, 1e-12)
        part = np.where(mirror <= 0.0, 0.0, np.where(rest <= 0.0, 1.0, np.clip(part, 0.1, 0.9)))
        return cls(n, v, rough * rough, f0, f90, even, part, n_dot_v)

    def take(self, rows: NDArray[np.integer] | NDArray[np.bool_]) -> Lobes:
        """Some of the rows."""
        return Lobes(*(getattr(self, name)[rows] for name in self.__slots__))

    def value(self, l: F8) -> tuple[F8, F8]:
        """(f(v, l) n.l [n,3], density of `sample` at l [n]) for unit `l` [n,3]; both 0 below the surface."""
        n_dot_l = np.einsum("ij,ij->i", self.n, l)
        up = n_dot_l > 0.0
        n_dot_l = np.where(up, n_dot_l, 0.0)
        h = l + self.v
        h /= np.maximum(np.linalg.norm(h, axis=1, keepdims=True), 1e-12)
        v_dot_h = np.clip(np.einsum("ij,ij->i", self.v, h), 0.0, 1.0)
        n_cross_h = np.cross(self.n, h)
        n_dot_h = np.maximum(np.einsum("ij,ij->i", self.n, h), 0.0)
        a = n_dot_h * self.alpha
        # D with 1 - (n.h)^2 as |n x h|^2, which keeps its digits
        k = self.alpha / np.maximum(np.einsum("ij,ij->i", n_cross_h, n_cross_h) + a * a, 1e-30)
        d = k * k / np.pi
        visible = ggx.V_SmithGGXCorrelated(self.n_dot_v, n_dot_l, self.alpha)
        fresnel = ggx.F_Schlick(v_dot_h[:, None], self.f0, self.f90[:, None])
        f = (fresnel * (d * visible)[:, None] + self.even / np.pi) * n_dot_l[:, None]
        seen = ggx.G1_Smith(self.n_dot_v, self.alpha) * d / (4.0 * self.n_dot_v)
        pdf = self.specular_part * seen + (1.0 - self.specular_part) * n_dot_l / np.pi
        return f * up[:, None], np.where(up, pdf, 0.0)

    def sample(self, u: F8) -> F8:
        """Directions [n,3] for `u` [n,3] in [0, 1): a lobe by the first, a place in it by the others."""
        tangent, bitangent = basis(self.n)
        frame = np.stack([tangent, bitangent, self.n], axis=1)
        local_v = np.einsum("nij,nj->ni", frame, self.v)
        local_v[:, 2] = np.maximum(local_v[:, 2], 1e-4)
        local_v /= np.linalg.norm(local_v, axis=1, keepdims=True)
        h = ggx.sample_visible_half(u[:, 1:], local_v, self.alpha)
        mirrored = 2.0 * np.einsum("ij,ij->i", local_v, h)[:, None] * h - local_v
        local = np.where((u[:, 0] < self.specular_part)[:, None], mirrored, cosine_hemisphere(u[:, 1:]))
        d = np.einsum("ni,nij->nj", local, frame)
        result: F8 = d / np.maximum(np.linalg.norm(d, axis=1, keepdims=True), 1e-12)
        return result
