"""Quaternions as the three angles that an artist types. Pure maths.

R = Rz(z) Ry(y) Rx(x): turned about the fixed X axis first, then Y, then Z (Blender's "XYZ Euler").
"""

from __future__ import annotations

import math


def euler_from_quaternion(q: tuple[float, ...]) -> tuple[float, float, float]:
    """(x, y, z) in degrees of the quaternion xyzw. At y = +-90 degrees x is taken to be 0."""
    length = math.sqrt(sum(c * c for c in q)) or 1.0
    x, y, z, w = (c / length for c in q)
    sin_y = 2.0 * (w * y - x * z)
    if abs(sin_y) > 1.0 - 1e-12:
        ry = math.copysign(math.pi / 2, sin_y)
        rx, rz = 0.0, 2.0 * math.atan2(z, w)
        return math.degrees(rx), math.degrees(ry), math.degrees(math.remainder(rz, math.tau))
    rx = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    ry = math.asin(sin_y)
    rz = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return math.degrees(rx), math.degrees(ry), math.degrees(rz)


def quaternion_from_euler(degrees: tuple[float, ...]) -> tuple[float, float, float, float]:
    """The unit quaternion xyzw of (x, y, z) in degrees."""
    (cx, sx), (cy, sy), (cz, sz) = ((math.cos(math.radians(a) / 2), math.sin(math.radians(a) / 2)) for a in degrees)
    return (
        sx * cy * cz - cx * sy * sz,
        cx * sy * cz + sx * cy * sz,
        cx * cy * sz - sx * sy * cz,
        cx * cy * cz + sx * sy * sz,
    )
