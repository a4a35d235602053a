"""Small scenes built so that they can be moved, scaled, mirrored and shuffled as a whole."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.assets.mesh import MeshAsset
from engine.assets.primitives import card, cube, plane, uv_sphere
from engine.assets.scene import LightAsset
from engine.math import quat
from engine.render.camera import Camera
from tests.support.stage import Stage, front_camera, surface


@dataclass(frozen=True)
class Change:
    """What is done to the whole scene, camera and lights included. `mirror` turns x round."""

    scale: float = 1.0
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    mirror: bool = False

    def place(self, position: ArrayLike) -> NDArray[np.float64]:
        flipped = np.asarray(position, np.float64) * ((-1.0 if self.mirror else 1.0), 1.0, 1.0)
        return flipped * self.scale + self.offset

    def turn(self, rotation: ArrayLike) -> NDArray[np.float64]:
        x, y, z, w = np.asarray(rotation, np.float64)
        return np.array([x, -y, -z, w] if self.mirror else [x, y, z, w])

    def size(self, scale: float) -> tuple[float, float, float]:
        return ((-1.0 if self.mirror else 1.0) * scale * self.scale, scale * self.scale, scale * self.scale)

    def light(self, light: LightAsset) -> LightAsset:
        """Candela grow with the square of the distances, so that the picture stays; lux and nit do not."""
        power = self.scale**2 if light.type in ("point", "spot") else 1.0
        s = self.scale
        return replace(
            light, intensity=light.intensity * power, range=light.range * s, width=light.width * s,
            height=light.height * s,
        )  # fmt: skip

    def camera(self, camera: Camera) -> Camera:
        pose = camera.world_from_camera.copy()
        pose[:3, 3] = self.place(pose[:3, 3])
        if self.mirror:  # a mirrored camera keeps its own right hand: only scenes seen along the axis are mirrored
            assert np.allclose(pose[:3, :3], np.eye(3))
        return replace(
            camera, world_from_camera=pose, znear=camera.znear * self.scale, zfar=camera.zfar * self.scale,
            ymag=camera.ymag * self.scale,
        )  # fmt: skip


class Placer:
    """Puts things on a stage under a Change."""

    def __init__(self, stage: Stage, change: Change) -> None:
        self.stage, self.change = stage, change

    def add(
        self, mesh: MeshAsset, position: ArrayLike, axis: ArrayLike = (0, 1, 0), angle: float = 0.0,
        scale: float = 1.0, queue: str = "opaque", **params: object,
    ) -> None:  # fmt: skip
        c = self.change
        turned = c.turn(quat.from_axis_angle(axis, angle))
        self.stage.add(mesh, surface(queue, **params), c.place(position), c.size(scale), turned)

    def lamp(self, light: LightAsset, position: ArrayLike, axis: ArrayLike = (1, 0, 0), angle: float = 0.0) -> None:
        c = self.change
        self.stage.lamp(c.light(light), c.place(position), c.turn(quat.from_axis_angle(axis, angle)))


def lamps(p: Placer) -> None:
    """Curved and flat, dull and shiny, under point and spot lights."""
    p.stage.look(kind="none", sun_illuminance=0.0, background="color", background_color=(0.02, 0.02, 0.03))
    p.add(plane(4.0), (0.0, -0.5, 0.0), base_color=(0.5, 0.5, 0.5, 1), metallic=0.0, roughness=0.8)
    p.add(uv_sphere(), (-0.5, 0.0, 0.0), base_color=(0.9, 0.3, 0.2, 1), metallic=0.0, roughness=0.3)
    p.add(cube(), (0.6, -0.1, 0.1), (0.3, 1.0, 0.2), 0.7, 0.6, base_color=(0.3, 0.6, 0.9, 1), roughness=0.5)
    p.lamp(LightAsset("point", intensity=2.0, range=6.0), (0.2, 1.2, 1.0))
    p.lamp(LightAsset("spot", (1.0, 0.8, 0.6), 6.0, 0.0, 0.2, 0.5), (-0.8, 1.5, 1.2), (1, 0.2, 0), -0.9)


def outdoors(p: Placer) -> None:
    """An environment and two directional lights."""
    p.stage.look(kind="uniform", color=(0.4, 0.5, 0.6), sun_illuminance=0.0, background="environment")
    p.add(uv_sphere(), (-0.4, 0.1, 0.0), base_color=(0.9, 0.8, 0.2, 1), metallic=1.0, roughness=0.25)
    p.add(cube(), (0.5, 0.0, -0.2), (0.1, 1.0, 0.0), 0.4, 0.7, base_color=(0.7, 0.7, 0.7, 1), metallic=0.0)
    p.lamp(LightAsset("directional", intensity=2.0), (0, 0, 0), (1.0, 0.3, 0.0), -0.8)


def panels(p: Placer) -> None:
    """Lights with an area: a rectangle from above, a disk from the side that shines both ways."""
    p.stage.look(kind="none", sun_illuminance=0.0, background="color", background_color=(0.02, 0.02, 0.03))
    p.add(plane(4.0), (0.0, -0.5, 0.0), base_color=(0.6, 0.6, 0.6, 1), metallic=0.0, roughness=0.4)
    p.add(uv_sphere(), (0.1, 0.0, 0.0), base_color=(0.9, 0.8, 0.7, 1), metallic=0.5, roughness=0.3)
    p.lamp(LightAsset("rectangle", intensity=3.0, width=0.8, height=0.4), (0.2, 1.3, 0.4), (1, 0, 0), -1.3)
    disk = LightAsset("disk", (0.4, 0.7, 1.0), 4.0, width=0.5, height=0.5, two_sided=True)
    p.lamp(disk, (-1.0, 0.2, 0.5), (0, 1, 0), -1.2)


def glass(p: Placer) -> None:
    """Blended sheets in front of and behind each other, and of something solid."""
    p.stage.look(kind="uniform", color=(0.7, 0.7, 0.7), sun_illuminance=0.0, background="color")
    p.add(cube(), (0.0, 0.0, -0.6), (0.0, 1.0, 0.0), 0.5, 0.7, base_color=(0.7, 0.7, 0.7, 1), metallic=0.0)
    for i, color in enumerate([(1, 0, 0, 0.4), (0, 1, 0, 0.6), (0, 0, 1, 0.3)]):
        p.add(card(0.8), (-0.3 + 0.3 * i, 0.1 * i, 0.2 * i), queue="transparent", base_color=color, roughness=0.6)


SCENES: dict[str, Callable[[Placer], None]] = {"lamps": lamps, "outdoors": outdoors, "panels": panels, "glass": glass}


def picture(
    stage: Stage, scene: str, change: Change = Change(), size: tuple[int, int] = (72, 56), **settings: object
) -> NDArray[np.float32]:
    """The linear picture of a scene under a change, seen by the camera that went along."""
    SCENES[scene](Placer(stage, change))
    return stage.hdr(size, change.camera(front_camera(0.9, size[0] / size[1])), **settings)


def differing(a: NDArray[np.float32], b: NDArray[np.float32], tolerance: float = 1e-3) -> float:
    """The part of the pixels that differ by more than `tolerance` times (1 + their brightness)."""
    apart = np.abs(a - b)[..., :3] > tolerance * (1.0 + np.maximum(a, b)[..., :3])
    return float(apart.any(axis=-1).mean())
