"""Texture transforms: from a 2x3 matrix on uv with the origin at the bottom left to our offset, rotation and scale."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from engine.assets.material import TextureRef


def apply_matrix(matrix: Sequence[Sequence[float]], reference: TextureRef) -> bool:
    """Set the reference's uv transform; False where the matrix has shear, which is lost.

    With F: v -> 1 - v, our matrix is F M F; it is taken apart as T(offset) R(rotation) S(scale)
    (KHR_texture_transform, 2018), where R S = [[c sx, s sy], [-s sx, c sy]].
    """
    m = np.eye(3)
    m[:2] = matrix
    flip = np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 1.0], [0.0, 0.0, 1.0]])
    a = flip @ m @ flip
    sx = math.hypot(a[0, 0], a[1, 0])
    if not np.isfinite(a).all() or sx < 1e-12:
        return False
    rotation = math.atan2(-a[1, 0], a[0, 0])
    sy = float(a[0, 0] * a[1, 1] - a[0, 1] * a[1, 0]) / sx
    c, s = math.cos(rotation), math.sin(rotation)
    reference.offset = (float(a[0, 2]), float(a[1, 2]))
    reference.rotation = 0.0 if abs(rotation) < 1e-12 else rotation
    reference.scale = (sx, sy)
    rebuilt = np.array([[c * sx, s * sy], [-s * sx, c * sy]])
    return bool(np.abs(rebuilt - a[:2, :2]).max() <= 1e-6 * max(1.0, float(np.abs(a).max())))
