"""A small stage: a runtime with shapes from memory, and pictures of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.app.framing import frame_bounds
from engine.app.headless import render_hdr, render_image
from engine.app.runtime import Runtime
from engine.assets.material import MaterialAsset
from engine.assets.mesh import MeshAsset
from engine.assets.scene import EnvironmentAsset, SceneAsset
from engine.gpu.types import Device
from engine.render.camera import Camera
from engine.render.settings import RenderSettings
from engine.render.view import View


class Stage:
    """`add` puts a mesh with a material into the scene; `hdr` and `ldr` take its picture."""

    def __init__(self, device: Device) -> None:
        self.runtime = Runtime(device)
        self.look(kind="uniform", sun_illuminance=0.0)

    def look(self, *, tone_map: str = "none", **environment: Any) -> None:
        asset = SceneAsset("stage", environment=EnvironmentAsset(**environment))
        asset.look.tone_map = tone_map
        self.runtime.load(asset, Path())

    def add(
        self, mesh: MeshAsset, material: MaterialAsset | None = None, position: tuple[float, ...] = (0.0, 0.0, 0.0),
        scale: float = 1.0,
    ) -> int:  # fmt: skip
        residency = self.runtime.residency
        mesh_id = residency.add_meshes([mesh])[0]
        material_id = residency.add_material(material, Path()) if material else residency.default_material
        node = self.runtime.scene.nodes.add(mesh.name, translation=position, scale=(scale,) * 3)
        self.runtime.add_instances([(node, mesh_id, i, material_id) for i in range(len(mesh.submeshes))])
        self.runtime.update()
        return node

    def view(self, size: tuple[int, int] = (64, 64), camera: Camera | None = None, **settings: Any) -> View:
        camera = camera or frame_bounds(*self.runtime.bounds(), size[0] / size[1], azimuth=0.0, elevation=0.0)
        return View(camera, *size, RenderSettings(**{"samples": 1, **settings}))

    def hdr(
        self, size: tuple[int, int] = (64, 64), camera: Camera | None = None, **settings: Any
    ) -> NDArray[np.float32]:
        return render_hdr(self.runtime, self.view(size, camera, **settings))[0]

    def ldr(self, size: tuple[int, int] = (64, 64), camera: Camera | None = None, **settings: Any) -> NDArray[np.uint8]:
        return render_image(self.runtime, self.view(size, camera, **settings))[0]


@pytest.fixture
def stage(gl_device: Device) -> Iterator[Stage]:
    made = Stage(gl_device)
    yield made
    made.runtime.close()


@pytest.fixture
def null_stage(null_device: Device) -> Iterator[Stage]:
    made = Stage(null_device)
    yield made
    made.runtime.close()


@pytest.fixture
def surface() -> Callable[..., MaterialAsset]:
    """A surface material by parameters."""

    def make(queue: str = "opaque", features: tuple[str, ...] = (), **params: Any) -> MaterialAsset:
        return MaterialAsset("test", queue=queue, features=list(features), params=params)

    return make
