"""Light space: the world turned so that z points to the sun. No translation, so a grid in it stays put."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray


def light_from_world(direction: ArrayLike) -> NDArray[np.float64]:
    """f8[3,3], rows right, up and towards the sun, for light that shines along `direction` [3] (world, any length).

    `up` is world +Y as far as it goes, -Z for a sun in the zenith. A direction of no length counts as straight down.
    """
    back = -np.asarray(direction, np.float64)
    length = float(np.linalg.norm(back))
    back = back / length if np.isfinite(length) and length > 0.0 else np.array([0.0, 1.0, 0.0])
    helper = np.array([0.0, 1.0, 0.0]) if abs(back[1]) < 0.999 else np.array([0.0, 0.0, -1.0])
    right = np.cross(helper, back)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(back, right), back])
