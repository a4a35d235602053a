"""Directions on the sphere: sampling patterns, warps, cube-map addressing."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

F8 = NDArray[np.float64]

#: Cube faces in the order of every graphics API and of DDS files.
CUBE_FACES = ("+x", "-x", "+y", "-y", "+z", "-z")


def hammersley(n: int) -> F8:
    """Return the `n` Hammersley points f8[n,2] in [0, 1)^2: (i + 1/2) / n and the base-2 radical inverse of i."""
    index = np.arange(n, dtype=np.uint32)
    bits = index.copy()
    bits = (bits << np.uint32(16)) | (bits >> np.uint32(16))
    for mask, shift in ((0x00FF00FF, 8), (0x0F0F0F0F, 4), (0x33333333, 2), (0x55555555, 1)):
        low = np.uint32(mask)
        bits = ((bits & low) << np.uint32(shift)) | ((bits >> np.uint32(shift)) & low)
    return np.stack([(index + 0.5) / n, bits * 2.0**-32], axis=-1)


def fibonacci(n: int) -> F8:
    """Return `n` nearly even unit directions f8[n,3] (spherical Fibonacci lattice, Keinert et al. 2015)."""
    i = np.arange(n) + 0.5
    y = 1.0 - 2.0 * i / n
    phi = i * math.pi * (3.0 - math.sqrt(5.0))
    ring = np.sqrt(np.maximum(0.0, 1.0 - y * y))
    return np.stack([ring * np.cos(phi), y, ring * np.sin(phi)], axis=-1)


def uniform_sphere(u: ArrayLike) -> F8:
    """Warp `u` [..., 2] in [0, 1)^2 to uniform directions [..., 3]; density 1 / (4 pi)."""
    u = np.asarray(u, np.float64)
    z = 1.0 - 2.0 * u[..., 0]
    return _ring(z, 2.0 * math.pi * u[..., 1])


def cosine_hemisphere(u: ArrayLike) -> F8:
    """Warp `u` [..., 2] in [0, 1)^2 to directions [..., 3] about +Z; density cos / pi (Malley's method)."""
    u = np.asarray(u, np.float64)
    return _ring(np.sqrt(1.0 - u[..., 0]), 2.0 * math.pi * u[..., 1])


def basis(n: ArrayLike) -> tuple[F8, F8]:
    """Return unit tangent and bitangent [..., 3] that make a right-handed frame with unit `n` [..., 3].

    Duff et al. 2017, JCGT 6(1), listing 3: no singular direction.
    """
    n = np.asarray(n, np.float64)
    x, y, z = n[..., 0], n[..., 1], n[..., 2]
    sign = np.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    tangent = np.stack([1.0 + sign * x * x * a, sign * b, -sign * x], axis=-1)
    return tangent, np.stack([b, sign + y * y * a, -y], axis=-1)


def cube_directions(size: int) -> F8:
    """Return unit directions f8[6,size,size,3] through the texel centres of a cube map (OpenGL/D3D face layout).

    Faces in the order of CUBE_FACES, row 0 at the top of the face as stored, column 0 at its left.
    """
    t = (np.arange(size) + 0.5) / size * 2.0 - 1.0
    u, v = np.meshgrid(t, t)  # u along columns, v down the rows
    one = np.ones_like(u)
    faces = [(one, -v, -u), (-one, -v, u), (u, one, v), (u, -one, -v), (u, -v, one), (-u, -v, -one)]
    d = np.stack([np.stack(face, axis=-1) for face in faces])
    result: F8 = d / np.linalg.norm(d, axis=-1, keepdims=True)
    return result


def cube_solid_angles(size: int) -> F8:
    """Return f8[size,size]: each texel's solid angle (steradians) on one cube face; six faces sum to 4 pi.

    The exact difference of atan2(x y, sqrt(x^2 + y^2 + 1)) over the texel's corners.
    """
    edge = np.arange(size + 1) / size * 2.0 - 1.0
    x, y = np.meshgrid(edge, edge)
    area = np.arctan2(x * y, np.sqrt(x * x + y * y + 1.0))
    result: F8 = area[1:, 1:] - area[1:, :-1] - area[:-1, 1:] + area[:-1, :-1]
    return result


def _ring(z: F8, phi: F8) -> F8:
    ring = np.sqrt(np.maximum(0.0, 1.0 - z * z))
    return np.stack([ring * np.cos(phi), ring * np.sin(phi), z], axis=-1)
