"""The atrium: a court with two storeys of columns and arches around it, and lights that move through all of it.

In the spirit of the many-light demonstration of the engine's thesis (figure 5.2: a thousand point lights; its sources
have 480 over the floors, 120 along the edges of two storeys, 400 on ten ellipses): 480 point lights drift over the
floors, 144 spot lights swing under the ceilings, 400 point lights circle on ten ellipses; other counts keep the
proportions.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.assets.clip import ClipAsset
from engine.assets.mesh import MeshAsset
from engine.assets.primitives import uv_sphere
from engine.assets.samples.sample import DEFAULT_LIGHTS, SampleScene
from engine.assets.samples.shapes import Patches, arch, box, column
from engine.assets.samples.swarm import Swarm, add_swarm, hues, phases, swinging
from engine.assets.scene import CameraAsset, EnvironmentAsset, LightAsset, LookAsset, NodeAsset, SceneAsset

F8 = NDArray[np.float64]

# m: half sizes of the court and of the house, and the heights of both storeys' columns, arches and floors
COURT_X, COURT_Z, HOUSE_X, HOUSE_Z = 12.0, 4.0, 16.5, 8.5
COLUMN, ARCH, SLAB = (3.0, 2.4), (1.6, 1.4), 0.4
UPPER = COLUMN[0] + ARCH[0] + SLAB
ROOF = UPPER + COLUMN[1] + ARCH[1]
BAYS_X, BAYS_Z = 8, 3
TURNED = (0.0, 0.5**0.5, 0.0, 0.5**0.5)
#: of the thesis's lights
_EDGE, _ELLIPSE, _ALL = 144, 400, 1024


def build(lights: int = DEFAULT_LIGHTS, seed: int = 1, reach: float = 1.0) -> SampleScene:
    """Return the atrium with that many lights; `reach` scales how far each shines."""
    look = LookAsset(exposure=0.6, tone_map="neutral")
    surroundings = EnvironmentAsset(
        "uniform", color=(0.020, 0.030, 0.060), background="environment", sun_illuminance=0.0, background_blur=0.0
    )
    sample = SampleScene(SceneAsset("atrium", environment=surroundings, look=look))
    _house(sample)
    _arcades(sample)
    _middle(sample)
    _camera(sample.scene)
    _lights(sample, lights, np.random.default_rng(seed), reach)
    return sample


def _house(sample: SampleScene) -> None:
    floor = sample.material("floor", base_color=(0.32, 0.29, 0.25, 1.0), roughness=0.45)
    pale = sample.material("marble", base_color=(0.66, 0.63, 0.57, 1.0), roughness=0.22)
    dark = sample.material("slate", base_color=(0.10, 0.10, 0.11, 1.0), roughness=0.28)
    plaster = sample.material("plaster", base_color=(0.62, 0.56, 0.47, 1.0), roughness=0.9)
    slabs = sample.material("slabs", base_color=(0.50, 0.45, 0.38, 1.0), roughness=0.8)
    for name, odd, material in (("pale tiles", 0, pale), ("dark tiles", 1, dark)):
        tiles = Patches()
        for i in range(24):
            for j in range(8):
                if (i + j) % 2 == odd:
                    x, z = i - COURT_X, j - COURT_Z
                    tiles.quad([(x, 0, z), (x + 1, 0, z), (x, 0, z + 1), (x + 1, 0, z + 1)])
        sample.place(name, sample.mesh(tiles.mesh(name)), material)
    sample.place("floor", sample.mesh(_ring(-0.3, 0.0)), floor)
    sample.place("upper floor", sample.mesh(_ring(UPPER - SLAB, UPPER)), slabs)
    sample.place("roof", sample.mesh(_ring(ROOF, ROOF + SLAB)), slabs)
    walls = Patches()
    for x in (-HOUSE_X - 0.3, HOUSE_X):
        walls.box((x, -0.3, -HOUSE_Z - 0.3), (x + 0.3, ROOF + SLAB, HOUSE_Z + 0.3))
    for z in (-HOUSE_Z - 0.3, HOUSE_Z):
        walls.box((-HOUSE_X, -0.3, z), (HOUSE_X, ROOF + SLAB, z + 0.3))
    sample.place("walls", sample.mesh(walls.mesh("walls")), plaster)


def _ring(low: float, high: float) -> MeshAsset:
    """A slab over the galleries, open above the court."""
    slab = Patches()
    for side in (-1.0, 1.0):
        z = sorted((side * COURT_Z, side * HOUSE_Z))
        x = sorted((side * COURT_X, side * HOUSE_X))
        slab.box((-HOUSE_X, low, z[0]), (HOUSE_X, high, z[1]))
        slab.box((x[0], low, -COURT_Z), (x[1], high, COURT_Z))
    return slab.mesh("slab")


def _arcades(sample: SampleScene) -> None:
    stone = sample.material("sandstone", base_color=(0.60, 0.51, 0.39, 1.0), roughness=0.75)
    for storey, base in enumerate((0.0, UPPER)):
        high, radius = COLUMN[storey], 0.26 - 0.06 * storey
        pillar = sample.mesh(column(f"column {storey}", radius, high))
        for k, (x, z) in enumerate(_feet()):
            sample.place(f"column {storey}.{k}", pillar, stone, (x, base, z))
        for along, bays, half, other, turn in (
            ("x", BAYS_X, COURT_X, COURT_Z, (0.0, 0.0, 0.0, 1.0)),
            ("z", BAYS_Z, COURT_Z, COURT_X, TURNED),
        ):
            span = 2.0 * half / bays
            mesh = sample.mesh(arch(f"arch {storey}{along}", span, 0.78 * ARCH[storey], ARCH[storey], 0.42))
            wall = sample.mesh(box(f"parapet {along}", (-span / 2 + 0.2, 0.0, -0.08), (span / 2 - 0.2, 0.85, 0.08)))
            for side in (-1.0, 1.0):
                for bay in range(bays):
                    middle = -half + (bay + 0.5) * span
                    x, z = (middle, side * other) if along == "x" else (side * other, middle)
                    sample.place(f"arch {storey}{along}{bay}{side:+.0f}", mesh, stone, (x, base + high, z), turn)
                    if storey:
                        sample.place(f"parapet {along}{bay}{side:+.0f}", wall, stone, (x, base, z), turn)


def _feet() -> list[tuple[float, float]]:
    """Where the columns stand, each once."""
    xs = np.linspace(-COURT_X, COURT_X, BAYS_X + 1).tolist()
    zs = np.linspace(-COURT_Z, COURT_Z, BAYS_Z + 1).tolist()
    sides = [(x, z) for z in (-COURT_Z, COURT_Z) for x in xs]
    return sides + [(x, z) for x in (-COURT_X, COURT_X) for z in zs[1:-1]]


def _middle(sample: SampleScene) -> None:
    """Spheres on plinths along the court, and cloths hung between the upper columns."""
    stone = sample.material("granite", base_color=(0.22, 0.21, 0.22, 1.0), roughness=0.5)
    plinth = sample.mesh(box("plinth", (-0.5, 0.0, -0.5), (0.5, 0.9, 0.5)))
    sphere = sample.mesh(uv_sphere(0.6, 24, 48))
    finishes: dict[str, dict[str, object]] = {
        "gold": {"base_color": (1.0, 0.71, 0.29, 1.0), "metallic": 1.0, "roughness": 0.25},
        "lacquer": {"base_color": (0.42, 0.03, 0.03, 1.0), "roughness": 0.12},
        "chrome": {"base_color": (0.86, 0.87, 0.88, 1.0), "metallic": 1.0, "roughness": 0.08},
        "chalk": {"base_color": (0.80, 0.80, 0.78, 1.0), "roughness": 1.0},
    }
    for x, (name, values) in zip((-7.5, -2.5, 2.5, 7.5), finishes.items(), strict=True):
        sample.place(f"plinth {name}", plinth, stone, (x, 0.0, 0.0))
        sample.place(name, sphere, sample.material(name, **values), (x, 1.5, 0.0))
    cloth = sample.mesh(_cloth(1.5, 2.6))
    dyes = {"madder": (0.45, 0.06, 0.05), "woad": (0.05, 0.10, 0.38), "weld": (0.55, 0.42, 0.07)}
    keys = []
    for name, color in dyes.items():
        keys.append(sample.material(name, base_color=(*color, 1.0), roughness=0.95))
        sample.materials[keys[-1]].features = ["double_sided"]
    for k, x in enumerate(np.linspace(-COURT_X + 1.5, COURT_X - 1.5, BAYS_X)[1:-1:2].tolist()):
        for side in (-1.0, 1.0):
            hung = (x, COLUMN[0] + 1.2, side * (COURT_Z - 0.45))
            sample.place(f"cloth {k}{side:+.0f}", cloth, keys[(k + int(side)) % 3], hung)


def _cloth(width: float, height: float) -> MeshAsset:
    """A hanging cloth, its folds deeper towards the hem; hung from y = 0."""
    x, down = np.meshgrid(np.linspace(-0.5, 0.5, 41) * width, np.linspace(0.0, 1.0, 13))
    z = 0.16 * (0.25 + 0.75 * down) * np.sin(x / width * 9.0 * np.pi)
    cloth = Patches()
    cloth.grid(np.stack([x, height * (0.5 - down), z], axis=-1))
    return cloth.mesh("cloth")


def _camera(scene: SceneAsset) -> None:
    # at the court's west end, looking along it and slightly up
    pitch, yaw = 0.08, -np.pi / 2 - 0.10
    x, w = float(np.sin(pitch / 2)), float(np.cos(pitch / 2))
    s, c = float(np.sin(yaw / 2)), float(np.cos(yaw / 2))
    node = NodeAsset("camera", -1, (-11.2, 2.4, -1.5), (c * x, s * w, -s * x, c * w))
    node.camera = CameraAsset(yfov=1.1, znear=0.05)
    scene.active_camera = len(scene.nodes)
    scene.nodes.append(node)


def _lights(sample: SampleScene, lights: int, rng: np.random.Generator, reach: float) -> None:
    scene = sample.scene
    clip = ClipAsset("drift", frame_rate=0.0)
    parent = len(scene.nodes)
    scene.nodes.append(NodeAsset("lights"))
    edge = round(lights * _EDGE / _ALL)
    ellipse = round(lights * _ELLIPSE / _ALL)
    share = _ALL / max(lights, 1)  # as bright together, however many
    for swarm in (
        _floor_swarm(lights - edge - ellipse, rng, reach, share),
        _edge_swarm(edge, rng, reach, share),
        _ellipse_swarm(ellipse, rng, reach, share),
    ):
        add_swarm(scene, clip, swarm, parent)
    if clip.channels:
        sample.clips.append(clip)
        scene.clips.append("atrium.drift.lanim")


def _floor_swarm(count: int, rng: np.random.Generator, reach: float, share: float) -> Swarm:
    """A grid over the ground floor, drifting in small circles."""
    columns = max(1, round((count * HOUSE_X / HOUSE_Z) ** 0.5))
    k = np.arange(count)
    rows = max(1, -(-count // columns))
    x = ((k % columns) + 0.5) / columns * 2.0 * HOUSE_X - HOUSE_X
    z = ((k // columns) + 0.5) / rows * 2.0 * HOUSE_Z - HOUSE_Z
    still = np.stack([x, rng.uniform(0.3, 0.9, count), z], axis=1)
    turn = phases() + rng.uniform(0.0, 2.0 * np.pi, count)
    path = still + 0.3 * np.stack([np.cos(turn), 0.4 * np.sin(2.0 * turn), np.sin(turn)], axis=-1)
    like = LightAsset("point", intensity=0.6 * share, range=1.8 * reach)
    return Swarm("floor light", like, path[0], hues(rng, count, 0.6), path)


def _edge_swarm(count: int, rng: np.random.Generator, reach: float, share: float) -> Swarm:
    """Spot lights under the ceilings of both galleries, swinging across them."""
    gallery_x, gallery_z = (COURT_X + HOUSE_X) / 2.0, (COURT_Z + HOUSE_Z) / 2.0
    storey = np.arange(count) % 2
    along = np.arange(count) // 2 / max(1, (count + 1) // 2) * 4.0 * (gallery_x + gallery_z)
    lengths = np.array([2.0 * gallery_x, 2.0 * gallery_z])
    half = lengths.sum()
    first, part = along < half, along % half
    on_x = part < lengths[0]
    x = np.where(on_x, part - gallery_x, gallery_x)
    z = np.where(on_x, -gallery_z, part - lengths[0] - gallery_z)
    sign = np.where(first, 1.0, -1.0)
    y = np.where(storey == 0, UPPER - SLAB - 0.15, ROOF - 0.15)
    position = np.stack([sign * x, y, sign * z], axis=1)
    rotation = swinging(np.where(on_x, 0.0, np.pi / 2), 0.45, rng.uniform(0.0, 2.0 * np.pi, count))
    like = LightAsset("spot", intensity=30.0 * share, range=6.0 * reach, inner_angle=0.35, outer_angle=0.7)
    return Swarm("gallery light", like, position, hues(rng, count, 0.4), None, rotation)


def _ellipse_swarm(count: int, rng: np.random.Generator, reach: float, share: float) -> Swarm:
    """Ten rings in the court, one above the other, turning both ways."""
    ring = np.arange(count) % 10
    place = (np.arange(count) // 10) / max(1.0, count / 10.0) * 2.0 * np.pi + ring
    turn = place + np.where(ring % 2 == 0, 1.0, -1.0) * phases()
    radius_x = COURT_X * (0.35 + 0.6 * ((ring * 7) % 10) / 9.0)
    radius_z = COURT_Z * (0.35 + 0.5 * ((ring * 3) % 10) / 9.0)
    height = 0.8 + ring * (ROOF - 1.2) / 9.0
    wave = 0.25 * np.sin(3.0 * turn)
    path = np.stack([radius_x * np.cos(turn), height + wave, radius_z * np.sin(turn)], axis=-1)
    like = LightAsset("point", intensity=2.2 * share, range=3.0 * reach)
    return Swarm("ring light", like, path[0], hues(rng, count, 0.6), path)
