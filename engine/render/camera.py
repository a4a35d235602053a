"""Camera: a pose and a projection."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from engine.assets.scene import CameraAsset
from engine.core.errors import InputError
from engine.math.projection import orthographic_reversed, perspective_reversed
from engine.math.quat import to_matrix3
from engine.math.transform import decompose, inverse_affine
from engine.scene.cameras import sanitize


@dataclass(slots=True)
class Camera:
    """`world_from_camera` f8[4,4], rigid; looks along its local -Z. `ymag` > 0 makes it orthographic (half height, m).

    `yfov` is vertical, radians; `znear` metres; `zfar` is used by the orthographic projection only.
    """

    world_from_camera: NDArray[np.float64] = field(default_factory=lambda: np.eye(4))
    yfov: float = math.radians(45.0)
    znear: float = 0.05
    zfar: float = 1000.0
    ymag: float = 0.0

    @classmethod
    def from_asset(cls, asset: CameraAsset, world: NDArray[np.float64]) -> Camera:
        """A scene's camera in its node's frame; scale and shear of the node are left out (glTF 2.0, 3.10).

        A lens that cannot be is made usable (engine.scene.cameras.sanitize; loading the scene says so), and a node
        whose scale is 0 keeps the directions it has left."""
        asset = sanitize(asset)
        pose = np.eye(4)
        with np.errstate(over="ignore", invalid="ignore"):
            z = world[:3, 2] / max(float(np.linalg.norm(world[:3, 2])), 1e-300)
            x = np.cross(world[:3, 1], z)
            x /= max(float(np.linalg.norm(x)), 1e-300)
            pose[:3, 0], pose[:3, 1], pose[:3, 2] = x, np.cross(z, x), z
        if not abs(float(np.linalg.det(pose[:3, :3])) - 1.0) < 1e-6:
            linear = np.eye(4)
            linear[:3, :3] = np.nan_to_num(world[:3, :3], posinf=0.0, neginf=0.0)
            _, rotation, _ = decompose(linear)
            pose[:3, :3] = to_matrix3(rotation)
        pose[:3, 3] = np.nan_to_num(world[:3, 3])
        orthographic = asset.type == "orthographic"
        return cls(pose, asset.yfov, asset.znear, asset.zfar or 1e6, asset.ymag if orthographic else 0.0)

    @property
    def position(self) -> NDArray[np.float64]:
        return self.world_from_camera[:3, 3]

    def check(self, aspect: float) -> None:
        """Raise InputError where no picture can be taken: a pose that is not finite or flat, an impossible lens."""
        self.clip_from_view(aspect)
        pose = self.world_from_camera
        lengths = float(np.prod(np.linalg.norm(pose[:3, :3], axis=0)))
        if not (np.isfinite(pose).all() and abs(float(np.linalg.det(pose[:3, :3]))) > 1e-9 * lengths > 0.0):
            raise InputError(
                f"impossible camera: its pose is flat or not finite: {pose[:3].tolist()}",
                hint="place the camera again; its axes must be at right angles and of length 1",
            )

    def clip_from_view(self, aspect: float) -> NDArray[np.float64]:
        if self.ymag > 0.0:
            return orthographic_reversed(self.ymag, aspect, self.znear, self.zfar)
        return perspective_reversed(self.yfov, aspect, self.znear)

    def view_from_world(self) -> NDArray[np.float64]:
        return inverse_affine(self.world_from_camera)

    def clip_from_world(self, aspect: float) -> NDArray[np.float64]:
        return self.clip_from_view(aspect) @ self.view_from_world()

    def key(self) -> tuple[object, ...]:
        """Equal keys give equal pictures of an unchanged scene."""
        return (self.world_from_camera.tobytes(), self.yfov, self.znear, self.zfar, self.ymag)
