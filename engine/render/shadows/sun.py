"""SunShadows: the cascades of a frame's first sun, who casts into each, and when a map has to be drawn again."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from engine.render.shadows.casters import finite_bounds, last_moved
from engine.render.shadows.fit import Boxes, Cascade, boxes_of, casts_into, fit_cascades, with_depths
from engine.render.shadows.floor import with_floor
from engine.render.shadows.light_space import light_from_world
from engine.render.shadows.moments import usable_exponent
from engine.render.view import View
from engine.render.view_block import MAX_CASCADES
from engine.scene.scene import Scene

F8 = NDArray[np.float64]

#: of the shadow distance: where shadows begin to fade out
FADE = 0.9
#: half width, in metres, of the square that stands for "everywhere" where every branch must run though nothing casts
EVERYWHERE = 1e30


@dataclass(slots=True)
class _Casters:
    """What does not change with the camera: the `rows` of what casts, its boxes, and when each moved last."""

    key: tuple[object, ...]
    mask: NDArray[np.bool_]
    rows: NDArray[np.intp]
    boxes: Boxes
    moved: NDArray[np.uint32]


@dataclass(slots=True)
class SunShadows:
    """`cascades` from small to large; `casters` bool[cascades, instances]; `keys`: equal keys are equal maps."""

    axes: F8 = field(default_factory=lambda: np.eye(3))
    cascades: list[Cascade] = field(default_factory=list)
    casters: NDArray[np.bool_] = field(default_factory=lambda: np.zeros((0, 0), np.bool_))
    keys: list[tuple[object, ...]] = field(default_factory=list)
    #: world y of a floor that shows shadows, too (floor.py); set before `update`
    floor: float | None = None
    _seen: tuple[object, ...] = ()
    _drawn: tuple[object, ...] = ()
    _casters: _Casters | None = None

    def update(
        self, scene: Scene, view: View, direction: NDArray[np.floating] | None, visible: NDArray[np.bool_],
        casting: NDArray[np.bool_], receiving: NDArray[np.bool_], state: tuple[object, ...],
    ) -> bool:  # fmt: skip
        """Fit the cascades; True when what casts into them is not what it was at the last call.

        `direction`: where the sun shines, None for no shadows. bool[instances]: `visible` in the view, `casting`,
        `receiving`. `state`: whatever else changes what casters look like (materials, programs, structure).
        """
        settings, camera = view.settings, view.camera
        wanted = (
            settings.shadow_cascades, settings.shadow_size, settings.shadow_split, settings.shadow_distance, self.floor,
        )  # fmt: skip
        seen = (
            id(scene), scene.transform_rev, scene.instances.bounds_rev, scene.instances.drawn_rev, camera.key(),
            view.aspect, None if direction is None else direction.tobytes(), wanted, state,
        )  # fmt: skip
        if seen == self._seen:
            return False
        self._seen = seen
        if direction is None:
            self.cascades, self.keys = [], []
            self.casters = np.zeros((0, len(visible)), np.bool_)
            return True
        self.axes = light_from_world(direction)
        same = (id(scene), scene.transform_rev, scene.instances.bounds_rev, direction.tobytes(), state)
        if self._casters is None or self._casters.key != same or not np.array_equal(self._casters.mask, casting):
            self._casters = _Casters(same, casting.copy(), *_sound(scene, casting, self.axes))
        casters, rows, moved = self._casters.boxes, self._casters.rows, self._casters.moved
        table = scene.instances
        shown = np.flatnonzero(receiving & visible & finite_bounds(scene))
        center, radius = table.world_center[shown], table.world_radius[shown].astype(np.float64)
        eye, forward = camera.position, -camera.world_from_camera[:3, 2]
        if np.array_equal(shown, rows):  # everything that is seen casts, too
            receivers = with_depths(casters, center, radius, eye, forward)
        else:
            receivers = boxes_of(center, radius, self.axes, eye, forward)
        if self.floor is not None:
            receivers = with_floor(receivers, casters, self.floor, self.axes, eye, forward)
        self.cascades = fit_cascades(
            camera, view.aspect, self.axes, receivers, casters, count=settings.shadow_cascades,
            size=settings.shadow_size, weight=settings.shadow_split, distance=settings.shadow_distance,
        )  # fmt: skip
        before = self.casters
        self.casters = np.zeros((len(self.cascades), len(visible)), np.bool_)
        self.keys = []
        for mask, cascade in zip(self.casters, self.cascades, strict=True):
            inside = casts_into(cascade, casters)
            mask[rows] = inside
            rev = int(moved[inside].max(initial=0))
            self.keys.append((id(scene), cascade, direction.tobytes(), np.packbits(mask).tobytes(), rev, state))
        changed = state != self._drawn or not np.array_equal(before, self.casters)
        self._drawn = state
        return changed

    # --- for the GPU ---

    def clip_from_origin(self, index: int, origin: F8) -> F8:
        """f8[4,4] from the origin-relative world to the clip space of a map (reversed depth)."""
        cascade = self.cascades[index]
        scale = np.array([1.0 / cascade.half_width, 1.0 / cascade.half_width, 1.0 / (cascade.top - cascade.bottom)])
        offset = self.axes @ origin - (cascade.x, cascade.y, cascade.bottom)
        matrix = np.eye(4)
        matrix[:3, :3] = self.axes * scale[:, None]
        matrix[:3, 3] = offset * scale
        return matrix

    def fill(self, row: NDArray[np.void], view: View, origin: F8, *, everywhere: bool) -> None:
        """Write the shadow fields of a row of VIEW_LAYOUT. `everywhere`: without cascades, one that is lit all over."""
        settings = view.settings
        row["shadow_axes"][:, :3] = self.axes
        at = self.axes @ origin
        cascades = self.cascades or ([_everywhere(at)] if everywhere else [])
        for i, c in enumerate(cascades[:MAX_CASCADES]):
            row["shadow_cascades"][2 * i] = (c.x - at[0], c.y - at[1], 1.0 / c.half_width, c.texel)
            row["shadow_cascades"][2 * i + 1] = (c.bottom - at[2], 1.0 / (c.top - c.bottom), c.half_width, 0.0)
        far = settings.shadow_distance if settings.shadow_distance > 0.0 else EVERYWHERE
        row["shadow"] = (
            len(cascades), settings.shadow_softness, np.tan(np.radians(settings.sun_angle / 2)),
            1.0 / settings.shadow_size,
        )  # fmt: skip
        exponent = usable_exponent(float(settings.shadow_exponent), str(settings.shadow_precision))
        row["shadow_fade"] = (far * FADE, 1.0 / (far * (1.0 - FADE)), exponent, settings.shadow_leak)


def _everywhere(at: F8) -> Cascade:
    return Cascade(float(at[0]), float(at[1]), EVERYWHERE, float(at[2]) - EVERYWHERE, float(at[2]) + EVERYWHERE, 0.0)


def _sound(scene: Scene, wanted: NDArray[np.bool_], axes: F8) -> tuple[NDArray[np.intp], Boxes, NDArray[np.uint32]]:
    """Rows of `wanted` whose bounds are finite, their boxes, when they moved."""
    table = scene.instances
    rows = np.flatnonzero(wanted & finite_bounds(scene))
    boxes = boxes_of(table.world_center[rows], table.world_radius[rows].astype(np.float64), axes)
    return rows, boxes, last_moved(scene, rows)
