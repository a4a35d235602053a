"""Affine transforms: compose and split TRS, invert, look at. [..., 4, 4] float64, column vectors."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.math import quat

F8 = NDArray[np.float64]


def compose(translation: ArrayLike, rotation: ArrayLike, scale: ArrayLike) -> F8:
    """Return T R S [..., 4, 4] of `translation` [..., 3], unit `rotation` [..., 4] and `scale` [..., 3]."""
    t, q, s = (np.asarray(v, np.float64) for v in (translation, rotation, scale))
    shape = np.broadcast_shapes(t.shape[:-1], q.shape[:-1], s.shape[:-1])
    m = np.zeros((*shape, 4, 4))
    m[..., :3, :3] = quat.to_matrix3(q) * s[..., None, :]
    m[..., :3, 3] = t
    m[..., 3, 3] = 1.0
    return m


def decompose(m: ArrayLike) -> tuple[F8, F8, F8]:
    """Split affine `m` [..., 4, 4] into translation [..., 3], unit rotation [..., 4], scale [..., 3].

    `compose` gives `m` back if it is a TRS. A mirrored matrix (determinant < 0) gets a negative x scale. A zero-length
    column gets scale 0 and an axis that completes the others. With shear the rotation is the nearest that keeps the
    first column's direction (Gram-Schmidt), and the scale the columns' lengths.
    """
    m = np.asarray(m, np.float64)
    linear = m[..., :3, :3]
    scale = np.linalg.norm(linear, axis=-2)
    mirrored = np.linalg.det(linear) < 0.0
    axes = linear / np.where(scale > 0.0, scale, 1.0)[..., None, :]
    x, y, z = axes[..., 0], axes[..., 1], axes[..., 2]
    scale = scale.copy()
    scale[..., 0] = np.where(mirrored, -scale[..., 0], scale[..., 0])
    x = np.where(mirrored[..., None], -x, x)
    x = _unit_or(x, _unit_or(np.cross(y, z), _perpendicular(_unit_or(y, z))))
    y = _unit_or(y - _dot(x, y) * x, _unit_or(np.cross(z, x), _perpendicular(x)))
    rotation = quat.from_matrix3(np.stack([x, y, np.cross(x, y)], axis=-1))
    return m[..., :3, 3].copy(), rotation, scale


def inverse_affine(m: ArrayLike) -> F8:
    """Return the inverse of affine `m` [..., 4, 4] whose last row is (0, 0, 0, 1).

    By the adjugate, so the matrix's size does not matter (1e-4 scales have a determinant of 1e-12 and are fine).
    A singular matrix (a zero scale) gets the pseudo-inverse of its linear part: finite, zero along the lost axis.
    """
    m = np.asarray(m, np.float64)
    linear = m[..., :3, :3]
    size = np.max(np.abs(linear), axis=(-2, -1), keepdims=True)
    scaled = linear / np.where(size > 0.0, size, 1.0)
    cofactors = cofactor(scaled)
    det = np.sum(scaled[..., 0, :] * cofactors[..., 0, :], axis=-1)[..., None, None]
    # columns of very different length make the determinant small without making the matrix singular
    lengths = np.prod(np.linalg.norm(scaled, axis=-2), axis=-1)[..., None, None]
    singular = ~(np.abs(det) > 1e-14 * lengths)
    inverse = np.swapaxes(cofactors, -1, -2) / np.where(singular, 1.0, det) / np.where(size > 0.0, size, 1.0)
    if singular.any():
        inverse = np.where(singular, np.linalg.pinv(np.where(np.isfinite(linear), linear, 0.0)), inverse)
    result = np.zeros_like(m)
    result[..., :3, :3] = inverse
    result[..., :3, 3] = -(inverse @ m[..., :3, 3, None])[..., 0]
    result[..., 3, 3] = 1.0
    return result


def cofactor(m: ArrayLike) -> F8:
    """Return the cofactor matrices [..., 3, 3] of `m` [..., 3, 3]: det(m) times the inverse transpose.

    They carry normals from local to world space also where a scale is zero; multiply by the sign of the determinant
    to keep a mirrored mesh's normals outward.
    """
    m = np.asarray(m, np.float64)
    a, b, c = m[..., 0, :], m[..., 1, :], m[..., 2, :]
    return np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=-2)


def look_at(eye: ArrayLike, target: ArrayLike, up: ArrayLike = (0.0, 1.0, 0.0)) -> F8:
    """Return world_from_camera [..., 4, 4] of a camera at `eye` that sees `target` along its -Z.

    Always finite and rigid: with target = eye it looks along -Z, with `up` along the view another up is taken.
    """
    eye, target, up = (np.asarray(v, np.float64) for v in (eye, target, up))
    eye, target, up = np.broadcast_arrays(eye, target, up)
    back = _unit_or(eye - target, np.broadcast_to([0.0, 0.0, 1.0], eye.shape))
    side = np.cross(_unit_or(up, np.broadcast_to([0.0, 1.0, 0.0], eye.shape)), back)
    right = _unit_or(np.where(_dot(side, side) > 1e-20, side, 0.0), _perpendicular(back))
    m = np.zeros((*eye.shape[:-1], 4, 4))
    m[..., :3, 0] = right
    m[..., :3, 1] = np.cross(back, right)
    m[..., :3, 2] = back
    m[..., :3, 3] = eye
    m[..., 3, 3] = 1.0
    return m


def _dot(a: F8, b: F8) -> F8:
    result: F8 = np.sum(a * b, axis=-1, keepdims=True)
    return result


def _unit_or(v: F8, fallback: F8) -> F8:
    """Return `v` normalised, or `fallback` where it is (nearly, against unit inputs) zero or not finite."""
    length = np.linalg.norm(v, axis=-1, keepdims=True)
    good = (length > 1e-150) & np.isfinite(length)
    return np.where(good, v / np.where(good, length, 1.0), fallback)


def _perpendicular(v: F8) -> F8:
    """Return a unit vector at a right angle to `v` (to +Z's plane where `v` is zero)."""
    smallest = np.argmin(np.abs(v), axis=-1)
    axis = np.eye(3)[smallest]
    side = np.cross(v, axis)
    length = np.linalg.norm(side, axis=-1, keepdims=True)
    return np.where(length > 0.0, side / np.where(length > 0.0, length, 1.0), axis)
