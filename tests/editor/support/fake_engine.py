"""An engine without engine: a small scene, a fake residency and a runtime that paints from them on the CPU.

It has the surface the editor uses and nothing more, so UI tests need no GPU, no shaders and no importer."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from editor.host import Cancelled, Resolved
from engine.assets.material import MaterialAsset, TextureRef
from engine.assets.scene import CameraAsset, LightAsset, NodeAsset, SceneAsset
from engine.core.errors import FormatError
from engine.core.findings import Findings
from engine.core.param import Param, ParamBlock, param
from engine.gpu.types import Caps
from engine.report.stats import FrameStats, PassStat
from engine.scene.scene import Scene


class Settings(ParamBlock):
    exposure: float = param(0.0, min=-20.0, max=20.0, step=0.1, unit="EV", doc="added to the scene's exposure")
    tone_map: str = param("scene", choices=("scene", "none", "agx"), doc="curve to the display")
    environment_rotation: float = param(0.0, min=-360.0, max=360.0, unit="deg", doc="turns the environment")
    view: str = param("lit", choices=("lit", "normal"), doc="debug view")
    force_all: bool = param(False, doc="leave nothing out")
    shadow_floor: float = param(0.0, min=0.0, max=1.0, doc="how dark")


EFFECT = SimpleNamespace(
    name="surface",
    files=(),
    params=(
        Param("base_color", "color4", (1.0, 1.0, 1.0, 1.0), 0.0, 1.0, doc="colour of the surface"),
        Param("roughness", "float", 1.0, 0.0, 1.0, doc="0 is a mirror"),
        Param("metallic", "float", 1.0, 0.0, 1.0),
        Param("emissive", "color3", (0.0, 0.0, 0.0), 0.0, 1000.0),
        Param("alpha_cutoff", "float", 0.5, 0.0, 1.0),
    ),
    textures=(
        SimpleNamespace(name="base_color_map", doc="sRGB"),
        SimpleNamespace(name="normal_map", doc="+Y"),
    ),
)


class Residency:
    def __init__(self) -> None:
        paint = MaterialAsset("paint", params={"roughness": 0.4})
        paint.textures["base_color_map"] = TextureRef("paint.dds")
        self.records = [
            SimpleNamespace(asset=paint, effect=EFFECT, path="/nowhere/paint.material.toml"),
            SimpleNamespace(asset=MaterialAsset("steel"), effect=EFFECT, path=""),
        ]
        part = SimpleNamespace(
            index_count=36, topology="triangles", bounds_min=(-0.5, -0.5, -0.5), bounds_max=(0.5, 0.5, 0.5)
        )
        mesh = SimpleNamespace(name="box", submeshes=[part], vertex_count=24, layout=("position", "normal", "uv0"))
        self.meshes = [SimpleNamespace(asset=mesh)]
        self.structure_rev = 1

    def material(self, material: int) -> Any:
        return self.records[material]

    def set_material_param(self, material: int, name: str, value: Any) -> None:
        self.records[material].asset.params[name] = value


class Picture:
    """A texture whose pixels are made of the state that a real picture would show."""

    native = 0

    def __init__(self, pixels: Any) -> None:
        self._pixels = pixels

    def read(self, **_: Any) -> Any:
        return self._pixels


class FakeRuntime:
    def __init__(self, extra_nodes: int = 0) -> None:
        rows = [("root", -1), ("body", 0), ("lid", 1), ("lamp", 0), ("eye", -1)]
        rows += [(f"part {i}", 0) for i in range(extra_nodes)]
        assets = [NodeAsset(name, parent) for name, parent in rows]
        assets[2].translation = (0.0, 1.0, 0.0)
        assets[3].light, assets[4].camera = LightAsset("spot", intensity=40.0), CameraAsset()
        self.asset = SceneAsset("fake", assets)
        self.scene = Scene.from_asset(self.asset)
        self.scene.instances.add_many([1, 2], 0, 0, [0, 1], (0.0, 0.0, 0.0), 0.87)
        self.scene.update()
        self.residency = Residency()
        self.clips: list[Any] = []
        self.duration = 2.0
        self.time = 0.0
        self.closed = False
        self.picked = -1
        self.broken = False

    def update(self, time_s: float = 0.0) -> None:
        self.time = time_s
        self.scene.update()

    def default_camera(self, aspect: float) -> Any:
        matrix = np.eye(4)
        matrix[:3, 3] = (0.0, 0.5, 4.0)
        return SimpleNamespace(world_from_camera=matrix, yfov=0.7)

    def render(self, view: Any) -> Any:
        if self.broken:
            raise FormatError("the fake cannot draw")
        values = [self.residency.records[0].asset.params.get("roughness", 1.0), view.settings.exposure / 20 + 0.5]
        pixels = np.zeros((8, 8, 4), np.uint8)
        pixels[..., :2] = np.clip(np.array(values) * 255, 0, 255)
        pixels[..., 2] = 40 * int(self.scene.nodes.visible_world.sum()) % 256
        pixels[..., 3] = 255
        stats = FrameStats([PassStat("forward", 2.0, "wall"), PassStat("tone_map", 0.5, "wall")], 3.0)
        stats.counters.update(draws=2, triangles=24)
        left_out = [SimpleNamespace(name="shadows", reason="no light casts any", saved="1 pass")]
        return SimpleNamespace(color=Picture(pixels), stats=stats, graph=SimpleNamespace(left_out=left_out))

    def add_nodes(self, nodes: list[Any], base: Path, parent: int = -1) -> Any:
        raise NotImplementedError("the fake engine loads no files")

    def pick(self, view: Any, x: float, y: float) -> int:
        return self.picked

    def pick_hits(self, view: Any, x: float, y: float) -> list[Any]:
        return [(row, np.array([float(i), 0.0, 0.0])) for i, row in enumerate((self.picked, 1)) if row >= 0]

    def close(self) -> None:
        self.closed = True


class FakeDevice:
    caps = Caps("null", "fake device", "0", False, True, True, True, 4096, 256, 1.0, 1 << 20, 64, False)

    def __init__(self) -> None:
        self.frames = 0
        self.open_frame = False

    def begin_frame(self) -> None:
        assert not self.open_frame
        self.open_frame = True

    def end_frame(self) -> None:
        assert self.open_frame
        self.open_frame = False
        self.frames += 1


class FakeHost:
    """`bad` paths fail to resolve, `slow` ones wait until they are cancelled; a scene named `broken` does not open."""

    def __init__(self, extra_nodes: int = 0) -> None:
        self.device = FakeDevice()
        self.runtimes: list[FakeRuntime] = []
        self.extra_nodes = extra_nodes

    def open_device(self, attach: bool) -> Any:
        return self.device

    def resolve(self, path: Path, progress: Any) -> Resolved:
        import time

        progress("Reading", 0.1)
        if "bad" in path.name:
            raise FormatError("is not a model", where=path, hint="check the file")
        while "slow" in path.name:
            time.sleep(0.005)
            progress("Waiting", 0.5)
        findings = Findings(str(path))
        findings.warn("fake.odd", "something odd", "nodes[0]")
        return Resolved(path, path.with_suffix(".scene.json"), None, "", findings)

    def open_runtime(self, device: Any, scene: Path, root: Path | None = None, base: Path | None = None) -> Any:
        if "broken" in scene.name:
            raise FormatError("the scene is damaged", where=scene)
        self.runtimes.append(FakeRuntime(self.extra_nodes))
        return self.runtimes[-1]

    def new_settings(self) -> ParamBlock:
        return Settings()

    def view(self, camera: Any, width: int, height: int, settings: Any) -> Any:
        return SimpleNamespace(camera=camera, width=width, height=height, settings=settings)

    def source_extensions(self) -> tuple[str, ...]:
        return (".glb", ".gltf")


__all__ = ["Cancelled", "FakeDevice", "FakeHost", "FakeRuntime", "Settings"]
