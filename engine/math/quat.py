"""Unit quaternions, xyzw, float64, batched over leading axes."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

F8 = NDArray[np.float64]

IDENTITY = np.array([0.0, 0.0, 0.0, 1.0])
IDENTITY.setflags(write=False)

#: Below this angle (radians, in 4-space) slerp's weights equal lerp's to 1e-9 relative, and sin/sin loses digits.
_TINY_ANGLE = 1e-4


def normalize(q: ArrayLike) -> F8:
    """Return `q` [..., 4] scaled to unit length; a zero, infinite or NaN quaternion becomes the identity.

    Idempotent. Lengths of 1e-300 to 1e300 neither underflow nor overflow.
    """
    q = np.asarray(q, np.float64)
    with np.errstate(over="ignore", invalid="ignore"):
        square = np.einsum("...i,...i->...", q, q)
    if ((square > 1e-200) & (square < 1e200)).all():
        # unit within rounding stays as it is: normalising twice changes nothing, and so does load and save
        return q / np.where(np.abs(square - 1.0) <= 1e-15, 1.0, np.sqrt(square))[..., None]
    # divide by the largest component first
    largest = np.max(np.abs(q), axis=-1, keepdims=True)
    good = (largest > 0.0) & np.isfinite(largest)
    scaled = np.where(good, q, IDENTITY) / np.where(good, largest, 1.0)
    result: F8 = scaled / np.sqrt(np.sum(scaled * scaled, axis=-1, keepdims=True))
    return result


def from_axis_angle(axis: ArrayLike, angle: ArrayLike) -> F8:
    """Return the rotation by `angle` [...] radians about `axis` [..., 3] (any length; zero gives the identity)."""
    axis = np.asarray(axis, np.float64)
    half = np.asarray(angle, np.float64)[..., None] * 0.5
    length = np.linalg.norm(axis, axis=-1, keepdims=True)
    unit = axis / np.where(length > 0.0, length, 1.0)
    xyz = unit * np.sin(half)
    result = np.empty((*xyz.shape[:-1], 4))
    result[..., :3] = xyz
    result[..., 3:] = np.where(length > 0.0, np.cos(half), 1.0)
    return result


def conjugate(q: ArrayLike) -> F8:
    """Return the inverse of unit `q` [..., 4]."""
    result: F8 = np.asarray(q, np.float64) * np.array([-1.0, -1.0, -1.0, 1.0])
    return result


def multiply(a: ArrayLike, b: ArrayLike) -> F8:
    """Return the Hamilton product a b [..., 4]: the rotation that applies `b` first, then `a`."""
    ax, ay, az, aw = np.moveaxis(np.asarray(a, np.float64), -1, 0)
    bx, by, bz, bw = np.moveaxis(np.asarray(b, np.float64), -1, 0)
    return np.stack(
        [
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
            aw * bw - ax * bx - ay * by - az * bz,
        ],
        axis=-1,
    )


def rotate(q: ArrayLike, v: ArrayLike) -> F8:
    """Rotate vectors `v` [..., 3] by unit `q` [..., 4]: v + 2 w (u x v) + 2 u x (u x v)."""
    q, v = np.asarray(q, np.float64), np.asarray(v, np.float64)
    u, w = q[..., :3], q[..., 3:]
    twice = 2.0 * np.cross(u, v)
    result: F8 = v + w * twice + np.cross(u, twice)
    return result


def angle_between(a: ArrayLike, b: ArrayLike) -> F8:
    """Return the rotation angle [...] in [0, pi] from unit `a` to unit `b`, exact for tiny angles (Kahan's form)."""
    a, b = np.asarray(a, np.float64), np.asarray(b, np.float64)
    b = np.where(np.sum(a * b, axis=-1, keepdims=True) < 0.0, -b, b)
    angle: F8 = 4.0 * np.arctan2(np.linalg.norm(b - a, axis=-1), np.linalg.norm(a + b, axis=-1))
    return angle


def slerp(a: ArrayLike, b: ArrayLike, t: ArrayLike) -> F8:
    """Interpolate unit `a` to unit `b` [..., 4] along the shorter arc at constant speed; `t` [...] in [0, 1].

    Shoemake 1985. The angle comes from 2 atan2(|b - a|, |a + b|), which keeps its digits where acos(dot) gives 0
    (Kahan); below 1e-4 radians a normalised lerp takes over.
    """
    a, b = np.asarray(a, np.float64), np.asarray(b, np.float64)
    t = np.asarray(t, np.float64)[..., None]
    b = np.where(np.sum(a * b, axis=-1, keepdims=True) < 0.0, -b, b)
    theta = 2.0 * np.arctan2(
        np.linalg.norm(b - a, axis=-1, keepdims=True), np.linalg.norm(a + b, axis=-1, keepdims=True)
    )
    tiny = theta < _TINY_ANGLE
    sine = np.where(tiny, 1.0, np.sin(theta))
    weight_a = np.where(tiny, 1.0 - t, np.sin((1.0 - t) * theta) / sine)
    weight_b = np.where(tiny, t, np.sin(t * theta) / sine)
    return normalize(weight_a * a + weight_b * b)


def to_matrix3(q: ArrayLike, out: F8 | None = None) -> F8:
    """Return the rotation matrices [..., 3, 3] of unit `q` [..., 4], written to `out` where given."""
    q = np.asarray(q, np.float64)
    if out is None:
        out = np.empty((*q.shape[:-1], 3, 3))
    x, y, z, w = (np.ascontiguousarray(q[..., i]) for i in range(4))
    x2, y2, z2 = x + x, y + y, z + z
    xx, yy, zz = x * x2, y * y2, z * z2
    xy, xz, yz = x * y2, x * z2, y * z2
    wx, wy, wz = w * x2, w * y2, w * z2
    out[..., 0, 0] = 1.0 - (yy + zz)
    out[..., 0, 1] = xy - wz
    out[..., 0, 2] = xz + wy
    out[..., 1, 0] = xy + wz
    out[..., 1, 1] = 1.0 - (xx + zz)
    out[..., 1, 2] = yz - wx
    out[..., 2, 0] = xz - wy
    out[..., 2, 1] = yz + wx
    out[..., 2, 2] = 1.0 - (xx + yy)
    return out


def from_matrix3(m: ArrayLike) -> F8:
    """Return unit quaternions [..., 4] of rotation matrices `m` [..., 3, 3]; w >= 0 where it is not 0.

    Shepperd 1978: the largest of the four squared components is found first, so no division is by a small number.
    """
    m = np.asarray(m, np.float64)
    m00, m11, m22 = m[..., 0, 0], m[..., 1, 1], m[..., 2, 2]
    trace = m00 + m11 + m22
    choice = np.argmax(np.stack([m00, m11, m22, trace], axis=-1), axis=-1)
    yz, zx, xy = m[..., 2, 1] - m[..., 1, 2], m[..., 0, 2] - m[..., 2, 0], m[..., 1, 0] - m[..., 0, 1]
    s01, s02, s12 = m[..., 0, 1] + m[..., 1, 0], m[..., 0, 2] + m[..., 2, 0], m[..., 1, 2] + m[..., 2, 1]
    candidates = np.stack(
        [
            np.stack([1.0 + m00 - m11 - m22, s01, s02, yz], axis=-1),
            np.stack([s01, 1.0 - m00 + m11 - m22, s12, zx], axis=-1),
            np.stack([s02, s12, 1.0 - m00 - m11 + m22, xy], axis=-1),
            np.stack([yz, zx, xy, 1.0 + trace], axis=-1),
        ],
        axis=-2,
    )
    q = normalize(np.take_along_axis(candidates, choice[..., None, None], axis=-2)[..., 0, :])
    return np.where(q[..., 3:] < 0.0, -q, q)
