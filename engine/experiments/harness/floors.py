"""A polished floor under things that stand on it and hang over it: what flat mirrors show, near and far."""

from __future__ import annotations

import math

from engine.assets.material import MaterialAsset
from engine.assets.primitives import cube, plane, uv_sphere
from engine.assets.scene import EnvironmentAsset, LightAsset
from engine.experiments.harness.scenes import MadeScene
from engine.math import quat
from engine.math.transform import look_at
from engine.render.camera import Camera


def polished(scene: MadeScene, roughness: float) -> None:
    """A dark dielectric floor of that roughness with pillars, a ball and a bar, by two lamps."""
    scene.scene.environment = EnvironmentAsset(
        kind="none", sun_illuminance=0.0, background="color", background_color=(0.0, 0.0, 0.0)
    )
    scene.scene.look.tone_map = "none"
    params = {"base_color": (0.04, 0.04, 0.05, 1.0), "metallic": 0.0, "roughness": roughness, "ior": 2.0}
    scene.add(plane(8.0), MaterialAsset("polished", features=["planar_reflection"], params=params))

    def matt(*color: float) -> MaterialAsset:
        values = {"base_color": (*color, 1.0), "metallic": 0.0, "roughness": 0.9, "specular": 0.0}
        return MaterialAsset("matt", params=values)

    scene.add_many(cube(1.0), matt(0.8, 0.3, 0.15), [(x, 0.9, -1.2) for x in (-1.6, 0.0, 1.6)], scale=(0.25, 1.8, 0.25))
    scene.add(uv_sphere(0.4, 24, 48), matt(0.2, 0.6, 0.25), (-0.7, 0.4, 0.3))
    tilted = quat.from_axis_angle((0.0, 0.0, 1.0), math.pi / 10)
    scene.add(cube(1.0), matt(0.85, 0.8, 0.3), (0.8, 0.9, 0.0), tilted, (1.1, 0.16, 0.3))
    scene.lamp(LightAsset("point", (1.0, 0.9, 0.8), 6.0), (0.4, 2.2, 2.0))
    scene.lamp(LightAsset("point", (0.5, 0.7, 1.0), 3.0), (-2.0, 0.6, 2.4))
    scene.view_from = Camera(look_at((0.3, 1.1, 3.6), (0.0, 0.35, 0.0)), 0.75)
