"""How far a receiver is lifted before it looks into the map: float64 twin of `receiver` in shaders/lib/shadows.glsl.

A flat receiver at angle theta to the sun covers one map texel with depths that differ by tan(theta) texels. Every texel
that is looked up is therefore compared with the receiver's plane over that texel's own middle, which is where the map
has its depth: a plane then does not hide itself, at any distance from the point. Filters follow it in the same way
(Isidoro 2006, "Shadow mapping: GPU-based tips and techniques"). Only slopes beyond MAX_SLOPE are not followed all the
way: there the point is moved by what is left over `reach` texels, reach * rest * sin(theta) along the normal: finite at
every angle, and scale-free as it counts texels of the cascade in metres. LIFT is for what is not flat.

The thesis's filters let the hardware compare, which has one depth for all four texels of a lookup: those lift the point
by all that a lookup reaches (HARDWARE_LIFT), and so shift its shadows by as much.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

#: texels: a lookup compares texels whose centres are up to sqrt(2) away
FOOTPRINT = 1.5
#: texels along the normal, at a right angle to the sun
LIFT, HARDWARE_LIFT = 0.25, FOOTPRINT
#: texels towards the sun: rounding of depths and positions, seen where the receiver faces the sun
CONSTANT, HARDWARE_CONSTANT = 0.4, 0.2
#: steepest receiver plane that lookups follow, as depth per distance (83 and 76 degrees)
MAX_SLOPE, HARDWARE_MAX_SLOPE = 8.0, 4.0


def normal_offset(cos_theta: ArrayLike, radius: ArrayLike, *, hardware: bool = False) -> NDArray[np.float64]:
    """Texels along the normal, for a filter of `radius` texels and the angle between normal and sun."""
    cosine = np.abs(np.asarray(cos_theta, np.float64))
    sine = np.sqrt(np.maximum(1.0 - cosine * cosine, 0.0))
    slope = sine / np.maximum(cosine, 1e-4)
    most = HARDWARE_MAX_SLOPE if hardware else MAX_SLOPE
    beyond = 1.0 - np.minimum(1.0, most / np.maximum(slope, 1e-4))
    lift = HARDWARE_LIFT if hardware else LIFT + FOOTPRINT * beyond
    result: NDArray[np.float64] = sine * (lift + np.asarray(radius, np.float64) * beyond)
    return result
