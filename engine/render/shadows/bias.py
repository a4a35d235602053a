"""How far a receiver is lifted before it looks into the map: float64 twin of `receiver` in shaders/lib/shadows.glsl.

A flat receiver at angle theta to the sun covers one map texel with depths that differ by tan(theta) texels. A lookup
that reaches `reach` texels from the point must therefore lift the point by reach * tan(theta) along the light, which is
reach * sin(theta) along the normal: finite at every angle, and scale-free as it counts texels of the cascade in metres.
Taps of a filter follow the receiver's plane (Isidoro 2006, "Shadow mapping: GPU-based tips and techniques"), up to a
slope of MAX_SLOPE; the normal offset then only has to hold for what is left.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

#: texels: a bilinear lookup compares texels whose centres are up to sqrt(2) away
FOOTPRINT = 1.5
#: texels towards the sun: rounding of depths and positions, seen where the receiver faces the sun
CONSTANT = 0.2
#: steepest receiver plane that taps follow, as depth per distance (76 degrees)
MAX_SLOPE = 4.0


def normal_offset(cos_theta: ArrayLike, radius: ArrayLike) -> NDArray[np.float64]:
    """Texels along the normal, for a filter of `radius` texels and the angle between normal and sun."""
    cosine = np.abs(np.asarray(cos_theta, np.float64))
    sine = np.sqrt(np.maximum(1.0 - cosine * cosine, 0.0))
    slope = sine / np.maximum(cosine, 1e-4)
    beyond = 1.0 - np.minimum(1.0, MAX_SLOPE / np.maximum(slope, 1e-4))
    result: NDArray[np.float64] = sine * (FOOTPRINT + np.asarray(radius, np.float64) * beyond)
    return result
