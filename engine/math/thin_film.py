"""Iridescence of a thin film in float64: twin of shaders/lib/thin_film.glsl.

Belcour and Barla 2017, "A Practical Extension to Microfacet Theory for the Modeling of Varying Iridescence", with
Schlick's Fresnel at both faces as KHR_materials_iridescence (Khronos, 2022) has it.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.math.ggx import F_Schlick
from engine.math.microfacet import ior_of

F8 = NDArray[np.float64]

_HEIGHT = np.array([5.4856e-13, 4.4201e-13, 5.2481e-13])
_PLACE = np.array([1.6810e06, 1.7953e06, 2.2084e06])
_WIDTH = np.array([4.3278e09, 9.3046e09, 6.6121e09])
_REC709_FROM_XYZ = np.array(
    [[3.2404542, -1.5371385, -0.4985314], [-0.9692660, 1.8760108, 0.0415560], [0.0556434, -0.2040259, 1.0572252]]
)


def sensitivity(path: ArrayLike, shift: ArrayLike) -> F8:
    """Response [..., 3] of the eye, linear Rec. 709, to an optical path [...] in metres; `shift` [..., 3] radians."""
    phase = 2.0 * math.pi * np.asarray(path, np.float64)[..., None]
    s = np.asarray(shift, np.float64)
    xyz = _HEIGHT * np.sqrt(2.0 * math.pi * _WIDTH) * np.cos(_PLACE * phase + s) * np.exp(-_WIDTH * phase**2)
    second = np.cos(2.2399e06 * phase[..., 0] + s[..., 0]) * np.exp(-4.5282e09 * phase[..., 0] ** 2)
    xyz[..., 0] += 9.7470e-14 * math.sqrt(2.0 * math.pi * 4.5282e09) * second
    result: F8 = xyz / 1.0685e-7 @ _REC709_FROM_XYZ.T
    return result


def fresnel(film_ior: ArrayLike, n_dot_v: ArrayLike, thickness: ArrayLike, base_f0: ArrayLike) -> F8:
    """Reflectance [..., 3] in air of a film (index, nanometres) over a base of `base_f0` [..., 3]."""
    c1, film, nm = (np.asarray(v, np.float64) for v in np.broadcast_arrays(n_dot_v, film_ior, thickness))
    c1 = np.clip(c1, 0.0, 1.0)
    t = np.clip(nm / 10.0, 0.0, 1.0)[..., None]
    ior = film
    c2 = np.sqrt(np.maximum(1.0 - (1.0 - c1 * c1) / (ior * ior), 0.0))
    r12 = F_Schlick(c1, ((ior - 1.0) / (ior + 1.0)) ** 2)[..., None]
    through = 1.0 - r12
    base = ior_of(base_f0)
    r1 = (base - ior[..., None]) / (base + ior[..., None])
    r23 = F_Schlick(c2[..., None], r1 * r1)
    shift = np.where(ior < 1.0, 0.0, math.pi)[..., None] + np.where(base < ior[..., None], math.pi, 0.0)
    path = 2.0 * ior * nm * 1e-9 * c2
    r123 = np.clip(r12 * r23, 1e-5, 0.9999)
    rs = through**2 * r23 / (1.0 - r123)
    total, c = r12 + rs, rs - through
    for m in (1, 2):
        c = c * np.sqrt(r123)
        total = total + 2.0 * c * sensitivity(m * path, m * shift)
    # below 10 nm, where no film is seen, it goes over into the bare base
    bare = F_Schlick(c1[..., None], base_f0)
    result: F8 = np.clip(bare + (total - bare) * t * t * (3.0 - 2.0 * t), 0.0, 1.0)
    return result
