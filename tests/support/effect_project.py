"""A project on disk with effects of its own: a thing on a floor under a sun and two lamps, opened as a user's is."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from engine.app.framing import frame_bounds
from engine.app.headless import render_image
from engine.app.runtime import Runtime
from engine.assets.lmesh import write_lmesh
from engine.assets.mesh import MeshAsset
from engine.assets.primitives import cube, plane
from engine.assets.scene import EnvironmentAsset, LightAsset, MeshRef, NodeAsset, SceneAsset
from engine.assets.scene_json import write_scene
from engine.gpu.types import Device
from engine.render.settings import RenderSettings
from engine.render.view import View

PATHS = ("forward", "forward-plus", "deferred", "tiled-deferred")
FLOOR = 'schema = "lucarna.material/1"\nname = "floor"\n[params]\nroughness = 0.9\nmetallic = 0.0\n'


class EffectProject:
    """`files`: path -> text, below the project's folder; the thing is drawn with `thing.material.toml`."""

    def __init__(self, folder: Path, files: dict[str, str], mesh: MeshAsset | None = None) -> None:
        self.folder = folder
        self.scene = folder / "a.scene.json"
        (folder / "project.toml").write_text('schema = "lucarna.project/1"\nname = "a"\n', encoding="utf-8")
        for name, text in {"floor.material.toml": FLOOR, **files}.items():
            self.write(name, text)
        write_lmesh(folder / "a.lmesh", [mesh or cube(), plane(4.0)], {})
        nodes = [
            NodeAsset("thing", mesh=MeshRef("a.lmesh", 0, "", ["thing.material.toml"])),
            NodeAsset("floor", translation=(0.0, -0.8, 0.0), mesh=MeshRef("a.lmesh", 1, "", ["floor.material.toml"])),
            NodeAsset("sun", rotation=(-0.5, 0.2, 0.1, 0.84), light=LightAsset("directional", intensity=2.0)),
            NodeAsset("lamp", translation=(1.0, 1.0, 1.5), light=LightAsset("point", (1.0, 0.6, 0.2), 3.0, 6.0)),
            NodeAsset("other", translation=(-1.5, 0.5, 1.0), light=LightAsset("point", (0.2, 0.5, 1.0), 3.0, 6.0)),
        ]
        look = EnvironmentAsset("uniform", color=(0.2, 0.2, 0.2), background="color", sun_illuminance=0.0)
        write_scene(self.scene, SceneAsset("a", nodes, environment=look))

    def write(self, name: str, text: str | bytes) -> Path:
        """Write a file of the project; its time is later than before."""
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        before = path.stat().st_mtime_ns if path.exists() else 0
        path.write_bytes(text.encode("utf-8") if isinstance(text, str) else text)
        now = max(path.stat().st_mtime_ns, before) + 2_000_000
        os.utime(path, ns=(now, now))
        return path

    def open(self, device: Device) -> Runtime:
        runtime = Runtime(device, profile=False)
        runtime.open(self.scene)
        runtime.update()
        return runtime


def picture(runtime: Runtime, size: tuple[int, int] = (64, 48), **settings: object) -> NDArray[np.uint8]:
    """What the thing looks like from the front and above, and no problem on the way."""
    camera = frame_bounds(np.full(3, -0.9), np.full(3, 0.9), size[0] / size[1])
    view = View(camera, *size, RenderSettings(**{"samples": 1, **settings}))
    return np.array(render_image(runtime, view)[0])
