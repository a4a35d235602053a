"""The light table as GPU structs: positions relative to the view's origin, angles as scale and offset."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from engine.assets.environment_dds import sun_direction
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


class LightRows:
    """`buffer`: the visible lights of a scene plus the environment's sun; `count` of them."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self.buffer: Buffer = device.buffer(LIGHT_LAYOUT.size, label="lights")
        self.count = 0
        self._last = b""

    def update(self, scene: Scene, origin: NDArray[np.float64], sun_scale: float, rotation: float) -> None:
        """Rebuild from the table; uploads only what differs from the last time."""
        world = scene.lights.world()
        sun = scene.environment.sun_illuminance * sun_scale
        has_sun = sun > 0.0
        rows = np.zeros(len(world) + has_sun, LIGHT_LAYOUT.dtype)
        if has_sun:
            turned = scene.environment.sun_azimuth + scene.environment.rotation + rotation
            rows["direction"][0] = -sun_direction(replace(scene.environment, sun_azimuth=turned))
            rows["color"][0] = sun
        lit = rows[int(has_sun) :]
        if len(world):
            lit["position"] = world["position"] - origin
            lit["range"] = world["range"]
            lit["direction"] = world["direction"]
            lit["type"] = world["type"]
            lit["color"] = world["radiant"]
            inner, outer = world["cos_inner"], world["cos_outer"]
            lit["spot_scale"] = 1.0 / np.maximum(inner - outer, 1e-4)  # equal angles would divide by zero
            lit["spot_offset"] = -outer * lit["spot_scale"]
        self.count = len(rows)
        data = rows.tobytes()
        if data == self._last or not data:
            return
        self._last = data
        if self.buffer.size < len(data):
            self.buffer.release()
            self.buffer = self._device.buffer(len(data), label="lights")
        self.buffer.write(data)

    def release(self) -> None:
        self.buffer.release()
