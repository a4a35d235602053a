"""Depth of field: how wide the light of a point falls on the picture, by lens and distance.

A lens of the width A = focal length / f-stop that is focused at the distance s spreads a point at the distance d over
a disc of A F |1/s - 1/d| pixels, with F pixels to the unit of slope: by similar triangles between lens, plane of focus
and point (Potmesil, Chakravarty 1981, eq. 4 to 6, where the picture's angle is that of the focused lens).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from engine.gpu.types import Caps
from engine.render.camera import Camera

if TYPE_CHECKING:
    from engine.render.settings import RenderSettings
    from engine.render.view import View

#: widest disc, as a part of the picture's height
WIDEST = 0.08


def dof_wanted(view: View, caps: Caps) -> bool:
    """With one sample a pixel, a camera with a perspective, and in views of light."""
    from engine.render.settings import LIT_LOOK

    settings = view.settings
    one = caps.samples_for(settings.samples) == 1 and settings.shading_view in LIT_LOOK
    return bool(settings.depth_of_field) and one and view.camera.ymag <= 0.0


def lens_width(camera: Camera, settings: RenderSettings) -> float:
    """Metres: focal length over f-stop."""
    focal = 1e-3 * float(settings.sensor) / (2.0 * math.tan(camera.yfov / 2.0))
    return focal / max(float(settings.f_stop), 1e-3)


def pixels_per_slope(camera: Camera, height: int) -> float:
    return height / (2.0 * math.tan(camera.yfov / 2.0))


def disc(camera: Camera, settings: RenderSettings, height: int, focus: float, distance: float) -> float:
    """Pixels across that a point at `distance` takes; below 0 behind what is in focus. `focus` may be infinite."""
    width = lens_width(camera, settings) * pixels_per_slope(camera, height) * (1.0 / distance - 1.0 / focus)
    limit = WIDEST * height
    return min(max(width, -limit), limit)
