"""Poses of many characters in one array, and the quaternion arithmetic on its rows.

    f8[10, m, n]   component, character, node of the rig
       0:3 translation (metres)   3:7 rotation (unit, xyzw)   7:10 scale

Components come first: each operation then runs over m * n numbers that lie side by side. All of it is float64, local.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import InputError

F8 = NDArray[np.float64]

T, R, S = slice(0, 3), slice(3, 7), slice(7, 10)
#: the rows of each path of a clip
ROWS = {"translation": T, "rotation": R, "scale": S}
#: A blended quaternion shorter than this has lost its direction (its parts were opposite).
SHORT = 1e-4


def resting(rest: F8, characters: int) -> F8:
    """f8[10,m,n]: `characters` times the rest pose f8[10,n]."""
    return np.repeat(rest[:, None, :], characters, axis=1)


def check(poses: F8, what: str, like: tuple[int, ...] | None = None) -> None:
    """Raise InputError unless `poses` is f8[10,m,n] (of the shape `like`)."""
    if poses.dtype != np.float64 or poses.ndim != 3 or poses.shape[0] != 10:
        raise InputError(f"{what}: {poses.dtype}{list(poses.shape)}, expected float64[10, characters, nodes]")
    if like is not None and poses.shape != like:
        raise InputError(f"{what}: shape {poses.shape}, expected {like}")


def dot(a: F8, b: F8) -> F8:
    """The inner product over the first axis."""
    result: F8 = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]
    return result


def multiply(a: F8, b: F8) -> F8:
    """The Hamilton product [4,...]: first `b`, then `a`."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return np.stack(
        [
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
            aw * bw - ax * bx - ay * by - az * bz,
        ]
    )


def conjugate(q: F8) -> F8:
    """The inverse of unit quaternions [4,...]."""
    return np.stack([-q[0], -q[1], -q[2], q[3]])


def unit(q: F8, fallback: F8) -> F8:
    """`q` [4,...] made unit; `fallback` where it is shorter than SHORT."""
    length = np.sqrt(dot(q, q))
    good = length >= SHORT
    if good.all():
        return q / length
    return np.where(good, q / np.where(good, length, 1.0), fallback)


def slerp_weights(theta: F8, fraction: F8) -> tuple[F8, F8]:
    """The weights of slerp (Shoemake 1985) between quaternions `theta` apart in 4-space, 0 <= theta <= pi/2.

    No angle is taken as less than 1e-9: the weights are then still those of lerp, and 0/0 cannot happen.
    """
    angle = np.maximum(theta, 1e-9)
    inverse = 1.0 / np.sin(angle)
    return np.sin((1.0 - fraction) * angle) * inverse, np.sin(fraction * angle) * inverse


def angle_4d(a: F8, b: F8) -> F8:
    """The angle in 4-space between unit [4,...], exact for tiny ones: 2 atan2(|b - a|, |a + b|) (Kahan)."""
    d, s = b - a, a + b
    result: F8 = 2.0 * np.arctan2(np.sqrt(dot(d, d)), np.sqrt(dot(s, s)))
    return result


def slerp(a: F8, b: F8, fraction: F8) -> F8:
    """From unit `a` to unit `b` [4,...] along the shorter arc, at constant speed."""
    b = np.where(dot(a, b) < 0.0, -b, b)
    weight_a, weight_b = slerp_weights(angle_4d(a, b), fraction)
    return unit(weight_a * a + weight_b * b, a)


def nlerp(a: F8, b: F8, fraction: F8) -> F8:
    """As slerp, along the same arc but not at constant speed: 0.27 degrees off at most between rotations 60 apart."""
    sign = np.where(dot(a, b) < 0.0, -1.0, 1.0)
    heavier = np.where(fraction > 0.5, b, a)
    return unit((1.0 - fraction) * a + (fraction * sign) * b, heavier)


#: the angle in 4-space up to which `bent_nlerp` is within 1e-6 rad of slerp
BENT_LIMIT = 0.21


def bent_nlerp(a: F8, b: F8, bend: F8, fraction: F8) -> F8:
    """From unit `a` to unit `b` [4,...] on the same side, at nearly constant speed; overwrites both.

    Slerp is nlerp at s = sin(t x) / (sin(t x) + sin((1-t) x)) for the angle x between them; to second order in x that
    is s = t + x^2/3 t (t - 1/2) (t - 1). `bend` is x^2 / 3. No sines: half the time of slerp, and off by x^5 only.
    """
    s = fraction + bend * (fraction * (fraction - 0.5) * (fraction - 1.0))
    b -= a
    b *= s
    b += a
    length = b[0] * b[0]
    for i in range(1, 4):
        length += b[i] * b[i]
    np.sqrt(length, out=length)
    b /= length
    return b


def power(q: F8, exponent: F8) -> F8:
    """`q` [4,...] turned `exponent` times as far about its axis, the shorter way; negative exponents turn back."""
    q = np.where(q[3] < 0.0, -q, q)
    sine = np.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2])
    half = np.arctan2(sine, q[3]) * exponent
    # sin(e h)/sin(h) -> e
    ratio = np.where(sine > 1e-12, np.sin(half) / np.where(sine > 1e-12, sine, 1.0), exponent)
    return unit(np.stack([q[0] * ratio, q[1] * ratio, q[2] * ratio, np.cos(half)]), q)
