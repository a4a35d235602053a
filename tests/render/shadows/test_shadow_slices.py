"""The sphere of a slice holds its corners, and is the smallest that does."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from engine.math.transform import look_at
from engine.render.camera import Camera
from engine.render.shadows.slices import slice_sphere


def corners(camera: Camera, aspect: float, near: float, far: float) -> np.ndarray:
    rows = []
    for depth, x, y in itertools.product((near, far), (-1, 1), (-1, 1)):
        half = camera.ymag or depth * math.tan(camera.yfov / 2)
        rows.append((x * half * aspect, y * half, -depth, 1.0))
    return (np.array(rows) @ camera.world_from_camera.T)[:, :3]


@pytest.mark.parametrize("ymag", [0.0, 3.0])
@pytest.mark.parametrize("aspect", [0.5, 1.0, 1.8])
@pytest.mark.parametrize("yfov", [0.1, 0.8, 2.0])
@pytest.mark.parametrize(("near", "far"), [(0.1, 1.0), (5.0, 6.0), (1e-3, 1e5)])
def test_corners_lie_within_and_touch(ymag: float, aspect: float, yfov: float, near: float, far: float) -> None:
    camera = Camera(look_at((1, 2, 3), (4, -1, 0)), yfov, ymag=ymag)
    center, radius = slice_sphere(camera, aspect, near, far)
    distance = np.linalg.norm(corners(camera, aspect, near, far) - center, axis=1)
    assert distance.max() == pytest.approx(radius, rel=1e-9)
    # no other centre on the axis does better
    axis = -camera.world_from_camera[:3, 2]
    for shift in (-1e-3 * radius, 1e-3 * radius):
        moved = np.linalg.norm(corners(camera, aspect, near, far) - center - shift * axis, axis=1).max()
        assert moved >= radius * (1 - 1e-9)


def test_the_radius_does_not_change_as_the_camera_turns() -> None:
    radii = {
        slice_sphere(Camera(look_at((0, 0, 0), (math.cos(a), 0.3, math.sin(a)))), 1.5, 0.5, 20.0)[1]
        for a in np.linspace(0, 6, 9)
    }
    assert len(radii) == 1
