"""What lights can reach at most, as the culling shaders read it: each alone, and in groups of neighbours."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.render.light_rows import LightBounds

#: lights of a group: those of one word of a mask with a bit per light
GROUP = 32
#: beyond this is everywhere; squares and sums of it stay within float32
_EVERYWHERE = 1e30


def bounds_rows(bounds: LightBounds) -> NDArray[np.float32]:
    """f4[n,2,4]: centre and radius (endless: 3e38), axis and cosine of the half angle."""
    rows = np.empty((len(bounds.radius), 2, 4), np.float32)
    rows[:, 0, :3] = bounds.center
    rows[:, 0, 3] = np.minimum(bounds.radius, np.float32(3e38))
    rows[:, 1, :3] = bounds.axis
    rows[:, 1, 3] = bounds.cos_angle
    return rows


def group_rows(bounds: LightBounds) -> NDArray[np.float32]:
    """f4[ceil(n / GROUP),2,4]: the least and the greatest corner of the box about each group's spheres, a bit wider,
    for rounding. Rows of lights are neighbours in space (engine/scene/light_order.py), so that boxes are small."""
    center = bounds.center.astype(np.float64)
    radius = bounds.radius.astype(np.float64)
    reach = (radius + 1e-5 * (np.abs(center).sum(axis=1) + radius))[:, None]
    starts = np.arange(0, len(radius), GROUP)
    rows = np.zeros((len(starts), 2, 4), np.float32)
    if len(starts):
        low, high = np.minimum.reduceat(center - reach, starts), np.maximum.reduceat(center + reach, starts)
        rows[:, 0, :3], rows[:, 1, :3] = np.maximum(low, -_EVERYWHERE), np.minimum(high, _EVERYWHERE)
    return rows
