"""What `lucarna report` lends to experiments: opening scenes, baking environments, filtering mips."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from engine.core.paths import template_dir

if TYPE_CHECKING:
    from engine.gpu.types import Device
    from engine.render.camera import Camera
    from engine.render.frame import Frame
    from engine.render.view import View
    from engine.resources.residency import Residency
    from engine.scene.scene import Scene

Floats = NDArray[np.float32]

#: of the folder of sample assets that LUCARNA_ASSETS names, where there is one: textured, skinned, of many parts
SHARED = ("DamagedHelmet", "CesiumMilkTruck", "CesiumMan", "2CylinderEngine", "MetalRoughSpheres")


class RuntimeScene:
    """A scene in a runtime of its own: nothing is compiled or uploaded before the first frame."""

    def __init__(self, path: Path, device: Device) -> None:
        from engine.app.runtime import MANY_PICTURES, Runtime
        from importers.opening import open_path

        self.name = path.name.removesuffix(".scene.json")
        self._runtime = Runtime(device, profile=False, pixels=MANY_PICTURES)
        try:
            open_path(self._runtime, path)
            self._runtime.update(0.0)
        except BaseException:  # an interrupt, too, leaves nothing behind
            self._runtime.close()
            raise

    @property
    def scene(self) -> Scene:
        return self._runtime.scene

    @property
    def residency(self) -> Residency:
        return self._runtime.residency

    def camera(self, aspect: float) -> Camera:
        return self._runtime.default_camera(aspect)

    def render(self, view: View, *, hdr: bool = False) -> Frame:
        return self._runtime.render(view, hdr=hdr)

    def explain(self, frame: Frame) -> list[str]:
        """What was left out of this frame, and why."""
        from engine.experiments.harness.scenes import explain

        return explain(frame)

    def environment_faces(self) -> Floats:
        from engine.experiments.harness.scenes import faces_of

        return faces_of(self._runtime.renderer.environments, self._runtime.scene)

    def close(self) -> None:
        self._runtime.close()


class ImporterTools:
    """See engine.experiments.harness.context.Tools."""

    def sample_scenes(self) -> Sequence[Path]:
        folder = os.environ.get("LUCARNA_ASSETS")
        found = [sorted(Path(folder, "gltf").glob(f"{name}/**/{name}.gl*")) for name in SHARED] if folder else []
        more = [paths[0] for paths in found if paths]
        return [template_dir() / "assets" / "orrery.glb", *more]

    def open_scene(self, path: Path, device: Device) -> RuntimeScene:
        return RuntimeScene(path, device)

    def prefilter(self, faces: Floats, size: int, roughness: float, samples: int) -> Floats:
        from importers.textures.cube import CubeChain
        from importers.textures.environment import _prefilter

        return _prefilter(CubeChain.build(faces), size, roughness, samples)

    def prefilter_samples(self, size: int, roughness: float) -> int:
        from importers.textures.environment import _SAMPLES, SIZE, SMALLEST

        mips = SIZE.bit_length() - SMALLEST.bit_length() + 1
        return int(_SAMPLES[min(round(roughness * (mips - 1)), len(_SAMPLES) - 1)])

    def cube_directions(self, size: int) -> NDArray[np.float64]:
        from importers.textures.cube import directions

        return directions(size)

    def source_faces(self, kind: str, size: int) -> Floats:
        from engine.assets.scene import EnvironmentAsset
        from importers.textures.environment import source_faces

        return source_faces(EnvironmentAsset(kind=kind), size, Path())

    def resample(self, image: Floats, width: int, height: int, kind: str) -> Floats:
        from importers.textures.mips import resample

        return resample(image, width, height, kind, wrap=True)
