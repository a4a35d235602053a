"""What the colours of a debug view mean: the ramp, its unit and its range. Drawn by whoever shows the picture.

Views of a quantity write it as it is (VALUE_VIEWS: metres, counts, texels a metre), and the last pass colours it; so an
.exr of such a view holds the numbers.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.render.camera import Camera

F8 = NDArray[np.float64]

#: views whose surfaces write a quantity
VALUE_VIEWS = ("depth", "overdraw", "texel_density", "shadow_texels")
#: as shaders/lib/ramp.glsl: sRGB
STOPS = np.array([
    [0.267, 0.004, 0.329], [0.278, 0.177, 0.482], [0.231, 0.322, 0.545], [0.172, 0.447, 0.557], [0.129, 0.569, 0.549],
    [0.157, 0.682, 0.502], [0.369, 0.788, 0.384], [0.678, 0.863, 0.188], [0.992, 0.906, 0.145],
])  # fmt: skip
#: a picture's depth is shown over so many times its nearest at most: beyond, near things take all the colours
MOST_DEPTH_RATIO = 64.0
#: lights in a tile's list, as shaders/passes/light_heat.frag
MOST_LIGHTS = 1024.0
#: places in a legend lie so far apart at least, so that what is written there does not meet
GAP = 0.09


@dataclass(frozen=True, slots=True)
class Legend:
    """`low` and `high` lie at the ends of the ramp, evenly between or by their logarithms; of log(1 + x) with `counts`.

    `open_high`: what is above is as `high` is. `falling`: the ramp begins at `high`."""

    title: str
    unit: str
    low: float
    high: float
    logarithmic: bool = False
    counts: bool = False
    falling: bool = False
    open_high: bool = True
    note: str = ""
    #: values to write besides the ends; round numbers where there are none
    marks: tuple[float, ...] = ()

    def place(self, value: float) -> float:
        """Where a value lies in the legend, 0 at its left to 1."""
        low, high, at = (self._scaled(v) for v in (self.low, self.high, value))
        return min(max((at - low) / max(high - low, 1e-30), 0.0), 1.0)

    def color(self, place: float) -> tuple[float, float, float]:
        """sRGB of that place in the legend."""
        r, g, b = (float(np.interp(self._along(place) * 8.0, np.arange(9), STOPS[:, i])) for i in range(3))
        return r, g, b

    @property
    def mapping(self) -> tuple[float, float, float]:
        """(scale, offset, 1 with log2): a value's place in the ramp is log2(value) or the value, scaled and moved."""
        low, high = (math.log2(v) if self.logarithmic else v for v in (self.low, self.high))
        scale = 1.0 / max(high - low, 1e-30)
        if self.falling:
            return -scale, 1.0 + low * scale, float(self.logarithmic)
        return scale, -low * scale, float(self.logarithmic)

    def ticks(self) -> list[tuple[float, str]]:
        """(place, what is written there), rising; the first and the last are the ends."""
        ends = (0.0, _number(self.low)), (1.0, _number(self.high) + "+" * self.open_high)
        found = [ends[0]]
        for value in self.marks or _round_numbers(self.low, self.high):
            if found[-1][0] + GAP < self.place(value) < 1.0 - GAP:
                found.append((self.place(value), _number(value)))
        return [*found, ends[1]]

    @property
    def heading(self) -> str:
        return f"{self.title}, {self.unit}"

    def _along(self, place: float) -> float:
        return 1.0 - place if self.falling else place

    def _scaled(self, value: float) -> float:
        if self.counts:
            return math.log2(1.0 + max(value, 0.0))
        return math.log2(max(value, 1e-30)) if self.logarithmic else value


def legend_of(view: str, depths: tuple[float, float] = (0.1, 100.0)) -> Legend | None:
    """The legend of a debug view, None where its colours say all; `depths`: the nearest and farthest metres seen."""
    if view == "depth":
        low, high = depths
        return Legend("Depth", "m", low, high, high > 4.0 * low, falling=True, open_high=False)
    if view == "overdraw":
        return Legend("Overdraw", "fragments shaded", 1.0, 10.0, marks=(2.0, 4.0, 6.0, 8.0))
    if view == "texel_density":
        steps = (128.0, 512.0, 2048.0)
        return Legend("Texels", "per metre", 32.0, 8192.0, True, note="grey: no texture", marks=steps)
    if view == "shadow_texels":
        return Legend("Shadow texels", "per metre", 1.0, 4096.0, True, note="grey: no shadow", marks=(8.0, 64.0, 512.0))
    if view == "light_tiles":
        marks, note = (1.0, 4.0, 16.0, 64.0, 256.0), "black: none, white: more than fit"
        return Legend("Lights", "in the tile's list", 0.0, MOST_LIGHTS, counts=True, note=note, marks=marks)
    return None


def depth_range(camera: Camera, centers: F8, radii: NDArray[np.floating]) -> tuple[float, float]:
    """The nearest and farthest metres along the view of spheres that are seen, f8[n,3] and f[n], world."""
    if not len(centers):
        return 1.0, 10.0
    pose = camera.world_from_camera
    middle = (centers - pose[:3, 3]) @ -pose[:3, 2]
    high = float((middle + radii).max())
    low = max(float((middle - radii).min()), high / MOST_DEPTH_RATIO, camera.znear)
    if not (math.isfinite(high) and high > low > 0.0):
        return camera.znear, 10.0 * camera.znear
    low, high = _two_digits(low, math.floor), _two_digits(high, math.ceil)
    return low, high


def _two_digits(value: float, towards: Callable[[float], int]) -> float:
    step = 10.0 ** (math.floor(math.log10(value)) - 1)
    return towards(value / step) * step


def _round_numbers(low: float, high: float) -> list[float]:
    """1, 2 and 5 times powers of ten from `low` to `high`."""
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    return [v for d in decades for m in (1.0, 2.0, 5.0) if low < (v := m * 10.0**d) < high]


def _number(value: float) -> str:
    return f"{value:,.0f}" if value >= 1000.0 else f"{value:.3g}"
