"""The viewport's camera: each move keeps what it promises to keep."""

from __future__ import annotations

import math

import numpy as np
import pytest

from editor import camera_controls as cc
from editor.camera_controls import OrbitCamera

CAMERA = OrbitCamera(target=(1.0, 2.0, -3.0), yaw=0.7, pitch=-0.4, distance=4.0)


def pixel_of(camera: OrbitCamera, point: object, width: float = 800.0, height: float = 600.0) -> np.ndarray:
    pixels, depth = cc.project(camera, np.asarray([point], dtype=float), width, height)
    assert depth[0] > 0
    return pixels[0]


def test_the_pose_is_rigid_and_looks_at_the_target() -> None:
    m = CAMERA.world_from_camera()
    assert m[:3, :3] @ m[:3, :3].T == pytest.approx(np.eye(3), abs=1e-12)
    assert np.linalg.det(m[:3, :3]) == pytest.approx(1.0)
    assert m[:3, 3] - m[:3, 2] * CAMERA.distance == pytest.approx(CAMERA.target)
    assert pixel_of(CAMERA, CAMERA.target) == pytest.approx([400, 300])


def test_zero_angles_look_along_minus_z() -> None:
    camera = OrbitCamera(yaw=0.0, pitch=0.0, distance=2.0)
    assert camera.world_from_camera()[:3, :3] == pytest.approx(np.eye(3))
    assert camera.eye() == pytest.approx([0, 0, 2])


@pytest.mark.parametrize("roll", [0.0, 0.3])
@pytest.mark.parametrize(("yaw", "pitch"), [(0.0, 0.0), (2.5, 1.2), (-3.0, -0.7), (0.4, math.radians(89.95))])
def test_from_matrix_shows_the_same(yaw: float, pitch: float, roll: float) -> None:
    if abs(pitch) > cc.PITCH_LIMIT:
        roll = 0.0
    camera = OrbitCamera((3.0, -1.0, 2.0), yaw, pitch, roll, 7.0, 0.6)
    again = cc.from_matrix(camera.world_from_camera(), 7.0, 0.6)
    assert again.world_from_camera() == pytest.approx(camera.world_from_camera(), abs=1e-6)


def test_orbit_keeps_target_and_distance_and_follows_the_pointer() -> None:
    turned = cc.orbit(CAMERA, 60, -25)
    assert turned.target == CAMERA.target
    assert np.linalg.norm(turned.eye() - turned.target) == pytest.approx(CAMERA.distance)
    near_side = np.asarray(CAMERA.target) + CAMERA.rotation()[:, 2] * 1.0  # a point between eye and target
    before, after = pixel_of(CAMERA, near_side), pixel_of(turned, near_side)
    assert after[0] > before[0], "dragging right turns the near side right"
    assert after[1] < before[1], "dragging up turns the near side up"


def test_orbit_stops_short_of_the_poles() -> None:
    assert cc.orbit(CAMERA, 0, 1e6).pitch == pytest.approx(-cc.PITCH_LIMIT)
    assert cc.orbit(CAMERA, 0, -1e6).pitch == pytest.approx(cc.PITCH_LIMIT)


def test_pan_keeps_the_target_plane_under_the_pointer() -> None:
    moved = cc.pan(CAMERA, 37, -21, 600)
    assert pixel_of(moved, CAMERA.target) == pytest.approx([437, 279])
    assert (moved.yaw, moved.pitch, moved.distance) == (CAMERA.yaw, CAMERA.pitch, CAMERA.distance)


@pytest.mark.parametrize("factor", [0.5, 0.9, 1.7])
def test_zoom_keeps_the_point_under_the_cursor(factor: float) -> None:
    x, y, aspect = 0.6, -0.3, 800 / 600
    r = CAMERA.rotation()
    point = np.asarray(CAMERA.target) + (r[:, 0] * x * aspect + r[:, 1] * y) * CAMERA.ymag
    before = pixel_of(CAMERA, point)
    assert before == pytest.approx([400 * (1 + x), 300 * (1 - y)])
    zoomed = cc.zoom(CAMERA, factor, x, y, aspect)
    assert zoomed.distance == pytest.approx(CAMERA.distance * factor)
    assert pixel_of(zoomed, point) == pytest.approx(before)


def test_zoom_never_reaches_the_target() -> None:
    camera = CAMERA
    for _ in range(500):
        camera = cc.zoom(camera, 0.5)
    assert camera.distance == cc.MIN_DISTANCE
    assert np.isfinite(camera.world_from_camera()).all()


def test_dragging_up_or_right_comes_nearer() -> None:
    assert cc.dolly(CAMERA, 50, 0).distance < CAMERA.distance
    assert cc.dolly(CAMERA, 0, -50).distance < CAMERA.distance
    assert cc.dolly(CAMERA, 0, 100).distance == pytest.approx(CAMERA.distance * 2)


def test_look_keeps_the_eye() -> None:
    assert cc.look(CAMERA, 80, 30).eye() == pytest.approx(CAMERA.eye())


def test_fly_moves_by_the_metres_asked_for() -> None:
    forward = cc.fly(CAMERA, (0, 0, 1), 2.0)
    assert forward.eye() - CAMERA.eye() == pytest.approx(-CAMERA.rotation()[:, 2] * 2.0)
    up = cc.fly(CAMERA, (0, 1, 0), 3.0)
    assert up.eye() - CAMERA.eye() == pytest.approx([0, 3, 0])
    diagonal = cc.fly(CAMERA, (1, 0, 1), 1.0)
    assert np.linalg.norm(diagonal.eye() - CAMERA.eye()) == pytest.approx(1.0)
    assert cc.fly(CAMERA, (0, 0, 0), 5.0) == CAMERA


@pytest.mark.parametrize("aspect", [0.4, 1.0, 2.4])
def test_frame_fits_the_box(aspect: float) -> None:
    low, high = np.array([10.0, -2.0, 5.0]), np.array([14.0, 7.0, 6.0])
    camera = cc.frame(CAMERA, low, high, aspect)
    corners = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
    height = 500.0
    pixels, depth = cc.project(camera, corners, height * aspect, height)
    assert (depth > camera.znear).all()
    assert (pixels >= 0).all()
    assert (pixels <= [height * aspect, height]).all()
    spread = np.ptp(pixels, axis=0) / [height * aspect, height]
    assert spread.max() > 0.35, "framed, not far away"
    assert (camera.yaw, camera.pitch) == (CAMERA.yaw, CAMERA.pitch)


def test_frame_survives_empty_and_tiny_boxes() -> None:
    empty = cc.frame(CAMERA, np.full(3, np.inf), np.full(3, -np.inf), 1.5)
    assert np.isfinite(empty.world_from_camera()).all()
    assert empty.target == (0.0, 0.0, 0.0)
    point = cc.frame(CAMERA, np.ones(3), np.ones(3), 1.5)
    assert point.target == (1.0, 1.0, 1.0)
    assert 0.1 < point.distance < 10


@pytest.mark.parametrize(
    ("view", "eye"), [("front", (0, 0, 1)), ("right", (1, 0, 0)), ("top", (0, 1, 0)), ("left", (-1, 0, 0))]
)
def test_named_views_look_from_their_side(view: str, eye: tuple[float, ...]) -> None:
    camera = cc.along(OrbitCamera(distance=1.0), view)
    assert camera.eye() == pytest.approx(eye, abs=2e-3)


def test_far_from_the_origin_nothing_is_lost() -> None:
    far = OrbitCamera(target=(1e6, 2e6, -3e6), distance=3.0)
    moved = cc.pan(far, 10, 0, 600)
    assert pixel_of(moved, far.target) == pytest.approx([410, 300], abs=1e-3)


def test_the_orthographic_projection_does_not_depend_on_depth() -> None:
    camera = OrbitCamera(yaw=0.0, pitch=0.0, distance=4.0, orthographic=True)
    near, far = pixel_of(camera, (0.5, 0.5, 1.0)), pixel_of(camera, (0.5, 0.5, -9.0))
    assert near == pytest.approx(far)
    perspective = OrbitCamera(yaw=0.0, pitch=0.0, distance=4.0)
    assert pixel_of(perspective, (0.5, 0.5, 0.0)) == pytest.approx(near), "equal in the target's plane"
