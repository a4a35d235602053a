"""Floats to the normalised integers of the vertex streams (OpenGL 4.6 specification, section 2.3.5)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray


def snorm16(values: ArrayLike) -> NDArray[np.int16]:
    """round(clamp(v, -1, 1) * 32767) as i2; the GPU reads i / 32767. Non-finite values become 0."""
    clean = np.nan_to_num(np.asarray(values, np.float32), nan=0.0, posinf=0.0, neginf=0.0)
    return np.asarray(np.rint(np.clip(clean, -1.0, 1.0) * np.float32(32767))).astype(np.int16)


def unorm16(values: ArrayLike) -> NDArray[np.uint16]:
    """round(clamp(v, 0, 1) * 65535) as u2; the GPU reads i / 65535. Non-finite values become 0."""
    clean = np.nan_to_num(np.asarray(values, np.float64), nan=0.0, posinf=0.0, neginf=0.0)
    return np.asarray(np.rint(np.clip(clean, 0.0, 1.0) * 65535.0)).astype(np.uint16)


def snorm16_vectors(vectors: ArrayLike, w: ArrayLike | float = 0.0) -> NDArray[np.int16]:
    """Unit vectors [n,3] with a fourth component w (scalar or [n]) as i2[n,4]."""
    xyz = np.asarray(vectors, np.float32)
    out = np.empty((len(xyz), 4), "<i2")
    out[:, :3] = snorm16(xyz)
    out[:, 3] = snorm16(np.broadcast_to(np.asarray(w, np.float32), (len(xyz),)))
    return out
