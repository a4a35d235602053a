"""Tone maps: scene-linear Rec.709 [..., 3] -> display-linear Rec.709 in [0, 1], before the sRGB encoding. Float64.

Every input is first made safe: negative and NaN become 0, more than LARGEST becomes LARGEST.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core.errors import InputError

F8 = NDArray[np.float64]

#: Radiance is clamped to this everywhere (fits half floats with head room for sums).
LARGEST = 32000.0

# AgX: Troy Sobotka 2022, base look. Inset and outset matrices and the curve's fit as in Benjamin Wrensch,
# "Minimal AgX Implementation" (2023). Rows here; neutrals stay neutral because each row sums to 1.
AGX_INSET = np.array(
    [
        [0.842479062253094, 0.0784335999999992, 0.0792237451477643],
        [0.0423282422610123, 0.878468636469772, 0.0791661274605434],
        [0.0423756549057051, 0.0784336, 0.879142973793104],
    ]
)
AGX_OUTSET = np.array(
    [
        [1.19687900512017, -0.0980208811401368, -0.0990297440797205],
        [-0.0528968517574562, 1.15190312990417, -0.0989611768448433],
        [-0.0529716355144438, -0.0980434501171241, 1.15107367264116],
    ]
)
#: log2 of the darkest and brightest scene value that AgX tells apart: 0.18 * 2^-10 and 0.18 * 2^6.5
AGX_MIN_EV, AGX_MAX_EV = -12.47393, 4.026069
#: Sixth-order fit of AgX's sigmoid, highest power first.
AGX_CURVE = np.array([15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.00232])

# ACES: Stephen Hill's fit of RRT + ODT (sRGB, D65), in MiniEngine / BakingLab 2017, with its AP1 matrices.
ACES_IN = np.array([[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]])
ACES_OUT = np.array([[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]])


def none(rgb: ArrayLike) -> F8:
    """Clamp to [0, 1]."""
    return np.minimum(sanitize(rgb), 1.0)


def agx(rgb: ArrayLike) -> F8:
    """AgX, base look. The curve's output is encoded for a 2.2 power display; it is decoded to display-linear here."""
    inset = sanitize(rgb) @ AGX_INSET.T
    with np.errstate(divide="ignore"):
        ev = np.clip(np.log2(inset), AGX_MIN_EV, AGX_MAX_EV)
    encoded = np.polyval(AGX_CURVE, (ev - AGX_MIN_EV) / (AGX_MAX_EV - AGX_MIN_EV))
    result: F8 = np.clip(encoded @ AGX_OUTSET.T, 0.0, 1.0) ** 2.2
    return result


def aces(rgb: ArrayLike) -> F8:
    """ACES filmic, the fitted RRT + ODT (Hill). Scene 0.18 comes out near 0.1: expose about 1.7 times more."""
    v = sanitize(rgb) @ ACES_IN.T
    fitted = (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.4329510) + 0.238081)
    result: F8 = np.clip(fitted @ ACES_OUT.T, 0.0, 1.0)
    return result


def neutral(rgb: ArrayLike) -> F8:
    """Khronos PBR Neutral (Khronos Group 2024): base colours stay as they are, highlights are compressed and bleach.

    Takes off up to 0.04 (the F0 reflection of dielectrics under white light), then bends peaks above 0.8 - 0.04.
    """
    start, desaturation = 0.8 - 0.04, 0.15
    v = sanitize(rgb)
    low = v.min(axis=-1, keepdims=True)
    v = v - np.where(low < 0.08, low - 6.25 * low * low, 0.04)
    peak = v.max(axis=-1, keepdims=True)
    bent = peak >= start
    room = 1.0 - start
    new_peak = 1.0 - room * room / np.where(bent, peak + room - start, 1.0)
    compressed = v * (new_peak / np.where(bent, peak, 1.0))
    bleach = 1.0 - 1.0 / (desaturation * (np.where(bent, peak, new_peak) - new_peak) + 1.0)
    return np.where(bent, compressed + (new_peak - compressed) * bleach, v)


def sanitize(rgb: ArrayLike) -> F8:
    """Return `rgb` as float64 in [0, LARGEST]; NaN and negative values become 0."""
    v = np.asarray(rgb, np.float64)
    return np.where(v > 0.0, np.minimum(v, LARGEST), 0.0)


#: By the names of LookAsset.tone_map.
TONE_MAPS: dict[str, Callable[[ArrayLike], F8]] = {"agx": agx, "aces": aces, "neutral": neutral, "none": none}


def apply(name: str, rgb: ArrayLike, exposure: float = 0.0) -> F8:
    """Tone map `rgb` [..., 3] times 2^exposure by name. Raises InputError for an unknown name."""
    if name not in TONE_MAPS:
        raise InputError(f"unknown tone map {name!r}", hint=f"choose one of {', '.join(TONE_MAPS)}")
    return TONE_MAPS[name](np.asarray(rgb, np.float64) * 2.0**exposure)
