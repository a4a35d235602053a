"""The viewport's camera: pure moves of an orbit camera. No imgui, no GPU.

The camera looks along its local -Z at `target` from `distance` metres; its orientation is Ry(yaw) Rx(pitch) Rz(roll)
(right-handed, +Y up). Every move returns a new camera, so a gesture can be replayed or undone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Vec3 = NDArray[np.float64]

#: just short of straight up or down, where yaw and roll would become the same angle
PITCH_LIMIT = math.radians(89.9)
#: radians a drag of one pixel turns the camera: 400 px is half a turn
TURN_PER_PIXEL = math.pi / 400.0
MIN_DISTANCE, MAX_DISTANCE = 1e-6, 1e9
#: named directions -> (yaw, pitch) of the camera that sees that side
VIEWS = {
    "front": (0.0, 0.0),
    "back": (math.pi, 0.0),
    "right": (math.pi / 2, 0.0),
    "left": (-math.pi / 2, 0.0),
    "top": (0.0, -math.pi / 2),
    "bottom": (0.0, math.pi / 2),
}


@dataclass(frozen=True, slots=True)
class OrbitCamera:
    """Angles in radians, lengths in metres. `orthographic` keeps the size seen at the target."""

    target: tuple[float, float, float] = (0.0, 0.0, 0.0)
    yaw: float = 0.6
    pitch: float = -0.35
    roll: float = 0.0
    distance: float = 5.0
    yfov: float = math.radians(45.0)
    orthographic: bool = False

    @property
    def znear(self) -> float:
        """Near plane that follows the distance, so that a watch and a valley both show; reversed z affords it."""
        return min(max(0.01 * self.distance, 1e-6), 0.05)

    @property
    def ymag(self) -> float:
        """Half the height seen at the target, metres."""
        return self.distance * math.tan(0.5 * self.yfov)

    def rotation(self) -> NDArray[np.float64]:
        """f8[3,3], world from camera."""
        cy, sy = math.cos(self.yaw), math.sin(self.yaw)
        cp, sp = math.cos(self.pitch), math.sin(self.pitch)
        cr, sr = math.cos(self.roll), math.sin(self.roll)
        yaw = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
        pitch = np.array([[1, 0, 0], [0, cp, -sp], [0, sp, cp]])
        roll = np.array([[cr, -sr, 0], [sr, cr, 0], [0, 0, 1]])
        return np.asarray(yaw @ pitch @ roll, dtype=np.float64)

    def eye(self) -> Vec3:
        return np.asarray(np.asarray(self.target) + self.rotation()[:, 2] * self.distance)

    def world_from_camera(self) -> NDArray[np.float64]:
        """f8[4,4], column vectors."""
        matrix = np.eye(4)
        matrix[:3, :3] = self.rotation()
        matrix[:3, 3] = self.eye()
        return matrix


def from_matrix(world_from_camera: NDArray[np.float64], distance: float, yfov: float) -> OrbitCamera:
    """The orbit camera that shows what a rigid `world_from_camera` f8[4,4] shows, looking `distance` metres ahead."""
    m = np.asarray(world_from_camera, dtype=np.float64)
    basis = m[:3, :3] / np.linalg.norm(m[:3, :3], axis=0)
    # Ry Rx Rz, read off the matrix: its third column is (sin yaw cos pitch, -sin pitch, cos yaw cos pitch)
    pitch = math.asin(float(np.clip(-basis[1, 2], -1.0, 1.0)))
    if abs(pitch) < PITCH_LIMIT:
        yaw = math.atan2(basis[0, 2], basis[2, 2])
        roll = math.atan2(basis[1, 0], basis[1, 1])
    else:  # looking straight up or down: all turn is yaw
        yaw, roll = math.atan2(-basis[2, 0], basis[0, 0]), 0.0
    target = m[:3, 3] - basis[:, 2] * distance
    return OrbitCamera(_tuple(target), yaw, pitch, roll, distance, yfov)


def orbit(camera: OrbitCamera, dx: float, dy: float) -> OrbitCamera:
    """Turn about the target by a drag of (dx, dy) pixels, y down: the scene follows the pointer. Roll is levelled."""
    pitch = min(max(camera.pitch - dy * TURN_PER_PIXEL, -PITCH_LIMIT), PITCH_LIMIT)
    return replace(camera, yaw=_wrap(camera.yaw - dx * TURN_PER_PIXEL), pitch=pitch, roll=0.0)


def look(camera: OrbitCamera, dx: float, dy: float) -> OrbitCamera:
    """Turn about the eye (fly mode): the eye stays, the target swings."""
    eye = camera.eye()
    turned = orbit(camera, dx * 0.5, dy * 0.5)
    return replace(turned, target=_tuple(eye - turned.rotation()[:, 2] * camera.distance))


def pan(camera: OrbitCamera, dx: float, dy: float, height: float) -> OrbitCamera:
    """Slide by a drag of (dx, dy) pixels in a view `height` pixels high: what lies at the target stays under the
    pointer."""
    metres = 2.0 * camera.ymag / max(height, 1.0)
    rotation = camera.rotation()
    shift = rotation[:, 1] * (dy * metres) - rotation[:, 0] * (dx * metres)
    return replace(camera, target=_tuple(np.asarray(camera.target) + shift))


def zoom(camera: OrbitCamera, factor: float, x: float = 0.0, y: float = 0.0, aspect: float = 1.0) -> OrbitCamera:
    """Scale the distance by `factor`; the point at target depth under (x, y) in [-1,1], y up, stays there."""
    distance = min(max(camera.distance * factor, MIN_DISTANCE), MAX_DISTANCE)
    factor = distance / camera.distance
    rotation = camera.rotation()
    offset = (rotation[:, 0] * (x * aspect) + rotation[:, 1] * y) * camera.ymag
    return replace(camera, distance=distance, target=_tuple(np.asarray(camera.target) + offset * (1.0 - factor)))


def dolly(camera: OrbitCamera, dx: float, dy: float) -> OrbitCamera:
    """Zoom by a drag: right or up comes nearer; 100 pixels halve the distance."""
    return zoom(camera, 2.0 ** (-(dx - dy) / 100.0))


def fly(camera: OrbitCamera, move: tuple[float, float, float], metres: float) -> OrbitCamera:
    """Move eye and target by `metres` along `move` = (right, up, forward) in the camera's frame; up is world up."""
    rotation = camera.rotation()
    step = rotation[:, 0] * move[0] + np.array([0.0, 1.0, 0.0]) * move[1] - rotation[:, 2] * move[2]
    length = float(np.linalg.norm(step))
    if length < 1e-9:
        return camera
    return replace(camera, target=_tuple(np.asarray(camera.target) + step * (metres / length)))


def frame(camera: OrbitCamera, low: Vec3, high: Vec3, aspect: float) -> OrbitCamera:
    """Look at the box [`low`, `high`] from the same side so that its bounding sphere fits with a tenth to spare.

    An empty or non-finite box frames a sphere of one metre at the origin."""
    low, high = np.asarray(low, dtype=np.float64), np.asarray(high, dtype=np.float64)
    if not (np.isfinite(low).all() and np.isfinite(high).all() and (high >= low).all()):
        low, high = np.full(3, -0.5), np.full(3, 0.5)
    radius = 0.5 * float(np.linalg.norm(high - low))
    if radius <= 0.0:
        radius = 0.5
    half = 0.5 * camera.yfov
    if aspect < 1.0:  # a tall view is narrower than high
        half = math.atan(math.tan(half) * aspect)
    return replace(camera, target=_tuple(0.5 * (low + high)), distance=1.1 * radius / math.sin(half), roll=0.0)


def along(camera: OrbitCamera, view: str) -> OrbitCamera:
    """The same target and distance, seen from a side named in VIEWS."""
    yaw, pitch = VIEWS[view]
    return replace(camera, yaw=yaw, pitch=min(max(pitch, -PITCH_LIMIT), PITCH_LIMIT), roll=0.0)


def project(
    camera: OrbitCamera, points: NDArray[np.float64], width: float, height: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Pixels f8[n,2] from the top left, and depth f8[n] along the view in metres, of `points` f8[n,3]."""
    local = (np.asarray(points, dtype=np.float64) - camera.eye()) @ camera.rotation()
    depth = -local[:, 2]
    scale = camera.ymag if camera.orthographic else np.maximum(depth, 1e-12) * math.tan(0.5 * camera.yfov)
    pixels = np.empty((len(local), 2))
    pixels[:, 0] = width * 0.5 + local[:, 0] / scale * (height * 0.5)
    pixels[:, 1] = height * 0.5 - local[:, 1] / scale * (height * 0.5)
    return pixels, depth


def _tuple(v: NDArray[np.float64]) -> tuple[float, float, float]:
    return float(v[0]), float(v[1]), float(v[2])


def _wrap(angle: float) -> float:
    return math.remainder(angle, math.tau)
