"""A 4x4 matrix as translation, rotation and scale, by float64 numpy; what is left over (shear) is reported."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class Decomposed:
    """Translation (3), rotation (unit quaternion xyzw), scale (3); `sheared`: they do not make the matrix again."""

    translation: tuple[float, float, float]
    rotation: tuple[float, float, float, float]
    scale: tuple[float, float, float]
    sheared: bool
    singular: bool


def decompose(matrix: NDArray[np.float64]) -> Decomposed:
    """f8[4,4] (column vectors, last row 0 0 0 1) to T R S; a mirror becomes a negative scale of x.

    With shear the rotation is the nearest one (polar decomposition by SVD: Higham, 1986) and the scale its fit.
    Axes without length get any direction that completes the frame.
    """
    linear = matrix[:3, :3]
    largest = float(np.abs(linear).max())
    translation = (float(matrix[0, 3]), float(matrix[1, 3]), float(matrix[2, 3]))
    if largest == 0.0:
        return Decomposed(translation, (0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0), False, True)
    unitless = linear / largest
    lengths = np.linalg.norm(unitless, axis=0)
    singular = bool(abs(np.linalg.det(unitless)) < 1e-12)
    if singular:
        rotation = _nearest_rotation(unitless)
        scale = np.einsum("ij,ij->j", rotation, unitless)
    else:
        mirror = -1.0 if np.linalg.det(unitless) < 0 else 1.0
        scale = lengths * np.array([mirror, 1.0, 1.0])
        rotation = unitless / scale
        if not np.allclose(rotation.T @ rotation, np.eye(3), atol=1e-6):
            rotation = _nearest_rotation(unitless * np.array([mirror, 1.0, 1.0]))
            scale = np.einsum("ij,ij->j", rotation, unitless)
    sheared = not np.allclose(rotation * scale, unitless, atol=1e-6)
    scaled = scale * largest
    return Decomposed(
        translation, _quaternion(rotation), (float(scaled[0]), float(scaled[1]), float(scaled[2])), sheared, singular
    )


def _nearest_rotation(linear: NDArray[np.float64]) -> NDArray[np.float64]:
    u, _, vt = np.linalg.svd(linear)
    flip = np.diag([1.0, 1.0, float(np.sign(np.linalg.det(u @ vt)))])
    return np.asarray(u @ flip @ vt)


def _quaternion(m: NDArray[np.float64]) -> tuple[float, float, float, float]:
    """Shepperd (1978): divide by the largest of the four components."""
    trace = float(np.trace(m))
    parts = [float(m[0, 0]), float(m[1, 1]), float(m[2, 2]), trace]
    k = int(np.argmax(parts))
    q = [0.0, 0.0, 0.0, 0.0]
    if k == 3:
        q = [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], 1.0 + trace]
    else:
        i, j, l = k, (k + 1) % 3, (k + 2) % 3
        q[i] = 1.0 + 2.0 * float(m[i, i]) - trace
        q[j] = m[j, i] + m[i, j]
        q[l] = m[l, i] + m[i, l]
        q[3] = m[l, j] - m[j, l]
    length = math.sqrt(sum(float(v) ** 2 for v in q))
    x, y, z, w = (float(v) / length for v in q)
    return x, y, z, w
