"""Pixels -> TextureAsset: the role decides format, colour space and mip filter, the preset decides the effort.

    role                    compressed   uncompressed   mips
    color, emissive         bc7-srgb     rgba8-srgb     linear light, weighted by alpha; alpha coverage on demand
    normal                  bc5 (x, y)   rg8            renormalised; z = sqrt(1 - x^2 - y^2)
    metal_rough, data       bc7          rgba8          as they are
    occlusion, mask         bc4 (red)    r8             as they are
    hdr                     bc6h         rgba16f        as they are

BC1 is never chosen: BC7 ultrafast encodes fast enough and is 7 dB better.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.assets.records import did_you_mean
from engine.assets.texture import TextureAsset
from engine.core.errors import UsageError
from importers.settings import ImportSettings
from importers.textures.blocks import encode_blocks
from importers.textures.mips import chain, keep_coverage, normal_chain, resample
from importers.textures.toksvig import rougher

Floats = NDArray[np.float32]
Pixels = NDArray[Any]

#: role -> (compressed, uncompressed, channels)
ROLES = {
    "color": ("bc7-srgb", "rgba8-srgb", 4), "emissive": ("bc7-srgb", "rgba8-srgb", 4), "normal": ("bc5", "rg8", 2),
    "metal_rough": ("bc7", "rgba8", 4), "data": ("bc7", "rgba8", 4), "occlusion": ("bc4", "r8", 1),
    "mask": ("bc4", "r8", 1), "hdr": ("bc6h", "rgba16f", 4),
}  # fmt: skip

#: preset -> (BC7 profile, BC6H profile, mip filter)
_PRESETS = {
    "draft": ("ultrafast", "veryfast", "box"),
    "normal": ("ultrafast", "fast", "box"),
    "high": ("basic", "basic", "kaiser"),
    "final": ("slow", "slow", "kaiser"),
}

#: added to alpha when colours are averaged by it, so that invisible texels keep a colour
_ALPHA_FLOOR = np.float32(1.0 / 512.0)


def encode(
    pixels: Pixels, role: str, settings: ImportSettings, *,
    alpha_cutoff: float | None = None, wrap: bool = True, preset: str = "", threads: int = 0,
    bumps: Pixels | None = None,
) -> TextureAsset:  # fmt: skip
    """Encode with all mips. `pixels`: u1 or u2[h,w,4], or f4[h,w,3] (hdr), as `image.decode` gives them.

    `alpha_cutoff`: keep the alpha test's coverage in every mip. `wrap`: filter across the border, as repeating
    textures want (Kaiser only). `preset` overrides the settings' own. The bytes do not depend on `threads`. `bumps`:
    the normal map over a metal_rough image, whose mips then get rougher where it is averaged away (toksvig.py).
    Raises UsageError for an unknown role.
    """
    if role not in ROLES:
        raise UsageError(f"unknown texture role {role!r}", hint=did_you_mean(role, ROLES))
    bc7, bc6h, kind = _PRESETS[preset or settings.quality]
    compressed, plain, channels = ROLES[role]
    if role == "hdr" and pixels.shape[2] == 4 and pixels.dtype != np.float32:
        pixels = _SRGB_TO_LINEAR[_bytes(pixels)][..., :3]
    if settings.max_texture_size:
        pixels = _fit(pixels, role, settings.max_texture_size)
    height, width = pixels.shape[:2]
    images: list[Pixels]
    if role == "hdr":
        images = [_half(level) for level in chain(pixels.astype(np.float32), "box")]
    elif role == "normal":
        vectors = _unit(pixels[..., :3])
        if settings.flip_green:
            vectors = vectors * np.array([1, -1, 1], np.float32) + np.array([0, 1, 0], np.float32)
        vectors = vectors * np.float32(2.0) - np.float32(1.0)
        images = [_quantise(v[..., :2] * np.float32(0.5) + np.float32(0.5)) for v in normal_chain(vectors)]
    elif compressed.endswith("-srgb"):
        images = [*_color_chain(pixels, kind, wrap, alpha_cutoff)]
    else:
        first = _bytes(pixels)[..., :channels]
        levels = chain(_unit(pixels[..., :channels]), kind, wrap=wrap)
        if role == "metal_rough" and bumps is not None:
            vectors = _unit(bumps[..., :3]) * np.float32(2.0) - np.float32(1.0)
            levels = [levels[0], *(rougher(level, vectors) for level in levels[1:])]
        images = [np.ascontiguousarray(first), *(_quantise(level) for level in levels[1:])]
    format = compressed if settings.compress else plain
    profile = bc6h if role == "hdr" else bc7
    if compressed.startswith("bc7") and bool((images[0][..., 3] != 255).any()):
        profile = f"alpha_{profile}"
    levels_bytes = [
        encode_blocks(image, format, profile, threads) if settings.compress else image.tobytes() for image in images
    ]
    return TextureAsset(format, width, height, [levels_bytes])


def _color_chain(pixels: Pixels, kind: str, wrap: bool, alpha_cutoff: float | None) -> list[NDArray[np.uint8]]:
    """sRGB mips u1[h,w,4], averaged in linear light and weighted by alpha; mip 0 is the source itself."""
    first = _bytes(pixels)
    opaque = bool((first[..., 3] == 255).all())
    if opaque:
        levels = _linear_chain(first[..., :3], kind, wrap)
        return [first, *(_with_alpha(_to_srgb(level)) for level in levels[1:])]
    linear = np.empty(first.shape, np.float32)
    alpha = first[..., 3].astype(np.float32) / np.float32(255.0)
    linear[..., :3] = _SRGB_TO_LINEAR[first[..., :3]] * (alpha + _ALPHA_FLOOR)[..., None]
    linear[..., 3] = alpha
    levels = chain(linear, kind, wrap=wrap)
    for level in levels:
        level[..., 3] = np.clip(level[..., 3], 0.0, 1.0)
        level[..., :3] /= level[..., 3:] + _ALPHA_FLOOR
    if alpha_cutoff is not None:
        levels = keep_coverage(levels, alpha_cutoff)
    out = [first]
    for level in levels[1:]:
        image = np.empty(level.shape, np.uint8)
        image[..., :3] = _to_srgb(level[..., :3])
        image[..., 3] = _quantise(level[..., 3])
        out.append(image)
    return out


def _linear_chain(rgb: NDArray[np.uint8], kind: str, wrap: bool) -> list[Floats]:
    """Linear mips of sRGB u1[h,w,3]; [0] is not used and left empty where the image need not be whole in memory."""
    height, width = rgb.shape[:2]
    if kind != "box" or height % 2 or width % 2:
        return chain(_SRGB_TO_LINEAR[rgb], kind, wrap=wrap)
    half = np.empty((height // 2, width // 2, 3), np.float32)
    rows = max(2, (1 << 20) // max(1, width) & ~1)
    for y in range(0, height, rows):
        strip = _SRGB_TO_LINEAR[rgb[y : y + rows]]
        half[y // 2 : (y + rows) // 2] = resample(strip, width // 2, strip.shape[0] // 2, "box")
    return [np.empty((0, 0, 3), np.float32), *chain(half, "box")]


def _fit(pixels: Pixels, role: str, limit: int) -> Pixels:
    """Halve until both sizes are at most `limit`."""
    height, width = pixels.shape[:2]
    small_width, small_height = width, height
    while max(small_width, small_height) > limit:
        small_width, small_height = max(1, small_width // 2), max(1, small_height // 2)
    if (small_width, small_height) == (width, height):
        return pixels
    if pixels.dtype == np.float32:
        return resample(pixels, small_width, small_height, "box")
    value = _unit(pixels)
    if ROLES[role][0].endswith("-srgb"):
        alpha = value[..., 3:] + _ALPHA_FLOOR
        rgb = _decode(value[..., :3]) * alpha
        small = resample(np.concatenate([rgb, value[..., 3:]], -1), small_width, small_height, "box")
        small[..., :3] = _encode(small[..., :3] / (small[..., 3:] + _ALPHA_FLOOR))
    else:
        small = resample(value, small_width, small_height, "box")
    # 16 bits, whatever came in: the next step rounds once
    return (np.clip(small, 0.0, 1.0) * 65535.0 + 0.5).astype(np.uint16)


def _bytes(pixels: Pixels) -> NDArray[np.uint8]:
    if pixels.dtype == np.uint16:
        return ((pixels.astype(np.uint32) * 255 + 32767) // 65535).astype(np.uint8)
    return pixels if pixels.dtype == np.uint8 else _quantise(pixels)


def _unit(pixels: Pixels) -> Floats:
    """0..1 of the stored values."""
    if pixels.dtype == np.float32:
        return pixels
    result: Floats = pixels.astype(np.float32) / np.float32(np.iinfo(pixels.dtype).max)
    return result


def _quantise(values: Floats) -> NDArray[np.uint8]:
    return (np.clip(values, 0.0, 1.0) * np.float32(255.0) + np.float32(0.5)).astype(np.uint8)


def _half(rgb: Floats) -> NDArray[np.float16]:
    out = np.ones((*rgb.shape[:2], 4), "<f2")
    out[..., :3] = np.clip(rgb[..., :3], 0.0, 65000.0)
    return out


def _with_alpha(rgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
    out = np.full((*rgb.shape[:2], 4), 255, np.uint8)
    out[..., :3] = rgb
    return out


def _decode(value: Any) -> Any:
    """sRGB -> linear (IEC 61966-2-1)."""
    return np.where(value <= 0.04045, value / 12.92, ((np.maximum(value, 0.0) + 0.055) / 1.055) ** 2.4)


def _encode(value: Any) -> Any:
    """Linear -> sRGB (IEC 61966-2-1)."""
    return np.where(value <= 0.0031308, value * 12.92, 1.055 * np.maximum(value, 0.0) ** (1.0 / 2.4) - 0.055)


_SRGB_TO_LINEAR: Floats = _decode(np.arange(256) / 255.0).astype(np.float32)
#: steps of 1/65535 are fine enough: the steepest part of the curve moves by 0.05 of a byte per step
_LINEAR_TO_SRGB: NDArray[np.uint8] = (_encode(np.arange(65536) / 65535.0) * 255.0 + 0.5).astype(np.uint8)


def _to_srgb(linear: Floats) -> NDArray[np.uint8]:
    at = (np.clip(linear, 0.0, 1.0) * np.float32(65535.0) + np.float32(0.5)).astype(np.uint16)
    result: NDArray[np.uint8] = _LINEAR_TO_SRGB[at]
    return result
