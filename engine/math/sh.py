"""Spherical harmonics to band 2 (nine coefficients): project radiance, evaluate irradiance.

Real, orthonormal, in the order (0,0) (1,-1) (1,0) (1,1) (2,-2) (2,-1) (2,0) (2,1) (2,2), which in our axes is
1, y, z, x, xy, yz, 3z^2-1, xz, x^2-y^2 (Ramamoorthi and Hanrahan 2001, eq. 3).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

F8 = NDArray[np.float64]

#: The clamped cosine's zonal factors per band: pi, 2 pi / 3, pi / 4 (Ramamoorthi and Hanrahan 2001, eq. 8, 9).
COSINE = np.repeat([math.pi, 2.0 * math.pi / 3.0, math.pi / 4.0], [1, 3, 5])
COSINE.setflags(write=False)


def basis9(direction: ArrayLike) -> F8:
    """Return the nine basis functions [..., 9] at unit `direction` [..., 3]."""
    d = np.asarray(direction, np.float64)
    x, y, z = d[..., 0], d[..., 1], d[..., 2]
    k0, k1, k2 = math.sqrt(1.0 / math.pi) / 2.0, math.sqrt(3.0 / math.pi) / 2.0, math.sqrt(15.0 / math.pi) / 2.0
    k3, k4 = math.sqrt(5.0 / math.pi) / 4.0, math.sqrt(15.0 / math.pi) / 4.0
    return np.stack(
        [
            np.full_like(x, k0),
            k1 * y,
            k1 * z,
            k1 * x,
            k2 * x * y,
            k2 * y * z,
            k3 * (3.0 * z * z - 1.0),
            k2 * x * z,
            k4 * (x * x - y * y),
        ],
        axis=-1,
    )


def project(radiance: ArrayLike, directions: ArrayLike, solid_angles: ArrayLike) -> F8:
    """Return coefficients f8[9,c] of `radiance` [n,c] seen along `directions` [n,3], weighted by `solid_angles` [n]."""
    weights = basis9(directions) * np.asarray(solid_angles, np.float64)[:, None]
    result: F8 = weights.T @ np.asarray(radiance, np.float64)
    return result


def irradiance_coefficients(radiance_coefficients: ArrayLike) -> F8:
    """Return f8[9,c]: the radiance's coefficients convolved with the clamped cosine (irradiance, W/m^2-like)."""
    result: F8 = np.asarray(radiance_coefficients, np.float64) * COSINE[:, None]
    return result


def evaluate(coefficients: ArrayLike, direction: ArrayLike) -> F8:
    """Return [..., c]: the function with `coefficients` [9,c] at unit `direction` [..., 3]. It may be negative."""
    result: F8 = basis9(direction) @ np.asarray(coefficients, np.float64)
    return result
