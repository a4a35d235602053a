"""The light table as GPU structs: positions relative to the view's origin, angles as scale and offset."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from engine.assets.environment_dds import sun_direction
from engine.assets.scene import EnvironmentAsset
from engine.gpu.glsl_layout import Field, layout
from engine.gpu.types import Buffer, Device
from engine.scene.light_order import canonical_order
from engine.scene.lights import WORLD_LIGHT
from engine.scene.scene import Scene

LIGHT_LAYOUT = layout(
    [
        Field("position", "vec3"),  # m, relative to the view's origin
        Field("range", "float"),  # m; 0 = unlimited
        Field("direction", "vec3"),  # where it shines, unit, world
        Field("type", "uint"),  # index of LIGHT_TYPES: 0 directional, 1 point, 2 spot, 3 rectangle, 4 disk
        Field("color", "vec3"),  # lux (directional), candela (point, spot) or nit (area), scene-linear
        Field("spot_scale", "float"),  # KHR_lights_punctual: 1 / (cos inner - cos outer)
        Field("right", "vec3"),  # unit, world: the width's direction of area lights, horizontal angle 0 of profiles
        Field("spot_offset", "float"),  # -cos outer * scale
        Field("half_size", "vec2"),  # m; of area lights, of others both the radius of what shines
        Field("two_sided", "uint"),  # 1: an area light shines to the back too
        Field("profile", "int"),  # layer of the profiles' texture, or -1
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


#: farther is drawn here: squares of it stay within float32
_FAR = 1e18


@dataclass(frozen=True, slots=True)
class LightBounds:
    """What each light of the buffer can reach at most, row by row: beyond it, its contribution is exactly 0.

    `center` f4[n,3] relative to the view's origin; `radius` f4[n], inf = endless; `axis` f4[n,3], `cos_angle` f4[n]:
    the cone around the axis, from the centre, in which a spot shines; -1 = all around.
    """

    center: NDArray[np.float32]
    radius: NDArray[np.float32]
    axis: NDArray[np.float32]
    cos_angle: NDArray[np.float32]


class LightRows:
    """The visible lights of a scene plus the environment's sun.

    `suns`: f4[MAX_SUNS,2,4], direction and illuminance (lux) of `sun_count` directional ones; `buffer`: `count` others,
    in an order of their values alone (engine/scene/light_order.py), so that rows can be permuted without any pixel's
    sum changing. `bounds` belongs to them, and is another object whenever anything in the buffer changed.
    """

    def __init__(self, device: Device) -> None:
        self._device = device
        self.buffer: Buffer = device.buffer(LIGHT_LAYOUT.size, label="lights")
        self.count = 0
        self.sun_count = 0
        self.suns = np.zeros((MAX_SUNS, 2, 4), np.float32)
        self.bounds = _bounds(np.zeros(0, LIGHT_LAYOUT.dtype))
        self._world: NDArray[np.void] | None = None
        self._rest: NDArray[np.void] = np.zeros(0, WORLD_LIGHT)
        self._directional = self._rest
        self._key: tuple[object, ...] = ()

    def update(
        self, scene: Scene, environment: EnvironmentAsset, origin: NDArray[np.float64], sun_scale: float,
        rotation: float, layers: NDArray[np.int32] | None = None,
    ) -> None:  # fmt: skip
        """Bring all up to date; does nothing where neither a light, the origin nor the sun changed.

        `rotation`: the view's, radians; `layers`: i4, layer of the profiles' texture by LightTable.profiles.
        """
        world = scene.lights.world()
        sun = environment.sun_illuminance * sun_scale
        turned = environment.sun_azimuth + environment.rotation + rotation
        layer_key = None if layers is None else layers.tobytes()
        key = (sun > 0.0, sun, turned, environment.sun_elevation, tuple(origin.tolist()), layer_key)
        if world is self._world and key == self._key:  # held, so that `is` cannot take another array for it
            return
        if world is not self._world or key[:1] != self._key[:1]:
            directional = np.flatnonzero(world["type"] == 0)
            own = MAX_SUNS - (1 if sun > 0.0 else 0)
            local = world[world["type"] != 0]
            self._rest = np.concatenate([world[directional[own:]], local[canonical_order(local)]])
            self._directional = world[directional[:own]]
        self._world, self._key = world, key
        self._set_suns(environment, sun, turned)
        self.count = len(self._rest)
        rows = light_rows(self._rest, origin, layers)
        self.bounds = _bounds(rows)
        if self.count:
            self._upload(rows)

    @property
    def world(self) -> NDArray[np.void]:
        """WORLD_LIGHT rows in the order of the buffer; another object whenever one changed."""
        return self._rest

    def _set_suns(self, environment: EnvironmentAsset, sun: float, azimuth: float) -> None:
        suns = list(zip(self._directional["direction"], self._directional["radiant"], strict=True))
        if sun > 0.0:
            suns.insert(0, (-sun_direction(replace(environment, sun_azimuth=azimuth)), np.full(3, sun)))
        self.sun_count = len(suns)
        self.suns[...] = 0.0
        for i, (direction, color) in enumerate(suns):
            self.suns[i, 0, :3], self.suns[i, 1, :3] = direction, color

    def _upload(self, rows: NDArray[np.void]) -> None:
        if self.buffer.size < rows.nbytes:
            self.buffer.release()
            self.buffer = self._device.buffer(rows.nbytes, label="lights")
        self.buffer.write(rows.view(np.uint8))

    def release(self) -> None:
        self.buffer.release()


def light_rows(
    world: NDArray[np.void], origin: NDArray[np.float64], layers: NDArray[np.int32] | None = None
) -> NDArray[np.void]:
    """WORLD_LIGHT rows as LIGHT_LAYOUT rows."""
    rows = np.zeros(len(world), LIGHT_LAYOUT.dtype)
    rows["position"] = np.clip(world["position"] - origin, -_FAR, _FAR)
    for name in ("range", "direction", "type", "right", "half_size", "two_sided"):
        rows[name] = world[name]
    rows["color"] = world["radiant"]
    inner, outer = world["cos_inner"], world["cos_outer"]
    rows["spot_scale"] = 1.0 / np.maximum(inner - outer, 1e-4)  # equal angles would divide by zero
    rows["spot_offset"] = -outer * rows["spot_scale"]
    rows["profile"] = -1
    if layers is not None and len(layers):
        shaped = world["profile"] >= 0
        rows["profile"][shaped] = layers[world["profile"][shaped]]
    return rows


def _bounds(rows: NDArray[np.void]) -> LightBounds:
    size = np.where(rows["type"] >= 3, np.hypot(rows["half_size"][:, 0], rows["half_size"][:, 1]), np.float32(0.0))
    endless = (rows["range"] <= 0.0) | (rows["type"] == 0)
    # a bit beyond the range, as the shader's own distance is rounded
    radius = np.where(endless, np.float32(np.inf), (rows["range"] + size) * np.float32(1.0 + 1e-5))
    spot = rows["type"] == 2
    cos_outer = np.where(spot, -rows["spot_offset"] / np.where(spot, rows["spot_scale"], 1.0), -1.0)
    return LightBounds(
        np.ascontiguousarray(rows["position"]), radius.astype(np.float32), np.ascontiguousarray(rows["direction"]),
        np.where(spot, np.maximum(cos_outer - 1e-5, -1.0), -1.0).astype(np.float32),
    )  # fmt: skip
