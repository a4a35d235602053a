"""The bounding sphere of a part of the view: it turns with the camera without changing its size."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from engine.render.camera import Camera


def slice_sphere(camera: Camera, aspect: float, near: float, far: float) -> tuple[NDArray[np.float64], float]:
    """Centre (f8[3], world) and radius of the smallest sphere around what the camera sees from `near` to `far` metres.

    Its centre lies on the view axis, where the near and the far corners are equally far, or on the far plane when
    that point would lie beyond it (Valient 2008, "Stable rendering of cascaded shadow maps", ShaderX 6, 4.1).
    """
    if camera.ymag > 0.0:
        half_diagonal = math.hypot(camera.ymag, camera.ymag * aspect)
        depth = (near + far) / 2
        radius = math.hypot(half_diagonal, (far - near) / 2)
    else:
        tangent = math.tan(camera.yfov / 2) * math.hypot(1.0, aspect)  # of the angle from the axis to a corner
        depth = min(far, (near + far) / 2 * (1.0 + tangent * tangent))
        radius = math.hypot(far - depth, far * tangent)
    pose = camera.world_from_camera
    return pose[:3, 3] - depth * pose[:3, 2], radius
