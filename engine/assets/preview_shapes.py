"""Shapes that show a material well: a hanging cloth and a ball on a stand with a groove, both made by formulas.

They are about a metre across and stand about the origin, as the simple ones of engine.assets.primitives do.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from engine.assets.mesh import MeshAsset
from engine.assets.primitives import card, cube, uv_sphere
from engine.assets.samples.shapes import Patches

F8 = NDArray[np.float64]

#: what `shape` makes, in the order in which it is offered
SHAPES = ("sphere", "ball", "cube", "plane", "cloth")

#: how far the ball's groove leans, radians: it then shows at every height
LEAN = np.radians(24.0)


def shape(name: str) -> MeshAsset:
    """One of SHAPES. Raises KeyError."""
    makers: dict[str, Callable[[], MeshAsset]] = {
        "sphere": uv_sphere,
        "ball": shader_ball,
        "cube": cube,
        "plane": card,
        "cloth": cloth,
    }
    return makers[name]()


def cloth(size: float = 1.0, cells: int = 64) -> MeshAsset:
    """A cloth `size` m wide that hangs in folds from its upper edge and faces +Z; its top left is uv (0, 0).

    Folds grow from the hem up to the rod: depth = a s^0.7 sin(phase), with s from 0 at the bottom to 1 at the top."""
    u, v = np.meshgrid(np.linspace(0.0, 1.0, cells + 1), np.linspace(0.0, 1.0, cells + 1))
    hang = 1.0 - 0.55 * v
    phase = 2.0 * np.pi * (3.5 * u + 0.22 * np.sin(3.0 * v + 2.0 * u))
    depth = 0.085 * hang**0.7 * np.sin(phase) + 0.035 * v * np.sin(2.0 * np.pi * (1.3 * u + 0.4 * v))
    points = np.stack([(u - 0.5) * 1.1, 0.5 - v + 0.012 * v * np.cos(phase), depth], axis=-1) * size
    patches = Patches()
    patches.grid(points)
    return patches.mesh("cloth")


def shader_ball(segments: int = 96) -> MeshAsset:
    """A ball of radius 0.42 with a groove round it, on a ring-shaped stand: broad highlights, edges, a hollow, a
    contact. About a metre high."""
    patches = Patches()
    tilt = np.array([[np.cos(LEAN), -np.sin(LEAN), 0.0], [np.sin(LEAN), np.cos(LEAN), 0.0], [0.0, 0.0, 1.0]])
    for run in _ball_profile():
        patches.grid(_turned(run, segments) @ tilt.T + np.array([0.0, 0.08, 0.0]))
    for run in _stand_profile():
        patches.grid(_turned(run, segments))
    return patches.mesh("ball")


def _ball_profile(radius: float = 0.42, groove: float = 0.07) -> list[F8]:
    """Runs (radius, height) from the north pole down: cap, the groove's rounded lips and floor, the rest."""
    first, last = np.radians(52.0), np.radians(70.0)  # angles from the pole between which the groove lies
    lip = np.radians(2.2)

    def arc(start: float, end: float, r: float, count: int) -> F8:
        t = np.linspace(start, end, count)
        return np.stack([r * np.sin(t), r * np.cos(t)], axis=1)

    inner = radius - groove
    floor = arc(first + lip, last - lip, inner, 8)
    upper = np.concatenate(
        [arc(1e-4, first, radius, 28), arc(first + 0.6 * lip, first + lip, radius - 0.25 * groove, 3)]
    )
    lower = np.concatenate(
        [arc(last - lip, last - 0.6 * lip, radius - 0.25 * groove, 3), arc(last, np.pi - 1e-4, radius, 48)]
    )
    walls = [np.stack([upper[-1], floor[0]]), np.stack([floor[-1], lower[0]])]
    return [upper, walls[0], floor, walls[1], lower]


def _stand_profile() -> list[F8]:
    """A ring that the ball sinks into, and the plate under it."""
    t = np.linspace(0.0, np.pi, 17)
    ring = np.stack([0.27 - 0.055 * np.cos(t), -0.27 + 0.055 * np.sin(t)], axis=1)
    skirt = np.array([[0.325, -0.27], [0.335, -0.35], [0.37, -0.41], [0.42, -0.44]])
    bevel = np.array([[0.42, -0.44], [0.445, -0.45], [0.455, -0.47]])
    side = np.array([[0.455, -0.47], [0.455, -0.5]])
    bottom = np.array([[0.455, -0.5], [1e-4, -0.5]])
    return [ring, skirt, bevel, side, bottom]


def _turned(run: F8, segments: int) -> F8:
    """A run (radius, height) going down, turned about +Y: points [n,segments+1,3] with the seam at the back."""
    angle = np.linspace(-np.pi, np.pi, segments + 1)
    radius, height = run.T
    x, z = radius[:, None] * np.sin(angle), radius[:, None] * np.cos(angle)
    points: F8 = np.stack([x, np.broadcast_to(height[:, None], x.shape), z], axis=-1)
    return points
