"""GGX integrals baked ahead of time: the directional albedo table (DFG) and the sample sets of specular prefiltering.

All in float64. alpha = perceptual roughness squared. Sources: Walter et al. 2007 (GGX), Heitz 2014 (height-correlated
Smith), Heitz 2018 (sampling visible normals), Karis 2013 (split sum), Krivanek & Colbert 2008 (filtered samples).
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.assets.dds import write_dds
from engine.assets.texture import TextureAsset

Doubles = NDArray[np.float64]

DFG_SIZE = 128


def hammersley(count: int) -> tuple[Doubles, Doubles]:
    """`count` points of the unit square, f8[count] each: (i + 0.5) / count and the base-2 radical inverse of i."""
    i = np.arange(count, dtype=np.uint32)
    bits = i
    for shift, mask in ((1, 0x55555555), (2, 0x33333333), (4, 0x0F0F0F0F), (8, 0x00FF00FF)):
        bits = (bits >> shift & np.uint32(mask)) | (bits & np.uint32(mask)) << shift
    bits = bits >> np.uint32(16) | bits << np.uint32(16)
    return (i + 0.5) / count, (bits + 0.5) / 2.0**32


def smith_lambda(cosine: Any, alpha: Any) -> Any:
    """Smith's Lambda of GGX for directions at `cosine` to the normal (Heitz 2014, eq. 72)."""
    c2 = np.maximum(np.square(cosine), 1e-30)
    return 0.5 * (np.sqrt(1.0 + np.square(alpha) * (1.0 - c2) / c2) - 1.0)


def dfg(n_dot_v: Any, roughness: Any, samples: int = 4096) -> Doubles:
    """(scale, bias): directional albedo of GGX under white light is F0 * scale + bias (Schlick's Fresnel).

    `n_dot_v` in (0,1], perceptual `roughness` in [0,1], broadcast; f8[...,2]. Height-correlated Smith shadowing.
    By sampling visible normals each sample weighs G2/G1 = (1 + Lv) / (1 + Lv + Ll) in [0,1]: error below 3e-4 at 4096.
    """
    mu, alpha = np.broadcast_arrays(np.asarray(n_dot_v, np.float64), np.maximum(np.square(roughness), 1e-6))
    shape = mu.shape
    mu, alpha = mu.reshape(-1, 1), alpha.reshape(-1, 1)
    u1, u2 = hammersley(samples)
    # Heitz 2018, listing 1: stretch v, sample the projected disk, project back, unstretch
    sine = np.sqrt(np.maximum(0.0, 1.0 - mu * mu))
    vx, vz = alpha * sine, mu
    inverse = 1.0 / np.sqrt(vx * vx + vz * vz)
    vx, vz = vx * inverse, vz * inverse
    radius, phi = np.sqrt(u1), 2.0 * np.pi * u2
    t1 = radius * np.cos(phi)  # along the axis perpendicular to the plane of n and v
    s = 0.5 * (1.0 + vz)
    t2 = (1.0 - s) * np.sqrt(1.0 - t1 * t1) + s * (radius * np.sin(phi))
    t3 = np.sqrt(np.maximum(0.0, 1.0 - t1 * t1 - t2 * t2))
    hx = alpha * (-vz * t2 + vx * t3)
    hy = alpha * t1
    hz = np.maximum(1e-12, vx * t2 + vz * t3)
    norm = 1.0 / np.sqrt(hx * hx + hy * hy + hz * hz)
    hx, hz = hx * norm, hz * norm
    v_dot_h = np.clip(sine * hx + mu * hz, 0.0, 1.0)
    lz = 2.0 * v_dot_h * hz - mu
    lambda_v = smith_lambda(mu, alpha)
    weight = np.where(lz > 0.0, (1.0 + lambda_v) / (1.0 + lambda_v + smith_lambda(lz, alpha)), 0.0)
    fresnel = (1.0 - v_dot_h) ** 5
    bias = (weight * fresnel).mean(-1)
    return np.stack([weight.mean(-1) - bias, bias], -1).reshape(*shape, 2)


def bake_dfg(size: int = DFG_SIZE) -> Doubles:
    """The table f8[size,size,2]: column i is n·v = (i + 0.5) / size, row j is roughness = (j + 0.5) / size."""
    centres = (np.arange(size) + 0.5) / size
    return np.stack([dfg(centres, r) for r in centres])


def write_dfg(path: Path, size: int = DFG_SIZE) -> None:
    """Bake the table and write it as rg16f. Look it up, clamped and linear, at uv = (n·v, perceptual roughness)."""
    table = bake_dfg(size).astype("<f2")
    extras: dict[str, object] = {"content": "ggx-dfg", "x": "n_dot_v", "y": "perceptual_roughness"}
    write_dds(path, TextureAsset("rg16f", size, size, [[table.tobytes()]], extras=extras))


def lobe(roughness: float, count: int) -> tuple[Doubles, Doubles, Doubles]:
    """Samples of the GGX lobe seen head-on (n = v = +z): (directions f8[k,3], weights f8[k], solid angles f8[k]).

    Weights are n·l normalised to sum 1; the solid angle 1 / (count pdf) says how wide the source is to be filtered.
    """
    alpha2 = max(roughness, 1e-3) ** 4
    u1, u2 = hammersley(count)
    cos2 = (1.0 - u1) / (1.0 + (alpha2 - 1.0) * u1)
    cos_h, sin_h, phi = np.sqrt(cos2), np.sqrt(1.0 - cos2), 2.0 * np.pi * u2
    lz = 2.0 * cos2 - 1.0
    keep = lz > 0.0
    d = alpha2 / (np.pi * np.square(cos2 * (alpha2 - 1.0) + 1.0))
    solid_angle = 4.0 / (count * d)  # pdf of l is D (n·h) / (4 v·h), and here v = n
    slope = 2.0 * cos_h * sin_h
    directions = np.stack([slope * np.cos(phi), slope * np.sin(phi), lz], -1)[keep]
    return directions, lz[keep] / lz[keep].sum(), solid_angle[keep]
