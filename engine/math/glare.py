"""Halos in float64: the picture that bloom stands for."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

F8 = NDArray[np.float64]


def halos(image: F8, radius: float, count: int = 6) -> F8:
    """The mean of `image` f8[h,w,c] under Gaussians of `radius` picture heights, half of that, a quarter, and so on.

    The picture is mirrored at its borders. Each weight is the Gaussian's integral over its pixel, so that one that is
    narrower than a pixel leaves the picture as it is.
    """
    height, width = image.shape[:2]
    total = np.zeros_like(image)
    for halo in range(count):
        sigma = radius * height * 0.5**halo
        rows, columns = mirrored_gaussian(height, sigma), mirrored_gaussian(width, sigma)
        total += np.einsum("yi,ijc,xj->yxc", rows, image, columns, optimize=True) / count
    return total


def mirrored_gaussian(count: int, sigma: float) -> F8:
    """f8[count,count], rows of sum 1: what each of `count` pixels in a row gets of each; `sigma` in pixels."""
    if sigma <= 0.0:
        return np.eye(count)
    reach = int(np.ceil(6.0 * sigma)) + 1
    offsets = np.arange(-reach, reach + 1)
    edges = _normal_cdf(np.asarray((np.arange(-reach, reach + 2) - 0.5) / sigma, np.float64))
    weights = np.diff(edges) / (edges[-1] - edges[0])
    rows = np.arange(count)[:, None]
    beyond = np.mod(rows + offsets, 2 * count)
    sources = np.where(beyond < count, beyond, 2 * count - 1 - beyond)
    found = np.zeros((count, count))
    np.add.at(found, (np.broadcast_to(rows, sources.shape), sources), np.broadcast_to(weights, sources.shape))
    return found


def _normal_cdf(x: F8) -> F8:
    from math import erf

    return np.array([0.5 * (1.0 + erf(v / 2.0**0.5)) for v in x])
