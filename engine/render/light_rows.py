"""The light table as GPU structs: positions relative to the view's origin, angles as scale and offset."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from engine.assets.environment_dds import sun_direction
from engine.assets.scene import EnvironmentAsset
from engine.gpu.glsl_layout import Field, layout
from engine.gpu.types import Buffer, Device
from engine.scene.scene import Scene

LIGHT_LAYOUT = layout(
    [
        Field("position", "vec3"),  # m, relative to the view's origin
        Field("range", "float"),  # m; 0 = unlimited
        Field("direction", "vec3"),  # where it shines, unit, world
        Field("type", "uint"),  # 0 directional, 1 point, 2 spot
        Field("color", "vec3"),  # lux (directional) or candela, scene-linear
        Field("spot_scale", "float"),  # KHR_lights_punctual: 1 / (cos inner - cos outer)
        Field("spot_offset", "float"),  # -cos outer * scale
    ],
    rule="std430",
)


def light_glsl(binding: int) -> str:
    """The struct and its buffer, for the shaders' prelude."""
    return (
        LIGHT_LAYOUT.struct_glsl("Light")
        + f"\nlayout(std430, binding = {binding}) readonly buffer LightBlock {{ Light lights[]; }};\n"
    )


#: so many directional lights live in the view block, where every pixel reads them at no cost; the rest in the buffer
MAX_SUNS = 4


class LightRows:
    """The visible lights of a scene plus the environment's sun.

    `suns`: f4[MAX_SUNS,2,4], direction and illuminance (lux) of `sun_count` directional ones; `buffer`: `count` others.
    """

    def __init__(self, device: Device) -> None:
        self._device = device
        self.buffer: Buffer = device.buffer(LIGHT_LAYOUT.size, label="lights")
        self.count = 0
        self.sun_count = 0
        self.suns = np.zeros((MAX_SUNS, 2, 4), np.float32)
        self._last = b""

    def update(
        self, scene: Scene, environment: EnvironmentAsset, origin: NDArray[np.float64], sun_scale: float,
        rotation: float,
    ) -> None:  # fmt: skip
        """Rebuild from the table; uploads only what differs from the last time. `rotation`: the view's, radians."""
        world = scene.lights.world()
        directional = np.flatnonzero(world["type"] == 0)
        suns = [(world["direction"][i], world["radiant"][i]) for i in directional[:MAX_SUNS].tolist()]
        overflow = directional[MAX_SUNS:]
        sun = environment.sun_illuminance * sun_scale
        if sun > 0.0:
            turned = environment.sun_azimuth + environment.rotation + rotation
            suns.insert(0, (-sun_direction(replace(environment, sun_azimuth=turned)), np.full(3, sun)))
            overflow = directional[MAX_SUNS - 1 :]
        self.sun_count = min(len(suns), MAX_SUNS)
        self.suns[...] = 0.0
        for i, (direction, color) in enumerate(suns[:MAX_SUNS]):
            self.suns[i, 0, :3], self.suns[i, 1, :3] = direction, color
        rest = np.concatenate([overflow, np.flatnonzero(world["type"] != 0)])
        self.count = len(rest)
        if len(rest):
            self._upload(_light_rows(world[rest], origin))

    def _upload(self, rows: NDArray[np.void]) -> None:
        data = rows.tobytes()
        if data == self._last:
            return
        self._last = data
        if self.buffer.size < len(data):
            self.buffer.release()
            self.buffer = self._device.buffer(len(data), label="lights")
        self.buffer.write(data)

    def release(self) -> None:
        self.buffer.release()


def _light_rows(world: NDArray[np.void], origin: NDArray[np.float64]) -> NDArray[np.void]:
    """WORLD_LIGHT rows as LIGHT_LAYOUT rows."""
    rows = np.zeros(len(world), LIGHT_LAYOUT.dtype)
    rows["position"] = world["position"] - origin
    rows["range"] = world["range"]
    rows["direction"] = world["direction"]
    rows["type"] = world["type"]
    rows["color"] = world["radiant"]
    inner, outer = world["cos_inner"], world["cos_outer"]
    rows["spot_scale"] = 1.0 / np.maximum(inner - outer, 1e-4)  # equal angles would divide by zero
    rows["spot_offset"] = -outer * rows["spot_scale"]
    return rows
