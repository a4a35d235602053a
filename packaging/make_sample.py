"""Makes the sample scene: `.venv/bin/python packaging/make_sample.py [OUT.glb]`.

A brass orrery on a marble pedestal: all geometry, textures and motion come from here, nothing from elsewhere. The same
versions of NumPy and Pillow give the same bytes.

    sample_textures -> sample_materials ----------------+
    sample_shapes   -> here, sample_planets: meshes ----+-> sample_workshop: nodes -> clip "orbit" (12 s, closed)
                                                            -> project_template/assets/orrery.glb
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from sample_glb import Glb
from sample_materials import add_materials
from sample_planets import add_planets
from sample_shapes import (
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
from sample_workshop import (
    DURATION,
    FLOOR_RADIUS,
    PEDESTAL_HEIGHT,
    PEDESTAL_RADIUS,
    SUN_HEIGHT,
    Workshop,
    about,
    look_from,
)

OUT = Path(__file__).resolve().parent.parent / "project_template" / "assets" / "orrery.glb"

#: how it wants to be shown: dark behind, so that metal reads
SURROUNDINGS = {
    "environment": {
        "kind": "studio", "background": "color", "background_color": [0.050, 0.055, 0.070], "sun_illuminance": 1.2,
    },
    "look": {"tone_map": "neutral", "exposure": -0.35},
}  # fmt: skip
GEAR_MODULE = 0.0040  # m: pitch diameter / teeth


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
