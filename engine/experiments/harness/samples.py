"""Small scenes made of shapes: each shows one thing that a renderer may leave out, or is lit in one way.

So that measurements on whole pictures need no file besides the engine's own.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from engine.assets.dds import write_dds
from engine.assets.material import MaterialAsset, TextureRef
from engine.assets.primitives import card, cube, plane, uv_sphere
from engine.assets.scene import EnvironmentAsset, LightAsset
from engine.assets.texture import TextureAsset
from engine.core.errors import InputError
from engine.experiments.harness import floors, rooms
from engine.experiments.harness.scenes import MADE, MadeScene
from engine.gpu.types import Device
from engine.math import quat
from engine.math.transform import look_at
from engine.render.camera import Camera

#: a light's -Z turned down, and down with a slant
DOWN = quat.from_axis_angle((1.0, 0.0, 0.0), -math.pi / 2)
SLANTED = quat.multiply(quat.from_axis_angle((0.0, 1.0, 0.0), 0.7), quat.from_axis_angle((1.0, 0.0, 0.0), -0.9))


def surface(queue: str = "opaque", features: tuple[str, ...] = (), **params: Any) -> MaterialAsset:
    return MaterialAsset("made", queue=queue, features=list(features), params=params)


def environment(scene: MadeScene, kind: str, intensity: float = 1.0, sun: float = 0.0, **more: Any) -> None:
    scene.scene.environment = EnvironmentAsset(
        kind=kind, intensity=intensity, sun_illuminance=sun, background="color", background_color=(0.02, 0.02, 0.025),
        **more,
    )  # fmt: skip
    scene.scene.look.tone_map = "none"


def ball(scene: MadeScene) -> None:
    """One dielectric ball under the studio."""
    environment(scene, "studio")
    scene.add(uv_sphere(0.9, 24, 48), surface(base_color=(0.8, 0.35, 0.2, 1.0), metallic=0.0, roughness=0.4))
    scene.view_from = Camera(look_at((0.0, 0.6, 3.2), (0.0, 0.0, 0.0)), 0.7)


def floor(scene: MadeScene, size: float = 8.0, **params: Any) -> None:
    values = {"base_color": (0.55, 0.55, 0.55, 1.0), "metallic": 0.0, "roughness": 0.9, **params}
    scene.add(plane(size), surface(**values))


def blocks(scene: MadeScene) -> None:
    """Posts and a slab on a floor, in the sun, under an even sky: shadows with fine and coarse edges."""
    environment(scene, "uniform", 0.35, sun=3.0, color=(0.7, 0.8, 1.0), sun_elevation=0.75, sun_azimuth=0.9)
    floor(scene, 14.0)
    grey = surface(base_color=(0.7, 0.66, 0.6, 1.0), metallic=0.0, roughness=0.8)
    posts = [(x, 0.9, z) for x in (-2.0, -1.0, 0.0, 1.0, 2.0) for z in (-1.5, 0.0)]
    scene.add_many(cube(1.0), grey, posts, scale=(0.14, 1.8, 0.14))
    scene.add(cube(1.0), grey, (0.0, 1.9, -0.75), scale=(4.6, 0.12, 2.1))
    scene.add(uv_sphere(0.45, 24, 48), grey, (-0.5, 0.45, 1.0))
    scene.add(cube(1.0), grey, (1.6, 0.35, 1.3), quat.from_axis_angle((0.0, 1.0, 0.0), 0.5), 0.7)
    scene.view_from = Camera(look_at((2.6, 2.4, 5.6), (0.1, 0.55, 0.0)), 0.7)


def metals(scene: MadeScene) -> None:
    """Balls from mirror to matt, of metal and not, under the studio: what the split sum is made for."""
    environment(scene, "studio")
    for row, metal in enumerate((1.0, 0.0)):
        for column, roughness in enumerate((0.1, 0.35, 0.6, 1.0)):
            base = (0.9, 0.75, 0.5, 1.0) if metal else (0.2, 0.45, 0.8, 1.0)
            scene.add(
                uv_sphere(0.42, 32, 64), surface(base_color=base, metallic=metal, roughness=roughness),
                (column - 1.5, 0.5 - row, 0.0),
            )  # fmt: skip
    scene.view_from = Camera(look_at((0.0, 0.0, 5.4), (0.0, 0.0, 0.0)), 0.55)


def corner(scene: MadeScene, metallic: float, roughness: float) -> None:
    """A floor and two walls with a ball and a block."""
    wall = surface(base_color=(0.75, 0.72, 0.68, 1.0), metallic=0.0, roughness=0.85)
    scene.add(plane(4.0), wall)
    scene.add(plane(4.0), wall, (0.0, 2.0, -2.0), quat.from_axis_angle((1.0, 0.0, 0.0), math.pi / 2))
    red = surface(base_color=(0.7, 0.15, 0.1, 1.0), metallic=0.0, roughness=0.85)
    scene.add(plane(4.0), red, (-2.0, 2.0, 0.0), quat.from_axis_angle((0.0, 0.0, 1.0), -math.pi / 2))
    scene.add(uv_sphere(0.6, 32, 64), surface(base_color=(0.95, 0.9, 0.8, 1.0), metallic=metallic, roughness=roughness),
              (0.5, 0.6, -0.4))  # fmt: skip
    scene.add(cube(1.0), surface(base_color=(0.25, 0.5, 0.3, 1.0), metallic=0.0, roughness=0.5), (-0.9, 0.5, -0.8),
              quat.from_axis_angle((0.0, 1.0, 0.0), 0.5))  # fmt: skip
    scene.view_from = Camera(look_at((1.5, 1.9, 4.2), (-0.1, 0.9, -0.6)), 0.75)


def room(scene: MadeScene) -> None:
    """A corner with a ball and a block, by two point lights and a spot: no surroundings."""
    environment(scene, "none")
    corner(scene, 1.0, 0.35)
    scene.lamp(LightAsset("point", (1.0, 0.85, 0.6), 5.0), (1.2, 2.6, 0.6))
    scene.lamp(LightAsset("point", (0.5, 0.7, 1.0), 2.0), (-1.2, 1.8, 1.2))
    scene.lamp(LightAsset("spot", (1.0, 1.0, 1.0), 12.0, inner_angle=0.2, outer_angle=0.5), (0.5, 3.2, -0.2), DOWN)


def court(scene: MadeScene) -> None:
    """The same corner of matt things under the sky without a sun: light from above alone."""
    environment(scene, "sky", 1.0)
    corner(scene, 0.0, 0.9)


def nave(scene: MadeScene) -> None:
    """Two rows of pillars that carry a vault of beams, open to the sides: deep, and dark towards its end."""
    environment(scene, "uniform", 1.0)
    floor(scene, 24.0)
    stone = surface(base_color=(0.62, 0.58, 0.52, 1.0), metallic=0.0, roughness=0.9)
    bays = [-8.0 + 2.0 * i for i in range(6)]
    scene.add_many(cube(1.0), stone, [(x, 1.5, z) for x in (-1.6, 1.6) for z in bays], scale=(0.5, 3.0, 0.5))
    scene.add_many(cube(1.0), stone, [(x, 0.15, z) for x in (-1.6, 1.6) for z in bays], scale=(0.8, 0.3, 0.8))
    for i in range(9):
        angle = math.pi * (i + 0.5) / 9.0
        beam = quat.from_axis_angle((0.0, 0.0, 1.0), angle + math.pi / 2)
        place = (1.7 * math.cos(angle), 3.0 + 1.7 * math.sin(angle), -3.0)
        scene.add(cube(1.0), stone, place, beam, (0.62, 0.2, 12.0))
    scene.view_from = Camera(look_at((0.4, 1.6, 4.0), (0.0, 1.9, -4.0)), 0.9)


def panel(scene: MadeScene) -> None:
    """A rectangle and a disk of light over balls from glossy to matt."""
    environment(scene, "none")
    floor(scene, roughness=0.5)
    for column, roughness in enumerate((0.25, 0.5, 0.8)):
        made = surface(base_color=(0.8, 0.8, 0.82, 1.0), metallic=float(column == 1), roughness=roughness)
        scene.add(uv_sphere(0.5, 32, 64), made, (1.3 * (column - 1), 0.5, 0.0))
    scene.lamp(LightAsset("rectangle", (1.0, 0.9, 0.75), 8.0, width=1.6, height=0.5), (-0.7, 2.0, 0.3), DOWN)
    scene.lamp(LightAsset("disk", (0.6, 0.8, 1.0), 8.0, width=0.8, height=0.8), (1.5, 1.8, 0.6), DOWN)
    scene.view_from = Camera(look_at((0.0, 1.7, 4.2), (0.0, 0.5, 0.0)), 0.7)


def glass(scene: MadeScene) -> None:
    """Blended cards in front of a block: the only scene that needs sorting and blending."""
    environment(scene, "studio")
    floor(scene)
    scene.add(cube(0.8), surface(base_color=(0.8, 0.5, 0.2, 1.0), metallic=0.0, roughness=0.6), (0.0, 0.4, -0.6))
    tint = surface("transparent", ("double_sided",), base_color=(0.3, 0.6, 0.9, 0.4), metallic=0.0, roughness=0.1)
    scene.add_many(card(1.2), tint, [(-0.4, 0.6, 0.3), (0.3, 0.6, 0.6)])
    scene.view_from = Camera(look_at((0.0, 1.2, 3.0), (0.0, 0.4, 0.0)), 0.7)


def leaves(scene: MadeScene) -> None:
    """Cut-out cards in the sun: holes are found pixel by pixel, also in the shadow maps."""
    environment(scene, "uniform", 0.4, sun=2.5)
    floor(scene)
    disc = np.zeros((64, 64, 4), np.uint8)
    y, x = np.mgrid[0:64, 0:64] - 31.5
    disc[...] = (90, 150, 60, 0)
    disc[np.hypot(x, y) < 28.0, 3] = 255
    leaf = MaterialAsset(
        "leaf", queue="alpha_test", features=["double_sided"],
        params={"metallic": 0.0, "roughness": 0.7, "alpha_cutoff": 0.5},
        textures={"base_color_map": TextureRef("leaf.dds", "clamp", "clamp")},
    )  # fmt: skip
    places = np.random.default_rng(3).uniform((-1.2, 0.4, -1.0), (1.2, 1.6, 0.8), (40, 3))
    with_texture(scene, leaf, {"leaf.dds": ("rgba8-srgb", disc)}, card(0.4), places)
    scene.view_from = Camera(look_at((0.6, 1.6, 3.4), (0.0, 0.8, 0.0)), 0.7)


def textured(scene: MadeScene) -> None:
    """A ball with all the maps that the surface knows."""
    environment(scene, "studio")
    rng = np.random.default_rng(5)
    noise = rng.integers(60, 255, (32, 32, 4), np.uint8)
    noise[..., 3] = 255
    bumps = np.full((32, 32, 4), 128, np.uint8)
    bumps[..., :2] = rng.integers(100, 156, (32, 32, 2), np.uint8)
    maps = {"color.dds": ("rgba8-srgb", noise), "data.dds": ("rgba8", noise), "normal.dds": ("rgba8", bumps)}
    slots = {"base_color_map": "color.dds", "metal_rough_map": "data.dds", "normal_map": "normal.dds",
             "occlusion_map": "data.dds", "emissive_map": "color.dds"}  # fmt: skip
    material = MaterialAsset(
        "maps", params={"emissive": (0.1, 0.05, 0.0)}, textures={k: TextureRef(v) for k, v in slots.items()}
    )
    with_texture(scene, material, maps, uv_sphere(0.9, 24, 48), [(0.0, 0.0, 0.0)])
    scene.view_from = Camera(look_at((0.0, 0.6, 3.2), (0.0, 0.0, 0.0)), 0.7)


def flat(scene: MadeScene) -> None:
    """Unlit cards: no light, no normals, nothing but colours."""
    environment(scene, "none")
    for i in range(6):
        color = (0.2 + 0.13 * i, 0.9 - 0.12 * i, 0.5, 1.0)
        scene.add(card(0.6), surface(features=("unlit",), base_color=color), (0.7 * (i % 3) - 0.7, 0.7 * (i // 3), 0.0))
    scene.view_from = Camera(look_at((0.0, 0.35, 3.0), (0.0, 0.35, 0.0)), 0.7)


def crowd(scene: MadeScene) -> None:
    """Two thousand blocks: draws, not pixels."""
    environment(scene, "uniform", 0.5, sun=2.0)
    x, z = np.meshgrid(np.arange(50) * 0.4 - 10.0, np.arange(40) * 0.4 - 14.0)
    places = np.stack([x.ravel(), np.zeros(x.size), z.ravel()], axis=1)
    scene.add_many(cube(0.25), surface(base_color=(0.6, 0.5, 0.4, 1.0), metallic=0.0, roughness=0.8), places)
    scene.view_from = Camera(look_at((0.0, 3.0, 6.0), (0.0, 0.0, -2.0)), 0.8)


def nothing(scene: MadeScene) -> None:
    """An empty scene, dark."""
    environment(scene, "none")


SAMPLES: dict[str, Callable[[MadeScene], None]] = {
    "nothing": nothing, "flat": flat, "ball": ball, "textured": textured, "glass": glass, "leaves": leaves,
    "blocks": blocks, "room": room, "court": court, "nave": nave, "panel": panel, "crowd": crowd, "metals": metals,
    "box": rooms.box, "atrium": rooms.atrium, "mirrors": rooms.mirrors,
    "water": partial(floors.polished, roughness=0.0), "polish": partial(floors.polished, roughness=0.2),
    "satin": partial(floors.polished, roughness=0.35),
}  # fmt: skip


def with_texture(
    scene: MadeScene, material: MaterialAsset, maps: dict[str, tuple[str, np.ndarray]], mesh: Any, places: Any
) -> None:  # fmt: skip
    """Add a mesh whose material reads `maps`: file -> (format, square u1[n,n,4]). The files go with the scene."""
    folder = tempfile.TemporaryDirectory()
    scene.keep(folder.cleanup)
    for name, (format, texels) in maps.items():
        levels = [texels]
        while len(levels[-1]) > 1:
            half = len(levels[-1]) // 2
            mean = levels[-1].reshape(half, 2, half, 2, 4).mean(axis=(1, 3))
            levels.append(np.rint(mean).astype(np.uint8))
        size = len(texels)
        write_dds(Path(folder.name) / name, TextureAsset(format, size, size, [[level.tobytes() for level in levels]]))
    scene.add_many(mesh, material, places, folder=Path(folder.name))


def build(name: str, device: Device) -> MadeScene:
    """One of SAMPLES on the device; the caller closes it. Raises InputError for another name."""
    if name not in SAMPLES:
        raise InputError(f"there is no made scene {name!r}", hint=f"one of {', '.join(SAMPLES)}")
    scene = MadeScene(MADE + name, device)
    SAMPLES[name](scene)
    scene.scene.update()
    return scene
