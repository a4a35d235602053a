"""GGX integrals baked ahead of time: the directional albedo table (DFG) and the sample sets of specular prefiltering.

All in float64; alpha = perceptual roughness squared. Sources: Walter et al. 2007 (GGX), Karis 2013 (split sum),
Krivanek and Colbert 2008 (samples filtered by their solid angle).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from engine.assets.dds import write_dds
from engine.assets.texture import TextureAsset
from engine.math import ggx
from engine.math.sphere import hammersley

Doubles = NDArray[np.float64]

DFG_SIZE = 64


def bake_dfg(size: int = DFG_SIZE) -> Doubles:
    """The table f8[size,size,2] of (scale, bias): the albedo of GGX under white light is f0 * scale + bias.

    Column i is n·v = i / (size - 1), row j is perceptual roughness = j / (size - 1): texels on the rim, so that a
    look-up there interpolates as anywhere else (with texel centres the outer half texel is clamped, which costs half
    an order: the experiment `dfg_table`). Zero is taken as 1e-3, where both are at their limit.
    """
    at = np.maximum(np.linspace(0.0, 1.0, size), 1e-3)
    return np.stack([ggx.dfg(roughness, at) for roughness in at])


def write_dfg(path: Path, size: int = DFG_SIZE) -> None:
    """Bake the table and write it as rg16f. Look it up, linear, at (n·v, perceptual roughness) (n - 1) / n + 0.5/n."""
    table = bake_dfg(size).astype("<f2")
    extras: dict[str, object] = {"content": "ggx-dfg", "x": "n_dot_v", "y": "perceptual_roughness"}
    write_dds(path, TextureAsset("rg16f", size, size, [[table.tobytes()]], extras=extras))


def lobe(roughness: float, count: int) -> tuple[Doubles, Doubles, Doubles]:
    """Samples of the GGX lobe seen head-on (n = v = +z): (directions f8[k,3], weights f8[k], solid angles f8[k]).

    Weights are n·l normalised to sum 1; the solid angle 1 / (count pdf) says how wide the source is to be filtered.
    """
    alpha2 = max(roughness, 1e-3) ** 4
    u1, u2 = hammersley(count).T
    cos2 = (1.0 - u1) / (1.0 + (alpha2 - 1.0) * u1)
    cos_h, sin_h, phi = np.sqrt(cos2), np.sqrt(1.0 - cos2), 2.0 * np.pi * u2
    lz = 2.0 * cos2 - 1.0
    keep = lz > 0.0
    # The density of l is D (n·h) / (4 v·h), and here v = n.
    d = alpha2 / (np.pi * np.square(cos2 * (alpha2 - 1.0) + 1.0))
    solid_angle = 4.0 / (count * d)
    slope = 2.0 * cos_h * sin_h
    directions = np.stack([slope * np.cos(phi), slope * np.sin(phi), lz], -1)[keep]
    return directions, lz[keep] / lz[keep].sum(), solid_angle[keep]
