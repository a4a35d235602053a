"""The planets of the sample, each on an arm of its own, and the moon."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import sample_textures as textures
from sample_shapes import Mesh, annulus, bezier, gear, lathe, merge, sphere, tube
from sample_workshop import SUN_HEIGHT, Workshop, about


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
