"""Random scenes over subsets of all that the renderer may leave out, as plain values that hypothesis can shrink."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import strategies as st

from engine.assets.dds import write_dds
from engine.assets.material import MaterialAsset, TextureRef
from engine.assets.mesh import MeshAsset
from engine.assets.primitives import card, cube, uv_sphere
from engine.assets.scene import LightAsset
from engine.assets.texture import TextureAsset
from engine.math import quat
from engine.render.camera import Camera
from engine.render.lighting import PATHS
from engine.render.occlusion import METHODS
from engine.render.settings import DEBUG_VIEWS, TONE_MAPS
from engine.render.shadows.quality import FILTERS
from tests.support.stage import Stage, front_camera

#: slot -> file and format of the texture that random materials put there
TEXTURES = {
    "base_color_map": ("color.dds", "rgba8-srgb"), "metal_rough_map": ("orm.dds", "rgba8"),
    "normal_map": ("normal.dds", "rgba8"), "occlusion_map": ("orm.dds", "rgba8"),
    "emissive_map": ("color.dds", "rgba8-srgb"),
}  # fmt: skip
SIZE = (28, 22)
#: a lamp that is bright on one side only
PROFILE = "lamp.ies"
IES = "IESNA91\nTILT=NONE\n1 1000 1 3 2 1 2 0 0 0\n1 1 10\n0 90 180\n0 180\n400 900 10\n400 100 10\n"


@dataclass(frozen=True)
class Body:
    """One object: its shape, where it stands (0 to 3) and what its material uses."""

    shape: str = "sphere"
    place: int = 0
    queue: str = "opaque"
    maps: tuple[str, ...] = ()
    features: tuple[str, ...] = ()
    vertex_color: bool = False
    emissive: float = 0.0
    metallic: float = 0.3
    roughness: float = 0.5
    moved_uv: bool = False
    mirrored: bool = False
    effect: str = "surface"
    thickness: float = 0.0


@dataclass(frozen=True)
class SceneSpec:
    """A whole picture: what stands there, what lights it, and how it is looked at."""

    bodies: tuple[Body, ...] = (Body(),)
    lights: tuple[str, ...] = ()
    environment: str = "none"
    environment_intensity: float = 1.0
    sun: float = 0.0
    background: str = "color"
    background_blur: float = 0.0
    tone_map: str = "none"
    exposure: float = 0.0
    view: str = "lit"
    samples: int = 1
    shadows: bool = True
    shadow_filter: str = "pcf"
    translucent_shadows: bool = False
    local_shadows: str = "off"
    ambient_occlusion: str = "off"
    gi: str = "off"
    reflections: bool = False
    bloom: float = 0.0
    auto_exposure: bool = False
    antialias: str = "none"
    depth_of_field: bool = False
    shadow_floor: float = 0.0
    planar_mirrors: int = 2
    refraction: str = "tested"
    path: str = "auto"
    cutouts_smooth: bool = True
    looks_away: bool = False
    far_away: bool = False


bodies = st.builds(
    Body,
    shape=st.sampled_from(["sphere", "cube", "card"]),
    place=st.integers(0, 3),
    queue=st.sampled_from(["opaque", "opaque", "alpha_test", "transparent", "background", "overlay"]),
    maps=st.lists(st.sampled_from(sorted(TEXTURES)), max_size=3, unique=True).map(tuple),
    features=st.sampled_from(
        [(), (), ("unlit",), ("double_sided",), ("double_sided", "unlit"), ("planar_reflection",)]
    ),
    vertex_color=st.booleans(),
    emissive=st.sampled_from([0.0, 0.0, 2.0]),
    metallic=st.sampled_from([0.0, 0.4, 1.0]),
    roughness=st.sampled_from([0.0, 0.3, 1.0]),
    moved_uv=st.booleans(),
    mirrored=st.booleans(),
)

specs = st.builds(
    SceneSpec,
    bodies=st.lists(bodies, max_size=3).map(tuple),
    lights=st.lists(
        st.sampled_from(["directional", "point", "spot", "dark", "rectangle", "disk", "profile", "ball"]), max_size=3
    ).map(tuple),
    environment=st.sampled_from(["none", "uniform", "studio"]),
    environment_intensity=st.sampled_from([1.0, 1.0, 0.0]),
    sun=st.sampled_from([2.0, 0.0, 2.0]),
    background=st.sampled_from(["color", "environment"]),
    background_blur=st.sampled_from([0.0, 0.6]),
    tone_map=st.sampled_from(TONE_MAPS),
    exposure=st.sampled_from([0.0, -1.5]),
    view=st.sampled_from(["lit"] * 6 + list(DEBUG_VIEWS)),
    samples=st.sampled_from([1, 4]),
    shadows=st.sampled_from([True, True, True, False]),
    shadow_filter=st.sampled_from(["pcf", "pcf", *FILTERS]),
    translucent_shadows=st.sampled_from([False, True]),
    local_shadows=st.sampled_from(["off", "all"]),
    ambient_occlusion=st.sampled_from(["off", "off", "off", *METHODS]),
    gi=st.sampled_from(["off", "off", "off", "one", "many"]),
    reflections=st.sampled_from([False, False, True]),
    bloom=st.sampled_from([0.0, 0.0, 0.3]),
    auto_exposure=st.sampled_from([False, False, True]),
    depth_of_field=st.booleans(),
    shadow_floor=st.sampled_from([0.0, 0.0, 0.7]),
    antialias=st.sampled_from(["none", "fxaa", "smaa", "taa"]),
    path=st.sampled_from(["auto", *PATHS]),
    looks_away=st.sampled_from([False] * 7 + [True]),
    far_away=st.sampled_from([False] * 7 + [True]),
)


def write_textures(folder: Path) -> None:
    """8x8 random texels with mips for each of TEXTURES."""
    rng = np.random.default_rng(11)
    for file, format in sorted(set(TEXTURES.values())):
        chain = [rng.integers(0, 256, (8 >> m, 8 >> m, 4), np.uint8) for m in range(4)]
        if file == "normal.dds":
            for level in chain:
                level[..., :2] = 96 + level[..., :2] // 4  # leaning by up to 30 degrees
        write_dds(folder / file, TextureAsset(format, 8, 8, [[level.tobytes() for level in chain]]))
    (folder / PROFILE).write_text(IES, encoding="utf-8")


def mesh_of(body: Body) -> MeshAsset:
    shapes = {"sphere": lambda: uv_sphere(0.4, 8, 16), "cube": lambda: cube(0.6), "card": lambda: card(0.8)}
    mesh = shapes[body.shape]()
    if body.vertex_color:
        colors = np.random.default_rng(4).integers(20_000, 65_536, (mesh.vertex_count, 4), np.uint16)
        mesh = replace(mesh, streams={**mesh.streams, "color": colors})
    return mesh


def material_of(body: Body) -> MaterialAsset:
    moved: dict[str, Any] = {"offset": (0.2, 0.1), "rotation": 0.5, "scale": (2.0, 1.5)} if body.moved_uv else {}
    alpha = 0.5 if body.queue in ("transparent", "overlay") else 1.0
    return MaterialAsset(
        "random", effect=body.effect, queue=body.queue, features=list(body.features),
        params={
            "base_color": (0.8, 0.6, 0.4, alpha), "metallic": body.metallic, "roughness": body.roughness,
            "emissive": (0.3, 0.6, 0.9), "emissive_strength": body.emissive,
            **({"thickness": body.thickness} if body.thickness else {}),
        },
        textures={slot: TextureRef(TEXTURES[slot][0], **moved) for slot in body.maps},
    )  # fmt: skip


def build(stage: Stage, spec: SceneSpec, folder: Path) -> Camera:
    """Put the scene on the stage; returns the camera that looks at it."""
    stage.look(
        kind=spec.environment, color=(0.4, 0.5, 0.6), intensity=spec.environment_intensity, sun_illuminance=spec.sun,
        background=spec.background, background_color=(0.1, 0.05, 0.2), background_blur=spec.background_blur,
        tone_map=spec.tone_map, exposure=spec.exposure,
    )  # fmt: skip
    runtime = stage.runtime
    origin = np.array([1e6, 0.0, -2e5]) if spec.far_away else np.zeros(3)
    rows = []
    for number, body in enumerate(spec.bodies):
        mesh = runtime.residency.add_meshes([mesh_of(body)])[0]
        material = runtime.residency.add_material(material_of(body), folder)
        place = np.add(origin, (0.5 * (body.place % 2) - 0.25, 0.4 * (body.place // 2) - 0.2, -0.3 * number))
        turn = quat.from_axis_angle((0.2, 1.0, 0.1), 0.4 * number)
        node = runtime.scene.nodes.add("body", -1, place, turn, (-1.0 if body.mirrored else 1.0, 1.0, 1.0))
        rows.append((node, mesh, 0, material))
    runtime.add_instances(rows)
    for number, kind in enumerate(spec.lights):
        name = "point" if kind in ("dark", "profile", "ball") else kind
        light = LightAsset(name, (1.0, 0.8, 0.6), 0.0 if kind == "dark" else 1.5, 5.0)
        light.radius = 0.3 if kind == "ball" else 0.0
        if kind == "profile":
            light.profile = str(folder / PROFILE)
        stage.lamp(light, np.add(origin, (0.6 - 0.5 * number, 0.7, 1.2)), quat.from_axis_angle((1.0, 0.3, 0.0), -0.4))
    assert not runtime.residency.findings.items, [str(f) for f in runtime.residency.findings]
    camera = front_camera(0.8, SIZE[0] / SIZE[1])
    if spec.looks_away:
        camera.world_from_camera[:3, :3] = np.diag([-1.0, 1.0, -1.0])
    camera.world_from_camera[:3, 3] += origin
    return camera
