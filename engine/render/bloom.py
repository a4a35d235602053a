"""Bloom: the part of the light that a lens or an eye scatters, as a sum of halos, each twice as wide as the next.

The halos are Gaussian in form and of equal weight, so that their sum falls off about as 1 / r^2, as glare does
(Spencer, Shirley, Zimmerman, Greenberg 1995, "Physically-Based Glare Effects for Digital Images", has parts that fall
off with the square and the cube of the angle). Their widths are parts of the picture's height, so that a halo looks the
same at every resolution.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from engine.render.settings import RenderSettings

#: halos, the widest first; those below a pixel are the picture itself
HALOS = 6


@dataclass(frozen=True, slots=True)
class Bloom:
    """`levels`: halvings of the picture; `calm`: see RenderSettings. `why_not`: why it is not wanted."""

    levels: int = 1
    calm: bool = False
    wanted: bool = False
    why_not: str = "bloom is 0"


def bloom_of(settings: RenderSettings, width: int, height: int, *, shown: bool) -> Bloom:
    """What the view asks for; `shown`: the view is of light, and not of a quantity."""
    weights = level_weights(settings.bloom_radius, width, height)
    why = (
        "bloom is 0" if settings.bloom <= 0.0
        else "the view shows values as they are" if not shown
        else "its halos are smaller than a pixel" if len(weights) == 1
        else ""
    )  # fmt: skip
    return Bloom(why_not=why) if why else Bloom(len(weights) - 1, bool(settings.bloom_calm), True, "")


def level_sizes(width: int, height: int, levels: int) -> list[tuple[int, int]]:
    """Of the picture and its halvings, rounded up."""
    return [(-(-width // (1 << k)), -(-height // (1 << k))) for k in range(levels + 1)]


def level_weights(radius: float, width: int, height: int) -> NDArray[np.float64]:
    """f8[levels + 1], sum 1: how much of the scattered light takes the width of each level; [0]: of the picture itself.

    `radius`: standard deviation of the widest halo as a part of the height. Down and up again by quadratic B-splines
    k times has the variance 2 (4^k - 1) / 3 pixels^2; a halo between two levels is their mixture of its variance.
    """
    last = max(width - 1, height - 1, 0).bit_length()
    variances = 2.0 / 3.0 * (4.0 ** np.arange(last + 1) - 1.0)
    weights = np.zeros(last + 1)
    for halo in range(HALOS):
        wanted = min((radius * height * 0.5**halo) ** 2, float(variances[-1]))
        low = min(int(math.log(1.0 + 1.5 * wanted, 4.0) + 1e-9), max(last - 1, 0))
        part = (wanted - variances[low]) / (variances[low + 1] - variances[low]) if last > 0 else 0.0
        weights[low] += (1.0 - part) / HALOS
        if last > 0:
            weights[low + 1] += part / HALOS
    used = np.flatnonzero(weights > 1e-9)
    return weights[: used[-1] + 1]
