"""The G-buffer: which layout a set of materials needs, its textures, and the float64 twin of its packing.

Normals are octahedral in 2 x 16 bits (error 0.004 degrees at most); colours, roughness and reflectances have 16 bits a
channel (error 7.6e-6), so that a white furnace and a grey card keep their values. See shaders/lib/gbuffer.glsl.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

F8 = NDArray[np.float64]

#: layout -> formats of gbuffer0, gbuffer1, gbuffer2
LAYOUTS: tuple[tuple[str, ...], ...] = (("rg32ui", "r32ui"), ("rg32ui", "rg32ui"), ("rg32ui", "rg32ui", "r32ui"))
LAYOUT_NAMES = ("dielectric", "metal", "full")
BYTES = {"r32ui": 4, "rg32ui": 8}

#: word 0 of what reflects nothing: no normal packs to it
NO_REFLECTION = 0x80008000


def texture_names(layout: int) -> tuple[str, ...]:
    return tuple(f"gbuffer{i}" for i in range(len(LAYOUTS[layout])))


def bytes_per_pixel(layout: int) -> int:
    """Without depth."""
    return sum(BYTES[format] for format in LAYOUTS[layout])


def layout_of(rows: NDArray[np.void]) -> int:
    """The narrowest layout that holds these rows of a material table (fields as in surface.effect.toml)."""
    names = rows.dtype.names or ()
    if len(rows) == 0:
        return 0
    plain = {"specular": 1.0, "specular_color": 1.0}
    if not {"metallic", "ior", *plain} <= set(names):
        return 2
    if any((rows[name] != value).any() for name, value in plain.items()):
        return 2
    return int((rows["metallic"] != 0.0).any() or (rows["ior"] != 1.5).any())


def widest(layouts: Iterable[int]) -> int:
    return max(layouts, default=0)


# --- float64 twin of shaders/lib/gbuffer.glsl ---


def octahedral(n: F8) -> F8:
    """f8[k,3] unit -> f8[k,2] in [-1,1] (Cigolle et al. 2014)."""
    p = n[:, :2] / np.maximum(np.abs(n).sum(axis=1, keepdims=True), 1e-20)
    side = np.where(p >= 0.0, 1.0, -1.0)
    folded: F8 = np.where(n[:, 2:] < 0.0, (1.0 - np.abs(p[:, ::-1])) * side, p)
    return folded


def from_octahedral(p: F8) -> F8:
    n = np.concatenate([p, 1.0 - np.abs(p).sum(axis=1, keepdims=True)], axis=1)
    side = np.where(p >= 0.0, 1.0, -1.0)
    n[:, :2] = np.where(n[:, 2:] < 0.0, (1.0 - np.abs(n[:, 1::-1])) * side, n[:, :2])
    unit: F8 = n / np.linalg.norm(n, axis=1, keepdims=True)
    return unit


def unorm16(x: F8) -> F8:
    """What is left of x in [0,1] after 16 bits."""
    kept: F8 = np.round(np.clip(x, 0.0, 1.0) * 65535.0) / 65535.0
    return kept


def snorm16(x: F8) -> F8:
    kept: F8 = np.round(np.clip(x, -1.0, 1.0) * 32767.0) / 32767.0
    return kept


def stored(
    layout: int, n: F8, base_color: F8, metallic: F8, roughness: F8, dielectric_f0: F8, specular: F8
) -> dict[str, F8]:
    """What `unpack_surface(pack_surface(...))` gives: n, f0, f90, diffuse_albedo, alpha by name."""
    m = metallic[:, None]
    f90 = np.ones(len(n))
    if layout == 2:
        f0 = unorm16(dielectric_f0 * (1.0 - m) + base_color * m)
        diffuse = unorm16(base_color * (1.0 - m))
        f90 = unorm16(specular * (1.0 - metallic) + metallic)
    else:
        color = unorm16(base_color)
        kept = unorm16(m) if layout == 1 else np.zeros_like(m)
        dielectric = unorm16(dielectric_f0[:, :1]) if layout == 1 else np.full_like(m, 0.04)
        f0 = dielectric * (1.0 - kept) + color * kept if layout == 1 else np.full((len(n), 3), 0.04)
        diffuse = color * (1.0 - kept)
    alpha = unorm16(roughness) ** 2
    return {
        "n": from_octahedral(snorm16(octahedral(n))), "f0": f0, "f90": f90, "diffuse_albedo": diffuse, "alpha": alpha,
    }  # fmt: skip
