"""The eye behind a mirror."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from engine.render.camera import Camera

F8 = NDArray[np.float64]


def reflection(plane: F8) -> F8:
    """f8[4,4]: what takes a point to its image behind `plane` f8[4] (n, w), n unit."""
    n, w = plane[:3], float(plane[3])
    matrix = np.eye(4)
    matrix[:3, :3] -= 2.0 * np.outer(n, n)
    matrix[:3, 3] = -2.0 * w * n
    return matrix


def mirrored_camera(camera: Camera, plane: F8) -> Camera:
    """The camera that is the image of `camera`, with left and right exchanged so that its axes stay right-handed: a
    point in the plane is as far left in its picture as it is right in the other."""
    pose = reflection(plane) @ camera.world_from_camera @ np.diag([-1.0, 1.0, 1.0, 1.0])
    return replace(camera, world_from_camera=pose)


def side_of(camera: Camera, planes: F8) -> F8:
    """f8[n]: on which side of `planes` f8[n,4] the camera is: metres in front; orthographic: the cosine of the angle
    that it looks at their front with."""
    if camera.ymag > 0.0:
        ahead: F8 = planes[:, :3] @ camera.world_from_camera[:3, 2]
        return ahead
    metres: F8 = planes[:, :3] @ camera.position + planes[:, 3]
    return metres
