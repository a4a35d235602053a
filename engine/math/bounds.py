"""Bounding boxes (min, max) and spheres (center, radius), batched; also carried through affine transforms."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

F8 = NDArray[np.float64]


def of_points(points: ArrayLike) -> tuple[F8, F8]:
    """Return (min f8[3], max f8[3]) of the finite `points` [n,3]; both zero if there are none."""
    points = np.asarray(points, np.float64).reshape(-1, 3)
    points = points[np.isfinite(points).all(axis=1)]
    if len(points) == 0:
        return np.zeros(3), np.zeros(3)
    return points.min(axis=0), points.max(axis=0)


def of_spheres(centers: ArrayLike, radii: ArrayLike) -> tuple[F8, F8]:
    """Return (min f8[3], max f8[3]) of the box round spheres `centers` [n,3], `radii` [n]; zero if none is finite."""
    centers, radii = np.asarray(centers, np.float64), np.asarray(radii, np.float64)
    if len(radii) == 0:
        return np.zeros(3), np.zeros(3)
    # axis by axis: contiguous, and three times as fast as reducing [n,3] over its first axis
    low = np.array([(centers[:, axis] - radii).min() for axis in range(3)])
    high = np.array([(centers[:, axis] + radii).max() for axis in range(3)])
    if np.isfinite(low).all() and np.isfinite(high).all():
        return low, high
    good = np.isfinite(centers).all(axis=1) & np.isfinite(radii)
    return of_spheres(centers[good], radii[good]) if not good.all() else (low, high)


def sphere_of_box(low: ArrayLike, high: ArrayLike) -> tuple[F8, F8]:
    """Return (center [..., 3], radius [...]) of the spheres round boxes `low`, `high` [..., 3]."""
    low, high = np.asarray(low, np.float64), np.asarray(high, np.float64)
    return (low + high) / 2.0, np.linalg.norm(high - low, axis=-1) / 2.0


def transform_box(m: ArrayLike, low: ArrayLike, high: ArrayLike) -> tuple[F8, F8]:
    """Return the boxes round boxes `low`, `high` [..., 3] transformed by affine `m` [..., 3|4, 4] (Arvo 1990)."""
    m, low, high = (np.asarray(v, np.float64) for v in (m, low, high))
    center, half = (low + high) / 2.0, (high - low) / 2.0
    linear = m[..., :3, :3]
    new_center = (linear @ center[..., None])[..., 0] + m[..., :3, 3]
    new_half = (np.abs(linear) @ half[..., None])[..., 0]
    return new_center - new_half, new_center + new_half


def largest_scale(linear: ArrayLike) -> F8:
    """Return [...]: an upper bound of how much `linear` [..., 3, 3] stretches any vector, exact for R S and S R.

    sqrt of the largest row sum of |M^T M| or |M M^T|, whichever is less: Gershgorin's bound of the largest singular
    value. With shear it is at most sqrt(3) too large.
    """
    m = np.asarray(linear, np.float64)
    parts = [[np.ascontiguousarray(m[..., i, j]) for j in range(3)] for i in range(3)]
    bound = _gershgorin([[parts[i][j] for i in range(3)] for j in range(3)])
    size: F8 = np.sqrt(np.minimum(bound, _gershgorin(parts)))
    return size


def _gershgorin(v: list[list[F8]]) -> F8:
    """Return the largest row sum of |v v^T| [...] for three vectors of three components each."""
    xx, yy, zz = (w[0] * w[0] + w[1] * w[1] + w[2] * w[2] for w in v)
    xy, xz, yz = (
        np.abs(a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) for a, b in ((v[0], v[1]), (v[0], v[2]), (v[1], v[2]))
    )
    result: F8 = np.maximum(np.maximum(xx + xy + xz, yy + xy + yz), zz + xz + yz)
    return result


def transform_sphere(m: ArrayLike, center: ArrayLike, radius: ArrayLike) -> tuple[F8, F8]:
    """Return (center [..., 3], radius [...]) of a sphere that holds the given one transformed by `m` [..., 3|4, 4]."""
    m, center = np.asarray(m, np.float64), np.asarray(center, np.float64)
    linear = m[..., :3, :3]
    return (linear @ center[..., None])[..., 0] + m[..., :3, 3], np.asarray(radius) * largest_scale(linear)
