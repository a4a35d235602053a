"""Makes the sample scene: `.venv/bin/python packaging/make_sample.py [OUT.glb]`.

A brass orrery on a marble pedestal: all geometry, textures and motion come from here, nothing from elsewhere. The same
versions of NumPy and Pillow give the same bytes.

    sample_textures -> materials --+
    sample_shapes   -> meshes -----+-> nodes -> clip "orbit" (12 s, closed) -> project_template/assets/orrery.glb
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import sample_textures as textures
from numpy.typing import NDArray
from sample_glb import Glb
from sample_shapes import (
    Mesh,
    annulus,
    arc,
    bezier,
    gear,
    lathe,
    merge,
    planar_uvs,
    ring,
    sphere,
    tube,
)

OUT = Path(__file__).resolve().parent.parent / "project_template" / "assets" / "orrery.glb"

DURATION = 12.0  # s, every turning part makes whole turns in it
SUN_HEIGHT = 0.36  # m above the floor; the planets circle in this plane
FLOOR_RADIUS = 0.70  # m
PEDESTAL_RADIUS = 0.19  # m
PEDESTAL_HEIGHT = 0.060  # m
#: how it wants to be shown: dark behind, so that metal reads
SURROUNDINGS = {
    "environment": {
        "kind": "studio", "background": "color", "background_color": [0.050, 0.055, 0.070], "sun_illuminance": 1.2,
    },
    "look": {"tone_map": "neutral", "exposure": -0.35},
}  # fmt: skip
GEAR_MODULE = 0.0040  # m: pitch diameter / teeth


@dataclass(frozen=True, slots=True)
class Planet:
    """`orbit`, `radius`: m. `turns`, `spins`: whole turns of the arm and of the planet in one loop. `start`: rad."""

    name: str
    material: str
    orbit: float
    radius: float
    level: float
    turns: int
    spins: int
    start: float
    tilt: float = 0.0


PLANETS = (
    Planet("mercury", "hammered iron", 0.064, 0.0085, 0.310, 4, -2, 2.94),
    Planet("venus", "terracotta", 0.094, 0.0135, 0.295, 3, 4, 4.85, 0.1),
    Planet("earth", "porcelain", 0.128, 0.0165, 0.280, 2, 6, 0.80, 0.41),
    Planet("saturn", "gold", 0.168, 0.0165, 0.265, 1, 3, 1.62, 0.35),
    Planet("jupiter", "painted", 0.2030, 0.0235, 0.250, 1, 4, 5.80, 0.05),
)


@dataclass(slots=True)
class Workshop:
    """The document being made, its materials by name, and the clip's channels."""

    glb: Glb
    materials: dict[str, int] = field(default_factory=dict)
    channels: list[tuple[int, str, NDArray[Any], NDArray[Any]]] = field(default_factory=list)

    def part(self, name: str, mesh: Mesh, material: str, parent: int, **node: Any) -> int:
        """A node with a mesh of one material."""
        return self.glb.add_node(name, parent, mesh=self.mesh(name, mesh, material), **node)

    def mesh(self, name: str, mesh: Mesh, material: str) -> int:
        return self.glb.add_mesh(name, [(mesh, self.materials[material])])

    def spin(self, node: int, axis: Sequence[float], turns: int) -> None:
        """Turn `node` about `axis` (its own frame, after its rest rotation) `turns` times in the loop.

        Keys lie a quarter turn apart, so that the shorter way is always the meant one; signs are continuous."""
        steps = 4 * abs(turns)
        angles = np.linspace(0, math.tau * turns, steps + 1) / 2
        unit = np.array(axis, np.float64) / np.linalg.norm(axis)
        turning = np.concatenate([np.sin(angles)[:, None] * unit, np.cos(angles)[:, None]], 1)
        rest = np.array(self.glb.document["nodes"][node].get("rotation", [0, 0, 0, 1]), np.float64)
        values = multiply(np.broadcast_to(rest, turning.shape), turning)
        values[-1] = values[0] if values[-1] @ values[0] > 0 else -values[0]
        self.channels.append((node, "rotation", np.linspace(0, DURATION, steps + 1), values))


def multiply(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Hamilton product of quaternions xyzw: first b, then a."""
    av, aw, bv, bw = a[:, :3], a[:, 3:], b[:, :3], b[:, 3:]
    return np.concatenate([aw * bv + bw * av + np.cross(av, bv), aw * bw - np.sum(av * bv, 1, keepdims=True)], 1)


def about(axis: str, angle: float) -> list[float]:
    """Quaternion xyzw of a turn about x, y or z."""
    value = [0.0, 0.0, 0.0, math.cos(angle / 2)]
    value["xyz".index(axis)] = math.sin(angle / 2)
    return value


def look_from(eye: Sequence[float], target: Sequence[float]) -> list[float]:
    """Quaternion xyzw that turns -Z towards `target` with +Y up."""
    back = np.array(eye, np.float64) - np.array(target, np.float64)
    yaw = math.atan2(back[0], back[2])
    pitch = -math.atan2(back[1], math.hypot(back[0], back[2]))
    return [float(v) for v in multiply(np.array([about("y", yaw)]), np.array([about("x", pitch)]))[0]]


# --- materials -----------------------------------------------------------------------------------------------------


def add_materials(shop: Workshop) -> None:
    png, jpeg, glb = textures.png, textures.jpeg, shop.glb

    def add(name: str, color: str, rough: float, metal: float, alpha: float = 1.0, **more: Any) -> None:
        """`color` is sRGB as painters give it; factors in the file are linear."""
        pbr: dict[str, Any] = {"metallicFactor": metal, "roughnessFactor": rough}
        srgb = textures.rgb(color)
        linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
        if alpha < 1 or np.any(linear < 1):
            pbr["baseColorFactor"] = [*(round(float(v), 5) for v in linear), alpha]
        for slot in ("baseColorTexture", "metallicRoughnessTexture"):
            if slot in more:
                pbr[slot] = more.pop(slot)
        shop.materials[name] = glb.add_material(name, pbrMetallicRoughness=pbr, **more)

    def use(name: str, data: bytes, **options: Any) -> dict[str, Any]:
        return {"index": glb.add_texture(name, data), **options}

    brushed_normal, brushed_rough = textures.brushed()
    hammered_normal, hammered_rough = textures.hammered()
    walnut_color, walnut_rough = textures.walnut()
    floor_color, floor_normal, floor_rough = textures.stone_floor()
    clay_color, clay_normal, clay_rough = textures.clay(256)
    scale_color, scale_normal, scale_rough = textures.engraved_scale()
    occlusion = textures.floor_occlusion(256, FLOOR_RADIUS, PEDESTAL_RADIUS, PEDESTAL_HEIGHT)

    add("polished brass", "#f0c674", 0.14, 1.0)
    add("brushed brass", "#eebf69", 1.0, 1.0,
        normalTexture=use("brushed normal", png(brushed_normal)),
        metallicRoughnessTexture=use("brushed roughness", png(brushed_rough)))  # fmt: skip
    add("engraved brass", "#ffffff", 1.0, 1.0,
        baseColorTexture=use("scale", png(scale_color)),
        normalTexture=use("scale normal", png(scale_normal)),
        metallicRoughnessTexture=use("scale roughness", png(scale_rough)))  # fmt: skip
    add("gold", "#ffdc9d", 0.10, 1.0)
    add("dark steel", "#5d6067", 0.32, 1.0)
    add("hammered iron", "#6b645e", 1.0, 1.0,
        normalTexture=use("hammered normal", png(hammered_normal)),
        metallicRoughnessTexture=use("hammered roughness", jpeg(hammered_rough)))  # fmt: skip
    add("marble", "#ffffff", 0.13, 0.0, baseColorTexture=use("marble", jpeg(textures.marble(), 88)))
    add("black marble", "#17181b", 0.11, 0.0)
    add("walnut", "#ffffff", 1.0, 1.0,
        baseColorTexture=use("walnut", jpeg(walnut_color, 88)),
        metallicRoughnessTexture=use("walnut roughness", jpeg(walnut_rough, 85)))  # fmt: skip
    add("stone floor", "#ffffff", 1.0, 1.0,
        baseColorTexture=use("floor", jpeg(floor_color, 88)),
        normalTexture=use("floor normal", png(floor_normal)),
        metallicRoughnessTexture=use("floor roughness", jpeg(floor_rough, 85)),
        occlusionTexture=use("floor occlusion", png(occlusion), texCoord=1))  # fmt: skip
    add("terracotta", "#ffffff", 1.0, 1.0,
        baseColorTexture=use("terracotta", jpeg(clay_color, 88)),
        normalTexture=use("terracotta normal", png(clay_normal)),
        metallicRoughnessTexture=use("terracotta roughness", jpeg(clay_rough, 85)))  # fmt: skip
    add("porcelain", "#ffffff", 0.06, 0.0, baseColorTexture=use("porcelain", jpeg(textures.porcelain(768), 88)))
    add("painted", "#ffffff", 0.36, 0.0)
    add("pearl", "#e9e2d6", 0.28, 0.0)
    add("sun", "#000000", 1.0, 0.0,
        emissiveFactor=[1.0, 1.0, 1.0],
        emissiveTexture=use("sun", jpeg(textures.sun_surface(), 88)),
        extensions={"KHR_materials_emissive_strength": {"emissiveStrength": 3.0}})  # fmt: skip
    add("glass", "#20262c", 0.03, 0.0, alpha=0.16, alphaMode="BLEND")
    add("filigree", "#ffffff", 0.22, 1.0, alphaMode="MASK", alphaCutoff=0.5, doubleSided=True,
        baseColorTexture=use("filigree", png(textures.filigree())))  # fmt: skip
    add("planet ring", "#ffffff", 0.16, 1.0, alphaMode="MASK", alphaCutoff=0.5, doubleSided=True,
        baseColorTexture=use("planet ring", png(textures.planet_ring())))  # fmt: skip


# --- what stands ---------------------------------------------------------------------------------------------------


def add_floor(shop: Workshop, root: int) -> None:
    inlay, stone = FLOOR_RADIUS * 0.86, FLOOR_RADIUS * 0.85
    top = annulus(0.0, stone, 64)
    top = merge([top]).with_uvs(planar_uvs(1 / 0.40))
    top.uvs1 = np.stack([top.positions[:, 0], top.positions[:, 2]], 1) / (2 * FLOOR_RADIUS) + 0.5
    brass = lathe(
        [(inlay, -0.002), (inlay, 0.0006), (stone, 0.0006), (stone, -0.002)],
        96,
        0.0004,
        steps=2,
        u_repeat=16,
        v_per_metre=12,
    )
    edge = lathe(
        [(0.0, -0.032), (FLOOR_RADIUS - 0.012, -0.032), *arc((FLOOR_RADIUS - 0.012, -0.020), 0.012, -90, 0, 4),
         *arc((FLOOR_RADIUS - 0.008, -0.008), 0.008, 0, 90, 4), (inlay, 0.0)],
        80, 0.002, steps=2,
    )  # fmt: skip
    floor = shop.glb.add_mesh(
        "floor",
        [
            (top, shop.materials["stone floor"]),
            (brass, shop.materials["brushed brass"]),
            (edge, shop.materials["black marble"]),
        ],
    )
    shop.glb.add_node("floor", root, mesh=floor)


def add_pedestal(shop: Workshop, root: int) -> int:
    """Marble drum with mouldings, a brass filigree gallery, and a walnut plate. Returns the pedestal's node."""
    group = shop.glb.add_node("pedestal", root)
    r, h = PEDESTAL_RADIUS, PEDESTAL_HEIGHT
    drum = [
        (0.0, 0.0), (r, 0.0), (r, 0.011),
        *arc((r - 0.007, 0.018), 0.007, -90, 90, 7),  # torus
        (r - 0.014, 0.025),
        *arc((r - 0.012, 0.036), 0.010, 250, 180, 5),  # scotia
        (r - 0.022, 0.042), (r - 0.022, 0.046),
        *arc((r - 0.020, 0.052), 0.0065, -70, 90, 6),
        (r - 0.020, h), (0.0, h),
    ]  # fmt: skip
    shop.part("marble drum", lathe(drum, 72, 0.0012, steps=2, u_repeat=2, v_per_metre=1.7), "marble", group)
    base_y, wood_r = h, 0.146
    wood = [
        (0.0, base_y), (wood_r, base_y), (wood_r, base_y + 0.005),
        *arc((wood_r - 0.001, base_y + 0.012), 0.006, -90, 90, 6),
        (wood_r - 0.008, base_y + 0.0185), (wood_r - 0.012, base_y + 0.026), (0.0, base_y + 0.026),
    ]  # fmt: skip
    shop.part("walnut plate", lathe(wood, 64, 0.0015, steps=2).with_uvs(planar_uvs(1 / 0.28, 0.7)), "walnut", group)
    top = base_y + 0.026
    gallery_r, gallery_h = 0.118, 0.026
    band = lathe([(gallery_r, 0.0), (gallery_r, gallery_h)], 96, 0.0, u_repeat=12, v_per_metre=1 / gallery_h)
    shop.part("filigree gallery", band, "filigree", group, translation=[0, top + 0.001, 0])
    rails = [ring(gallery_r, 0.0042, 0.0036, 72, 0.0012, steps=2).moved(y=y) for y in (0.0015, gallery_h + 0.001)]
    shop.part("gallery rails", merge(rails), "polished brass", group, translation=[0, top, 0])
    return group


def add_column(shop: Workshop, root: int) -> None:
    y0 = PEDESTAL_HEIGHT + 0.026
    profile = [
        (0.0, y0), (0.052, y0), (0.052, y0 + 0.004),
        *arc((0.0495, y0 + 0.0075), 0.0035, -90, 90, 5),
        (0.046, y0 + 0.011),
        *arc((0.046, y0 + 0.031), 0.020, 270, 190, 8),
        (0.0235, y0 + 0.0290), *arc((0.0235, y0 + 0.0325), 0.0035, -90, 90, 5), (0.019, y0 + 0.036),
        (0.0150, y0 + 0.042), (0.0115, y0 + 0.052), (0.0098, y0 + 0.066), (0.0100, y0 + 0.082),
        (0.0125, y0 + 0.098), (0.0150, y0 + 0.108),
        *arc((0.0150, y0 + 0.1115), 0.0035, -90, 90, 5),
        (0.0120, y0 + 0.116), (0.0085, y0 + 0.122), (0.0075, 0.232), (0.0075, 0.316),
        (0.0100, 0.318), (0.0100, 0.3205), (0.0050, 0.323), (0.0034, 0.330), (0.0034, SUN_HEIGHT - 0.018),
        (0.0, SUN_HEIGHT - 0.018),
    ]  # fmt: skip
    column = lathe(profile, 28, 0.0008, steps=2, u_repeat=2, v_per_metre=12)
    shop.part("column", column, "brushed brass", root)


def add_frame(shop: Workshop, root: int) -> None:
    """The horizon ring on four forged legs, and the meridian ring that stands in it."""
    frame = shop.glb.add_node("frame", root)
    horizon_r, width = 0.272, 0.036
    band = annulus(horizon_r - width / 2 + 0.001, horizon_r + width / 2 - 0.001, 160, u_repeat=4)
    body = lathe(
        [(horizon_r - width / 2 + 0.001, 0.0), (horizon_r - width / 2, -0.0012), (horizon_r - width / 2, -0.0055),
         (horizon_r - width / 2 + 0.002, -0.0075), (horizon_r + width / 2 - 0.002, -0.0075),
         (horizon_r + width / 2, -0.0055), (horizon_r + width / 2, -0.0012), (horizon_r + width / 2 - 0.001, 0.0)],
        96, 0.0008, steps=2, u_repeat=12, v_per_metre=12,
    )  # fmt: skip
    mesh = shop.glb.add_mesh(
        "horizon ring",
        [(band, shop.materials["engraved brass"]), (body, shop.materials["brushed brass"])],
    )
    shop.glb.add_node("horizon ring", frame, mesh=mesh, translation=[0, SUN_HEIGHT, 0])

    meridian = ring(0.2475, 0.0056, 0.0105, 112, 0.0027, steps=4, u_repeat=12, v_per_metre=12)
    upright = shop.part(
        "meridian ring", meridian, "brushed brass", frame,
        translation=[0, SUN_HEIGHT, 0], rotation=about("z", math.pi / 2),
    )  # fmt: skip
    # a slender ecliptic, tilted as the Earth's axis is
    ecliptic = ring(0.2395, 0.0036, 0.0046, 96, 0.0017, steps=3)
    band_node = shop.part("ecliptic ring", ecliptic, "polished brass", upright, rotation=about("x", math.radians(66.6)))
    bead = shop.mesh("bead", sphere(0.0042, 14, 8), "gold")
    for i in range(12):
        angle = i * math.tau / 12
        at = [0.2395 * math.sin(angle), 0.0, 0.2395 * math.cos(angle)]
        shop.glb.add_node(f"bead {i + 1}", band_node, mesh=bead, translation=at)

    leg_path = bezier(
        [(0, 0.062, 0.150), (0, 0.075, 0.335), (0, 0.200, 0.120), (0, 0.330, 0.255), (0, 0.3535, 0.274)], 26
    )
    thick = np.interp(np.linspace(0, 1, 27), [0, 0.15, 0.5, 0.85, 1], [0.0062, 0.0050, 0.0040, 0.0040, 0.0046])
    leg = tube(leg_path, thick, 10)
    foot = lathe(
        [(0.0, 0.060), (0.0125, 0.060), (0.0125, 0.063), (0.0095, 0.0665), (0.0060, 0.068), (0.0, 0.068)], 20, 0.0008
    ).moved(z=0.150)
    legs = shop.mesh("leg", merge([leg, foot]), "hammered iron")
    knob = shop.mesh("knob", sphere(0.0065, 20, 12), "polished brass")
    for i in range(4):
        angle = math.pi / 4 + i * math.pi / 2
        node = shop.glb.add_node(f"leg {i + 1}", frame, mesh=legs, rotation=about("y", angle))
        shop.glb.add_node(f"knob {i + 1}", node, mesh=knob, translation=[0, SUN_HEIGHT + 0.003, 0.272])
    finial = lathe(
        [(0.0, 0.0), (0.0085, 0.0), (0.0085, 0.003), (0.0050, 0.0055), (0.0036, 0.009),
         *arc((0.0, 0.0165), 0.0078, -60, 60, 8), (0.0024, 0.0255), (0.0016, 0.030), (0.0, 0.0345)],
        28, 0.0006,
    )  # fmt: skip
    shop.part("finial", finial, "gold", frame, translation=[0, SUN_HEIGHT + 0.2495, 0])


# --- what turns ----------------------------------------------------------------------------------------------------


def add_gears(shop: Workshop, root: int) -> None:
    """A wheel on the column drives two pinions with a third of its teeth, so they turn three times as often."""
    train = shop.glb.add_node("gear train", root, translation=[0, 0.2155, 0])
    wheel = shop.part("wheel", gear(36, GEAR_MODULE, 0.0070, 0.0088, 6), "brushed brass", train)
    shop.spin(wheel, (0, 1, 0), 1)
    pinion = shop.mesh("pinion", gear(12, GEAR_MODULE, 0.0090, 0.0036, 0), "dark steel")
    distance = (36 + 12) * GEAR_MODULE / 2
    post_height = 0.2155 - 0.086
    post = lathe(
        [(0.0, -post_height), (0.0125, -post_height), (0.0125, -post_height + 0.003), (0.0070, -post_height + 0.007),
         (0.0045, -post_height + 0.016), (0.0035, -post_height + 0.040), (0.0035, -0.012), (0.0055, -0.010),
         (0.0055, -0.006), (0.0032, -0.005), (0.0032, 0.0085), *arc((0.0, 0.0100), 0.0042, -30, 90, 6)],
        24, 0.0006,
    )  # fmt: skip
    posts = shop.mesh("post", post, "polished brass")
    for i, angle in enumerate((math.radians(35), math.radians(215))):
        at = [distance * math.sin(angle), 0.0, distance * math.cos(angle)]
        shop.glb.add_node(f"post {i + 1}", train, mesh=posts, translation=at)
        # a tooth of the wheel points at angle 0 and every 10 degrees; the pinion must show it a gap
        wheel_phase = angle % (math.tau / 36)
        facing = angle + math.pi + 3 * wheel_phase + math.pi / 12
        node = shop.glb.add_node(f"pinion {i + 1}", train, mesh=pinion, translation=at, rotation=about("y", facing))
        shop.spin(node, (0, 1, 0), -3)
    # the collar rises and sinks on the column, once up and down in a loop
    collar = lathe(
        [(0.0128, -0.005), (0.0170, -0.005), (0.0170, -0.003), *arc((0.0172, 0.0), 0.003, -90, 90, 6),
         (0.0170, 0.003), (0.0170, 0.005), (0.0128, 0.005)],
        36, 0.0008, closed=True, steps=2,
    )  # fmt: skip
    rest = [0.0, 0.160, 0.0]
    node = shop.part("collar", collar, "gold", root, translation=rest)
    times = np.linspace(0, DURATION, 25)
    travel = 0.009 * np.sin(times / DURATION * math.tau)
    travel[-1] = travel[0]
    values = np.array(rest) + np.stack([np.zeros(25), travel, np.zeros(25)], 1)
    shop.channels.append((node, "translation", times, values))


def add_sun(shop: Workshop, root: int) -> None:
    sun = shop.glb.add_node("sun", root, translation=[0, SUN_HEIGHT, 0])
    core = shop.part("lantern", sphere(0.0195, 40, 20), "sun", sun)
    shop.spin(core, (0, 1, 0), 1)
    light = shop.glb.add_light(name="lantern light", type="point", color=[1.0, 0.72, 0.42], intensity=0.22, range=2.0)
    shop.glb.add_node("lantern light", sun, extensions=light)
    shop.part("glass globe", sphere(0.0335, 40, 20), "glass", sun)
    outer = ring(0.0430, 0.0022, 0.0048, 72, 0.0007, steps=2)
    gimbal = shop.part("gimbal outer", outer, "gold", sun, rotation=about("z", 1.05))
    shop.spin(gimbal, (1, 0, 0), 1)
    inner = ring(0.0385, 0.0020, 0.0042, 64, 0.0006, steps=2)
    second = shop.part("gimbal inner", inner, "polished brass", gimbal, rotation=about("x", 1.2))
    shop.spin(second, (0, 0, 1), -2)


def sleeve() -> Mesh:
    """What an arm turns on: a flanged tube around the column, centred at its arm's level."""
    bore, outer = 0.0078, 0.0162
    profile = [
        (bore, -0.0068), (outer, -0.0068), (outer, -0.0045), (outer - 0.003, -0.0035), (outer - 0.003, 0.0035),
        (outer, 0.0045), (outer, 0.0068), (bore, 0.0068),
    ]  # fmt: skip
    return lathe(profile, 32, 0.0006, closed=True, steps=2, v_per_metre=12)


def cup() -> Mesh:
    """What a planet rests in, below the origin."""
    profile = [(0.0, -0.0040), (0.0022, -0.0040), (0.0030, -0.0012), (0.0052, 0.0012), (0.0046, 0.0016), (0.0, 0.0006)]
    return lathe(profile, 20, 0.0005, steps=2)


def arm(planet: Planet) -> Mesh:
    """A bar from the sleeve outwards that bends up under the planet, and a counterweight on the other side."""
    rise = SUN_HEIGHT - planet.radius - planet.level
    bend = min(0.035, rise * 0.8, planet.orbit * 0.5)
    top = SUN_HEIGHT - planet.radius + 0.001
    path = np.concatenate(
        [
            [(0, planet.level, d) for d in np.linspace(0.010, planet.orbit - bend, 6)[:-1]],
            bezier(
                [(0, planet.level, planet.orbit - bend), (0, planet.level, planet.orbit - bend * 0.35),
                 (0, planet.level + bend * 0.65, planet.orbit), (0, planet.level + bend, planet.orbit)], 8,
            ),
            [(0, y, planet.orbit) for y in np.linspace(planet.level + bend, top, 4)[1:]],
        ]
    )  # fmt: skip
    radii = np.interp(np.linspace(0, 1, len(path)), [0, 0.3, 0.8, 1], [0.0030, 0.0024, 0.0019, 0.0014])
    weight_path = [(0, planet.level, -d) for d in np.linspace(0.010, 0.030 + 0.06 * planet.orbit, 5)]
    weight = sphere(0.0040 + 0.010 * planet.orbit, 20, 12).moved(0, planet.level, -0.032 - 0.06 * planet.orbit)
    return merge([tube(path, radii, 8), tube(weight_path, 0.0020, 8), weight])


def banded(mesh: Mesh) -> Mesh:
    """Vertex colours of a gas giant: bands that a turbulent flow shears, and one oval storm."""
    n = mesh.normals
    flow = textures.fbm3(n * [2.2, 5.0, 2.2], 181, 4)
    band = np.sin((n[:, 1] * 1.9 + flow * 0.10) * 7.5)
    fine = np.sin((n[:, 1] * 1.9 + flow * 0.16) * 23.0)
    rgb, mix = textures.rgb, textures.mix
    color = mix(rgb("#f3e3c3"), rgb("#b5764a"), 0.5 + 0.42 * band + 0.16 * fine)
    color = mix(color, rgb("#7d4a35"), 0.8 * textures.smoothstep(0.70, 1.0, np.sin(n[:, 1] * 9.0 + flow + 0.7)))
    color = mix(color, rgb("#9fb0b4"), 0.75 * textures.smoothstep(0.72, 0.98, np.abs(n[:, 1])))
    storm = np.array([0.25, -0.36, 0.90])
    away = (n - storm / np.linalg.norm(storm)) * [1.0, 1.9, 1.0]
    color = mix(color, rgb("#c4502f"), 1 - textures.smoothstep(0.14, 0.26, np.linalg.norm(away, axis=1)))
    linear = ((color + 0.055) / 1.055) ** 2.4  # COLOR_0 is linear
    mesh.colors = np.concatenate([linear, np.ones((len(linear), 1))], 1)
    return mesh


def add_planets(shop: Workshop, root: int) -> None:
    system = shop.glb.add_node("planets", root)
    arm_color = {"mercury": "dark steel", "venus": "polished brass", "earth": "polished brass",
                 "saturn": "gold", "jupiter": "polished brass"}  # fmt: skip
    sleeves = shop.mesh("sleeve", sleeve(), "brushed brass")
    cups = shop.mesh("cup", cup(), "polished brass")
    for planet in PLANETS:
        turning = shop.glb.add_node(f"{planet.name} arm", system, rotation=about("y", planet.start))
        shop.spin(turning, (0, 1, 0), planet.turns)
        shop.part(f"{planet.name} bar", arm(planet), arm_color[planet.name], turning)
        shop.glb.add_node(f"{planet.name} sleeve", turning, mesh=sleeves, translation=[0, planet.level, 0])
        at = [0, SUN_HEIGHT - planet.radius, planet.orbit]
        shop.glb.add_node(f"{planet.name} cup", turning, mesh=cups, translation=at)
        seat = shop.glb.add_node(
            f"{planet.name} axis", turning, translation=[0, SUN_HEIGHT, planet.orbit], rotation=about("z", planet.tilt)
        )
        detail = (56, 28) if planet.name == "jupiter" else (36, 18)
        ball = sphere(planet.radius, *detail)
        if planet.name == "jupiter":
            ball = banded(ball)
        node = shop.part(planet.name, ball, planet.material, seat)
        shop.spin(node, (0, 1, 0), planet.spins)
        if planet.name == "saturn":
            disc = annulus(planet.radius * 1.28, planet.radius * 2.05, 72, u_repeat=2)
            shop.part("saturn ring", disc, "planet ring", seat)
        if planet.name == "earth":
            add_moon(shop, turning, planet)


def add_moon(shop: Workshop, parent: int, earth: Planet) -> None:
    """The moon's own small arm turns under the Earth, with its pinion."""
    reach, level = 0.0285, earth.radius + 0.012
    pivot = shop.glb.add_node("moon arm", parent, translation=[0, SUN_HEIGHT - level, earth.orbit])
    shop.spin(pivot, (0, 1, 0), 5)
    path = bezier([(0, 0, 0.002), (0, 0, reach), (0, 0.002, reach), (0, level - 0.004, reach)], 12)
    disc = gear(12, 0.0010, 0.0026, 0.0016, 0)
    shop.part("moon pinion", disc, "polished brass", pivot)
    shop.part("moon bar", tube(path, 0.0010, 8), "gold", pivot)
    shop.part("moon", sphere(0.0052, 24, 12), "pearl", pivot, translation=[0, level, reach])


def add_views(shop: Workshop) -> None:
    """Cameras: the whole instrument, and a close look into the planets."""
    views = {
        "main": ((0.50, 0.53, 1.10), (0.0, 0.311, 0.0), 32.2),
        "close": ((0.17, 0.465, 0.385), (0.012, 0.333, 0.015), 33.0),
    }
    for name, (eye, target, yfov) in views.items():
        camera = shop.glb._append(
            "cameras",
            {"name": name, "type": "perspective",
             "perspective": {"yfov": math.radians(yfov), "aspectRatio": 16 / 9, "znear": 0.02}},
        )  # fmt: skip
        shop.glb.add_node(name, camera=camera, translation=list(eye), rotation=look_from(eye, target))


def make() -> bytes:
    """The whole sample as the bytes of a .glb."""
    shop = Workshop(Glb("Lucarna packaging/make_sample.py", "The Lucarna authors, MIT"))
    add_materials(shop)
    root = shop.glb.add_node("orrery")
    for build in (add_floor, add_pedestal, add_column, add_frame, add_gears, add_sun, add_planets):
        build(shop, root)
    add_views(shop)
    shop.glb.add_animation("orbit", shop.channels)
    return shop.glb.to_bytes(scene_name="orrery", extras={"lucarna": SURROUNDINGS})


def main(arguments: Sequence[str]) -> int:
    out = Path(arguments[0]) if arguments else OUT
    data = make()
    out.parent.mkdir(parents=True, exist_ok=True)
    temporary = out.with_name(f".{out.name}.tmp")
    temporary.write_bytes(data)
    temporary.replace(out)
    print(f"{out}: {len(data) / 1e6:.2f} MB")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
