"""The colour of a black body (the Planckian locus) in scene-linear Rec.709."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.math.color import LUMINANCE

F8 = NDArray[np.float64]

#: kelvin; below, nothing of it can be seen; above, the colour no longer changes
LOWEST, HIGHEST = 500.0, 1e6
#: second radiation constant h c / k (CODATA 2018), m K
_C2 = 1.438776877e-2
#: Wyman, Sloan and Shirley 2013, "Simple Analytic Approximations to the CIE XYZ Color Matching Functions", eq. 4 and
#: table 1 (CIE 1931, 2 degrees): height, middle, width below and above it (nm) of each lobe
_LOBES = (
    ((1.056, 599.8, 37.9, 31.0), (0.362, 442.0, 16.0, 26.7), (-0.065, 501.1, 20.4, 26.2)),
    ((0.821, 568.8, 46.9, 40.5), (0.286, 530.9, 16.3, 31.1)),
    ((1.217, 437.0, 11.8, 36.0), (0.681, 459.0, 26.0, 13.8)),
)
#: IEC 61966-2-1:1999, F.8
_REC709_FROM_XYZ = np.array(
    [
        [3.2406255, -1.5372080, -0.4986286],
        [-0.9689307, 1.8757561, 0.0415175],
        [0.0557101, -0.2040211, 1.0569959],
    ]
)
_TABLE = 4096


def planckian_xyz(kelvin: ArrayLike) -> F8:
    """Return XYZ [..., 3] of a black body with Y = 1, its spectrum (Planck 1901) summed over 360 to 830 nm.

    Temperatures are held within LOWEST..HIGHEST; NaN counts as LOWEST.
    """
    t = np.clip(np.nan_to_num(np.asarray(kelvin, np.float64), nan=LOWEST), LOWEST, HIGHEST)
    wave = np.arange(360.0, 831.0, 1.0)
    metres = wave * 1e-9
    exponent = _C2 / (metres * t[..., None])
    # against the value at 700 nm, which is never the smallest, so that a cold body does not underflow
    power = np.exp(_C2 / (700e-9 * t[..., None]) - exponent) / (-np.expm1(-exponent)) / metres**5
    xyz: F8 = power @ np.stack([_response(lobes, wave) for lobes in _LOBES], axis=1)
    return xyz / xyz[..., 1:2]


def planckian_xy(kelvin: ArrayLike) -> F8:
    """Return the CIE 1931 chromaticity [..., 2] of a black body."""
    xyz = planckian_xyz(kelvin)
    result: F8 = xyz[..., :2] / xyz.sum(axis=-1, keepdims=True)
    return result


def black_body(kelvin: ArrayLike) -> F8:
    """Return linear Rec.709 [..., 3] of luminance 1 of a black body; D65 white (about 6500 K) is near (1, 1, 1).

    What lies outside the gamut (blue below about 1900 K) is cut off and the luminance made 1 again. From a table over
    1/T: within 1e-5 of the exact sum.
    """
    t = np.clip(np.nan_to_num(np.asarray(kelvin, np.float64), nan=LOWEST), LOWEST, HIGHEST)
    inverse, colors = _table()
    result: F8 = np.stack([np.interp(1.0 / t, inverse, colors[:, i]) for i in range(3)], axis=-1)
    return result


def rec709_of(xyz: F8) -> F8:
    """Return linear Rec.709 [..., 3] of luminance 1 with the chromaticity of `xyz`, cut to the gamut."""
    rgb = np.maximum(xyz @ _REC709_FROM_XYZ.T, 0.0)
    result: F8 = rgb / (rgb @ LUMINANCE)[..., None]
    return result


@cache
def _table() -> tuple[F8, F8]:
    inverse = np.linspace(1.0 / HIGHEST, 1.0 / LOWEST, _TABLE)
    return inverse, rec709_of(planckian_xyz(1.0 / inverse))


def _response(lobes: tuple[tuple[float, float, float, float], ...], wave: F8) -> F8:
    out = np.zeros_like(wave)
    for height, middle, below, above in lobes:
        width = np.where(wave < middle, below, above)
        out += height * np.exp(-0.5 * ((wave - middle) / width) ** 2)
    return out
