"""Made scenes that are lit by their own surfaces: a box with two blocks, and the atrium in the sun."""

from __future__ import annotations

import importlib
import math
from typing import TYPE_CHECKING, Any

from engine.assets.material import MaterialAsset
from engine.assets.primitives import card, cube, uv_sphere
from engine.assets.samples import SAMPLES
from engine.assets.scene import EnvironmentAsset, LightAsset
from engine.math import quat
from engine.math.transform import look_at
from engine.render.camera import Camera
from engine.resources.samples import sample_scene

if TYPE_CHECKING:
    from engine.experiments.harness.scenes import MadeScene

X, Y = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
WHITE, RED, GREEN = (0.7, 0.7, 0.7), (0.6, 0.06, 0.05), (0.1, 0.45, 0.1)


def matt(color: tuple[float, float, float], **more: Any) -> MaterialAsset:
    """Diffuse alone: nothing mirrors."""
    params = {"metallic": 0.0, "roughness": 1.0, "ior": 1.0, "specular": 0.0}
    return MaterialAsset("matt", params={"base_color": (*color, 1.0), **params, **more})


def box(scene: MadeScene) -> None:
    """A box of matt walls, open to the camera, with two blocks, by a point light under its ceiling (in the manner of
    Goral et al. 1984, with sizes and colours of our own)."""
    scene.scene.environment = EnvironmentAsset(
        kind="none", sun_illuminance=0.0, background="color", background_color=(0.0, 0.0, 0.0)
    )
    scene.scene.look.tone_map = "none"
    half = math.pi / 2.0
    for color, place, axis, angle in (
        (WHITE, (0, 0, -1), Y, 0.0), (WHITE, (0, -1, 0), X, -half), (WHITE, (0, 1, 0), X, half),
        (RED, (-1, 0, 0), Y, half), (GREEN, (1, 0, 0), Y, -half),
    ):  # fmt: skip
        scene.add(card(2.0), matt(color), place, quat.from_axis_angle(axis, angle))
    scene.add(cube(1.0), matt(WHITE), (-0.35, -0.4, -0.3), quat.from_axis_angle(Y, 0.35), (0.55, 1.2, 0.55))
    scene.add(cube(1.0), matt(WHITE), (0.35, -0.7, 0.3), quat.from_axis_angle(Y, -0.3), (0.55, 0.6, 0.55))
    scene.lamp(LightAsset("point", (1.0, 0.9, 0.7), 3.0), (0.0, 0.75, 0.0))
    scene.view_from = Camera(look_at((0.0, 0.0, 3.6), (0.0, 0.0, 0.0)), 0.62)


def mirrors(scene: MadeScene) -> None:
    """The box with a mirror for a floor and a ball of polished metal between its blocks."""
    box(scene)
    floor = MaterialAsset("mirror", params={"base_color": (0.8, 0.8, 0.85, 1.0), "metallic": 1.0, "roughness": 0.1})
    scene.add(card(2.0), floor, (0.0, -0.995, 0.0), quat.from_axis_angle(X, -math.pi / 2.0))
    metal = MaterialAsset("metal", params={"base_color": (0.95, 0.8, 0.5, 1.0), "metallic": 1.0, "roughness": 0.15})
    scene.add(uv_sphere(0.3, 32, 64), metal, (-0.3, -0.69, 0.5))
    scene.view_from = Camera(look_at((0.0, 0.3, 3.6), (0.0, 0.0, 0.0)), 0.82)  # what is mirrored is in the picture


def atrium(scene: MadeScene) -> None:
    """The sample of that name without its lamps but one, in the sun, under an even sky."""
    sample = importlib.import_module(SAMPLES["atrium"][0]).build(1, 1, 1.0)
    scene.scene = sample_scene(sample, scene.residency)
    scene.scene.environment = EnvironmentAsset(
        kind="uniform", color=(0.6, 0.75, 1.0), intensity=0.5, sun_illuminance=8.0, sun_elevation=1.0, sun_azimuth=0.5,
        background="color", background_color=(0.0, 0.0, 0.0),
    )  # fmt: skip
    scene.scene.look.tone_map, scene.scene.look.exposure = "none", 0.0
    cameras = scene.scene.cameras
    scene.view_from = Camera.from_asset(cameras.asset(0), scene.scene.nodes.world_matrix(int(cameras.node[0])))
