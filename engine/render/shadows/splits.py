"""Where the view's depth is cut into cascades."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

#: far over near: the range that the even cut is good for (half a metre to 500 m)
WIDE = 1000.0


def practical_splits(near: float, far: float, count: int, weight: float) -> NDArray[np.float64]:
    """Distances f8[count + 1] from `near` to `far` (metres along the view), strictly increasing.

    Zhang, Sun, Xu and Lun 2006, "Parallel-split shadow maps for large-scale virtual environments": `weight` (their
    lambda) mixes the logarithmic cut, which keeps a texel's size on the screen, with the even one; of ranges wider
    than WIDE, less and less of the even one, whose first part would be all that matters. A depth range that is empty,
    reversed or not finite gives the least range that float64 can cut.
    """
    near = near if math.isfinite(near) and near > 0.0 else 1e-9
    least = near * (1.0 + 1e-9 * count)
    far = far if math.isfinite(far) and far > least else least
    t = np.arange(count + 1) / count
    logarithmic = near * (far / near) ** t
    even = near + (far - near) * t
    even_part = (1.0 - weight) * min(1.0, WIDE * near / far)
    cuts = logarithmic + even_part * (even - logarithmic)
    cuts[0], cuts[-1] = near, far
    return cuts
