"""How people who tell fewer colours apart see them, and how far colours then lie apart.

Simulation: Machado, Oliveira and Fernandes 2009, "A Physiologically-based Model for Simulation of Color Vision
Deficiency", matrices of severity 1.0, on scene-linear Rec. 709. Distances: CIE 1976 L*a*b* under D65 (CIE 15:2004).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

F8 = NDArray[np.float64]

VISIONS: dict[str, F8] = {
    "normal": np.eye(3),
    "protanopia": np.array(
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]
    ),
    "deuteranopia": np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
    ),
    "tritanopia": np.array(
        [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]]
    ),
}
#: IEC 61966-2-1: XYZ of linear Rec. 709, white D65
XYZ = np.array(
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]
)
WHITE = XYZ.sum(axis=1)


def lab(srgb: ArrayLike, vision: str = "normal") -> F8:
    """f8[n,3] L*, a*, b* of display colours f8[n,3] in 0..1 as that vision sees them."""
    colors: F8 = np.asarray(srgb, np.float64).reshape(-1, 3)
    linear = np.where(colors <= 0.04045, colors / 12.92, ((colors + 0.055) / 1.055) ** 2.4)
    seen = np.clip(linear @ VISIONS[vision].T, 0.0, 1.0)
    ratio = (seen @ XYZ.T) / WHITE
    root = np.where(ratio > (6 / 29) ** 3, np.cbrt(ratio), ratio / (3 * (6 / 29) ** 2) + 4 / 29)
    x, y, z = root.T
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=1)


def apart(srgb: ArrayLike, vision: str, *, neighbours: bool = False) -> tuple[float, tuple[int, int]]:
    """(the least distance between two of the colours, which two); `neighbours`: only between one and the next."""
    places: Any = lab(srgb, vision)
    pairs = [
        (float(np.linalg.norm(places[i] - places[j])), (i, j))
        for i in range(len(places))
        for j in range(i + 1, len(places))
        if not neighbours or j == i + 1
    ]
    return min(pairs)
