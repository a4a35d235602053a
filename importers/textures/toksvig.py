"""Roughness that makes up for bumps which a mip cannot show.

Averaged normals get shorter the more they differ: |N| = 1 - sigma^2 for slopes of variance sigma^2 (small angles), so
(1 - |N|) / |N| is that variance, and a lobe of width alpha becomes alpha'^2 = alpha^2 + 2 (1 - |N|) / |N|.
Source: Toksvig 2005, "Mipmapping Normal Maps", in terms of GGX's alpha = roughness^2 instead of a Phong exponent
(s ~ 2 / alpha^2; Walter et al. 2007).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from importers.textures.mips import normalised, resample

Floats = NDArray[np.float32]


def rougher(level: Floats, normals: Floats) -> Floats:
    """A mip of a metal_rough image f4[h,w,c] (G roughness), widened for `normals` f4[H,W,3] of mip 0."""
    height, width = level.shape[:2]
    mean = resample(normalised(normals), width, height, "box")
    length = np.clip(np.sqrt((mean * mean).sum(-1)), 1e-3, 1.0)
    alpha = level[..., 1] ** 2
    out = level.copy()
    out[..., 1] = np.sqrt(np.sqrt(np.minimum(alpha * alpha + 2.0 * (1.0 - length) / length, 1.0)))
    return out
