"""A slab of clear glass before a wall that says of each place where it is, seen aslant."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from engine.assets.material import MaterialAsset
from engine.assets.primitives import card
from engine.assets.scene import EnvironmentAsset
from engine.experiments.harness.scenes import MADE, MadeScene
from engine.gpu.types import Device
from engine.math.transform import look_at
from engine.render.camera import Camera

F8 = NDArray[np.float64]

#: radians that the camera stands off the slab's normal; metres: half of the wall's width, and how far the camera is
ASLANT, WALL, AWAY = 0.8, 4.0, 3.0


@dataclass(frozen=True, slots=True)
class Slab:
    """`thickness` metres of glass of index `ior`, its front at z = 0; a wall `gap` metres behind it."""

    thickness: float
    gap: float
    ior: float = 1.5

    @property
    def wall(self) -> float:
        """z of the wall."""
        return -self.thickness - self.gap

    @property
    def camera(self) -> Camera:
        """Looks at the wall's middle through the slab."""
        eye = (AWAY * math.sin(ASLANT), 0.0, AWAY * math.cos(ASLANT))
        return Camera(look_at(eye, (0.0, 0.0, self.wall)), 0.6)

    def exact(self, start: F8, d: F8) -> F8:
        """x and y f8[n,2] of the wall that rays from `start` f8[n,3] along the units `d` f8[n,3] come to (Snell)."""
        n = np.array([0.0, 0.0, 1.0])
        cos = -d[:, 2]
        front = start - d * (start[:, 2] / d[:, 2])[:, None]
        eta = 1.0 / self.ior
        inner = eta * d + (eta * cos - np.sqrt(1.0 - eta * eta * (1.0 - cos * cos)))[:, None] * n
        back = front + inner * (self.thickness / -inner[:, 2])[:, None]
        at: F8 = (back + d * ((self.wall - back[:, 2]) / d[:, 2])[:, None])[:, :2]
        return at

    def build(self, device: Device) -> MadeScene:
        """The caller closes it. The wall's red and green are its x and y, from 0 to 1 over its width."""
        scene = MadeScene(f"{MADE}slab", device)
        scene.scene.environment = EnvironmentAsset(
            kind="none", sun_illuminance=0.0, background="color", background_color=(0.0, 0.0, 0.0)
        )
        scene.scene.look.tone_map = "none"
        wall = card(2.0 * WALL)
        place = np.asarray(wall.streams["position"], np.float64)[:, :2] / (2.0 * WALL) + 0.5
        color = np.rint(np.hstack([place, np.zeros((4, 1)), np.ones((4, 1))]) * 65535.0).astype(np.uint16)
        wall = replace(wall, streams={**wall.streams, "color": color})
        scene.add(wall, MaterialAsset("wall", features=["unlit"]), (0.0, 0.0, self.wall))
        params = {
            "metallic": 0.0, "roughness": 0.0, "specular": 0.0, "ior": self.ior, "thickness": self.thickness,
        }  # fmt: skip
        glass = MaterialAsset("glass", effect="layered", features=["transmission"], params=params)
        scene.add(card(8.0), glass)
        scene.view_from = self.camera
        return scene
