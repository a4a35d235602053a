"""Cascades: squares in light space around what the view shows, on a grid that stands still in the world."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.render.camera import Camera
from engine.render.shadows.slices import slice_sphere
from engine.render.shadows.splits import practical_splits

F8 = NDArray[np.float64]

#: a square's half width is one of STEPS_PER_OCTAVE sizes an octave, so that it rarely changes as the camera moves
STEPS_PER_OCTAVE = 8
#: a square moves in steps of 1/GRID of its width: a whole number of texels, and seldom
GRID = 16
#: texels at each side that only filters look into
MARGIN = 6
#: depth reaches so many half widths beyond the square's own cube; what casts from further away is drawn at that end
DEPTH_REACH = 63.0
#: steps of the search for a depth up to which one is
BISECTIONS = 5
#: a cascade that is not this much smaller than the next one gains nothing
WORTHWHILE = 0.75


@dataclass(frozen=True, slots=True)
class Cascade:
    """A square map: centre x, y and half width in light space; depth 0 at `bottom`, 1 at `top` (light-space z).

    `texel`: metres. Two equal cascades have the same texels at the same places of the world.
    """

    x: float
    y: float
    half_width: float
    bottom: float
    top: float
    texel: float


@dataclass(frozen=True, slots=True)
class Boxes:
    """Bounding spheres as boxes: `low`, `high` f8[3,n] in light space; `near`, `far` f8[n] view depths (receivers)."""

    low: F8
    high: F8
    near: F8
    far: F8

    def __len__(self) -> int:
        return len(self.low[0])


def boxes_of(center: F8, radius: F8, axes: F8, eye: F8 | None = None, forward: F8 | None = None) -> Boxes:
    """Boxes around world spheres `center` [n,3], `radius` [n]; with view depths where `eye` and `forward` are given."""
    at = axes @ center.T
    boxes = Boxes(at - radius, at + radius, np.zeros(0), np.zeros(0))
    return boxes if eye is None or forward is None else with_depths(boxes, center, radius, eye, forward)


def with_depths(boxes: Boxes, center: F8, radius: F8, eye: F8, forward: F8) -> Boxes:
    """The same boxes with the view depths of their spheres."""
    depth = center @ forward - float(eye @ forward)
    return Boxes(boxes.low, boxes.high, depth - radius, depth + radius)


def view_range(camera: Camera, receivers: Boxes, distance: float) -> tuple[float, float] | None:
    """Nearest and furthest view depth of the receivers; None where none is in front of the camera.

    `distance` > 0 is the furthest that shadows are wanted.
    """
    if len(receivers) == 0:
        return None
    near = max(float(receivers.near.min()), camera.znear)
    far = float(receivers.far.max())
    if distance > 0.0:
        far = min(far, distance)
    if camera.ymag > 0.0:
        far = min(far, camera.zfar)
    return (near, far) if far >= near else None


def nearest_body(receivers: Boxes, near: float, far: float) -> float:
    """Where there is something to see: the nearest depth of a receiver that the camera is not inside of, but no further
    than the middle of the range (by logarithms). A ground that reaches to the horizon has bounds around the camera,
    which say nothing; splitting from there on would spend cascades on air."""
    if far <= near:
        return near
    outside = receivers.near[receivers.near > near]
    found = float(outside.min()) if len(outside) else near
    return max(near, min(found, math.sqrt(near * far)))


def fit_cascades(
    camera: Camera, aspect: float, axes: F8, receivers: Boxes, casters: Boxes, *,
    count: int, size: int, weight: float, distance: float,
) -> list[Cascade]:  # fmt: skip
    """At most `count` cascades of `size` texels, each within the next; none where nothing can be in shadow.

    `axes`: light_from_world. Each covers all that the view shows of the receivers up to its split, so those that would
    gain nothing over the next are left out, and a picture never depends on which cascade a pixel reads.
    """
    depths = view_range(camera, receivers, distance)
    if depths is None or len(casters) == 0:
        return []
    near, far = depths

    def around(cut: float) -> Cascade | None:
        return _around(camera, aspect, axes, receivers, casters, near, cut, size)

    whole = around(far)
    if whole is None:
        return []
    found, start = [whole], nearest_body(receivers, near, far)
    cuts = practical_splits(start, far, count, weight)[1:-1]
    if len(cuts) and not _gains(around(float(cuts[-1])), whole):
        # all that is seen lies within a small place: where it is cut, smaller squares have to begin
        cuts = practical_splits(start, _first_gain(around, start, float(cuts[-1]), whole), count - 1, weight)[1:]
    for cut in cuts[::-1]:  # from the largest to the smallest
        cascade = around(float(cut))
        if cascade is not None and _gains(cascade, found[-1]):
            found.append(cascade)
    return found[::-1]


def _gains(cascade: Cascade | None, larger: Cascade) -> bool:
    return cascade is not None and cascade.half_width < WORTHWHILE * larger.half_width


def _first_gain(around: Callable[[float], Cascade | None], low: float, high: float, whole: Cascade) -> float:
    """A depth up to which a square gains over `whole`, nearly the largest: between `low`, which may not, and `high`,
    which does not."""
    for _ in range(BISECTIONS):
        middle = math.sqrt(low * high)
        if _gains(around(middle), whole):
            low = middle
        else:
            high = middle
    return low


def _around(
    camera: Camera, aspect: float, axes: F8, receivers: Boxes, casters: Boxes, near: float, far: float, size: int
) -> Cascade | None:
    """The square around what is both in the view up to `far` and in a receiver's bounds; None when nothing is."""
    center, radius = slice_sphere(camera, aspect, near, far)
    middle = axes @ center
    inside = receivers.near <= far
    if not inside.any():
        return None
    everything = slice(None) if inside.all() else np.flatnonzero(inside)  # the last cascade copies nothing
    low = np.maximum([receivers.low[axis][everything].min() for axis in range(3)], middle - radius)
    high = np.minimum([receivers.high[axis][everything].max() for axis in range(3)], middle + radius)
    if not (np.isfinite(low).all() and np.isfinite(high).all() and (high >= low).all()):
        return None
    spot = (low + high) / 2
    needed = max(float((high - low)[:2].max()) / 2, 1e-9, 1e-12 * float(np.abs(spot).max()))
    half_width = _rounded_up(needed / (1.0 - 1.0 / GRID - 2.0 * MARGIN / size))
    texel = 2.0 * half_width / size
    step = texel * max(size // GRID, 1)
    x, y = np.round(spot[:2] / step) * step
    # Depth has no texels to keep still; its ends are rounded only so that a cascade stays equal to itself.
    rung = half_width / 2
    top = min(float(casters.high[2].max()), float(high[2]) + DEPTH_REACH * half_width)
    bottom = max(float(receivers.low[2].min()), float(low[2]) - DEPTH_REACH * half_width)
    top = max(top, bottom)
    return Cascade(
        float(x), float(y), half_width, (math.floor(bottom / rung) - 1) * rung, (math.ceil(top / rung) + 1) * rung,
        texel,
    )  # fmt: skip


def _rounded_up(value: float) -> float:
    """The next size on the ladder of STEPS_PER_OCTAVE sizes an octave."""
    octave = math.log2(value) * STEPS_PER_OCTAVE
    return float(2.0 ** (math.ceil(octave - 1e-9) / STEPS_PER_OCTAVE))


def casts_into(cascade: Cascade, casters: Boxes) -> NDArray[np.bool_]:
    """bool[n]: which casters may darken something in the cascade: above its bottom, over its square, however far away
    towards the sun, also behind the camera."""
    result: NDArray[np.bool_] = casters.high[2] >= cascade.bottom
    for axis, middle in enumerate((cascade.x, cascade.y)):
        result &= casters.high[axis] >= middle - cascade.half_width
        result &= casters.low[axis] <= middle + cascade.half_width
    return result
