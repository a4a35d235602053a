"""What a tile of the atlas sees from its light: one square view along a spot, or one of the six around a point.

A view is three unit axes (right, up, forward) and the tangent of half its angle. A spot's view is just wider than its
cone; the views of a point are just wider than the cube's faces: by so many texels as a filter and the bias reach beyond
the part that is looked up (GUARD), so that no lookup leaves its tile. A spot beyond WIDEST is looked at as a point.

Six views and not two paraboloids: those bend the straight edges of triangles, which are drawn straight, so that a large
one casts its shadow elsewhere than it should by as much as its size, however fine the map.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

F8 = NDArray[np.float64]

#: half angle of the widest spot that one view takes: its texels see four times the angle in the middle than at the rim
WIDEST = math.radians(60.0)
#: texels of a tile on each side that only filters look into, per texel of the filter's radius, and besides
GUARD_PER_RADIUS, GUARD = 2.5, 3.0


def filter_radius(softness: float, tile: int) -> float:
    """Texels: as wished, but no wider than an eighth of the tile can guard."""
    return max(min(softness, (tile / 8.0 - GUARD) / GUARD_PER_RADIUS), 0.0)


def widened(tangent: float, tile: int, radius: float) -> float:
    """The tangent of half a view's angle, whose inner part without the guard has `tangent`."""
    return tangent / (1.0 - 2.0 * (GUARD + GUARD_PER_RADIUS * radius) / tile)


def spot_axes(direction: F8) -> F8:
    """f8[3,3]: right, up, forward of a spot along `direction` f8[3] (any length; of no length: down)."""
    length = float(np.linalg.norm(direction))
    forward = direction / length if length > 0.0 else np.array([0.0, -1.0, 0.0])
    helper = np.array([0.0, 1.0, 0.0]) if abs(forward[1]) < 0.9 else np.array([1.0, 0.0, 0.0])
    right = np.cross(forward, helper)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(right, forward), forward])


def cube_axes() -> F8:
    """f8[6,3,3]: the axes of the faces +X, -X, +Y, -Y, +Z, -Z; still in the world however a light is turned."""
    faces = np.zeros((6, 3, 3))
    for face in range(6):
        axis = face // 2
        faces[face, 0, (axis + 1) % 3] = faces[face, 1, (axis + 2) % 3] = 1.0
        faces[face, 2, axis] = 1.0 if face % 2 == 0 else -1.0
    return faces


def seen_by(axes: F8, tangent: float, center: F8, radius: F8) -> NDArray[np.bool_]:
    """bool[n]: which spheres (`center` f8[n,3] from the light, `radius` f8[n]) reach into a view."""
    x, y, depth = axes @ center.T
    reach = radius * math.hypot(1.0, tangent)
    result: NDArray[np.bool_] = np.maximum(np.abs(x), np.abs(y)) <= tangent * depth + reach
    result &= depth >= -radius
    return result
