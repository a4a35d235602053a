"""A small stage: a runtime with shapes, lights and materials from memory, and pictures of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.app.framing import frame_bounds
from engine.app.headless import render_hdr, render_image
from engine.app.runtime import Runtime
from engine.assets.material import MaterialAsset
from engine.assets.mesh import MeshAsset
from engine.assets.scene import EnvironmentAsset, LightAsset, SceneAsset
from engine.gpu.types import Device
from engine.render.camera import Camera
from engine.render.settings import RenderSettings
from engine.render.view import View

#: no light, black behind: what a test adds is all there is
DARK: dict[str, Any] = {
    "kind": "none", "sun_illuminance": 0.0, "background": "color", "background_color": (0.0, 0.0, 0.0),
}  # fmt: skip


class Stage:
    """`add` puts a mesh with a material into the scene, `lamp` a light; `hdr` and `ldr` take its picture."""

    def __init__(self, device: Device, **environment: Any) -> None:
        self.device = device
        self.runtime = Runtime(device, profile=False)
        self.look(**(environment or DARK))

    def look(self, *, tone_map: str = "none", exposure: float = 0.0, **environment: Any) -> None:
        """Start over with an empty scene under this environment."""
        asset = SceneAsset("stage", environment=EnvironmentAsset(**environment))
        asset.look.tone_map, asset.look.exposure = tone_map, exposure
        self.runtime.load(asset, Path())

    def dark(self) -> None:
        self.look(**DARK)

    def add(
        self, mesh: MeshAsset, material: MaterialAsset | None = None, position: ArrayLike = (0.0, 0.0, 0.0),
        scale: ArrayLike = 1.0, rotation: ArrayLike = (0.0, 0.0, 0.0, 1.0),
    ) -> int:  # fmt: skip
        residency = self.runtime.residency
        mesh_id = residency.add_meshes([mesh])[0]
        material_id = residency.add_material(material, Path()) if material else residency.default_material
        node = self.runtime.scene.nodes.add(mesh.name, -1, position, rotation, np.broadcast_to(scale, 3))
        self.runtime.add_instances([(node, mesh_id, i, material_id) for i in range(len(mesh.submeshes))])
        self.runtime.update()
        return node

    def lamp(
        self, light: LightAsset, position: ArrayLike = (0.0, 0.0, 0.0), rotation: ArrayLike = (0.0, 0.0, 0.0, 1.0)
    ) -> int:
        """A light that shines along its local -Z; returns its row."""
        scene = self.runtime.scene
        row = scene.lights.add(scene.nodes.add("lamp", -1, position, rotation), light, scene.findings)
        self.runtime.update()
        return row

    def view(self, size: tuple[int, int] = (64, 64), camera: Camera | None = None, **settings: Any) -> View:
        camera = camera or frame_bounds(*self.runtime.bounds(), size[0] / size[1], azimuth=0.0, elevation=0.0)
        return View(camera, *size, RenderSettings(**{"samples": 1, **settings}))

    def hdr(
        self, size: tuple[int, int] = (64, 64), camera: Camera | None = None, **settings: Any
    ) -> NDArray[np.float32]:
        return render_hdr(self.runtime, self.view(size, camera, **settings))[0]

    def ldr(self, size: tuple[int, int] = (64, 64), camera: Camera | None = None, **settings: Any) -> NDArray[np.uint8]:
        return render_image(self.runtime, self.view(size, camera, **settings))[0]

    def close(self) -> None:
        self.runtime.close()


def surface(queue: str = "opaque", features: tuple[str, ...] = (), name: str = "test", **params: Any) -> MaterialAsset:
    """A surface material by its parameters."""
    return MaterialAsset(name, queue=queue, features=list(features), params=params)


def front_camera(half: float = 0.5, aspect: float = 1.0) -> Camera:
    """Looks along -Z at the square of that half height about the origin."""
    return frame_bounds(np.full(3, -half), np.full(3, half), aspect, azimuth=0.0, elevation=0.0)
