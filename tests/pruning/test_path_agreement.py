"""Random scenes by every render path: one picture, to the bit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings

from engine.app.runtime import Runtime
from engine.assets.scene import LightAsset
from engine.gpu.types import Device
from engine.render.settings import RenderSettings
from engine.render.view import View
from importers.opening import open_path
from tests.pruning.compare import paths_agree
from tests.pruning.scenes import SceneSpec, specs
from tests.support.stage import Stage

pytestmark = pytest.mark.gl

#: of tests/render/test_sample_files.py's; all of them were tried when this was written
FILES = ("DamagedHelmet/glTF-Binary/DamagedHelmet.glb", "CesiumMan/glTF-Binary/CesiumMan.glb")


@given(spec=specs)
@settings(
    max_examples=8, deadline=None, derandomize=True, database=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow], phases=[Phase.generate],
)  # fmt: skip
def test_random_scenes(stage: Stage, texture_folder: Path, spec: SceneSpec) -> None:
    paths_agree(stage, spec, texture_folder)


@pytest.mark.parametrize("name", FILES, ids=lambda name: Path(name).stem)
def test_sample_files(gl_device: Device, shared_assets: Path, name: str) -> None:
    sample_file_agrees(gl_device, shared_assets / "gltf" / name)


def sample_file_agrees(device: Device, file: Path) -> None:
    """A real file with lamps around it."""
    runtime = Runtime(device, profile=False)
    try:
        open_path(runtime, file)
        low, high = runtime.bounds()
        rng, size = np.random.default_rng(2), float(np.linalg.norm(high - low))
        for i in range(12):
            node = runtime.scene.nodes.add("lamp", -1, rng.uniform(low - 0.3 * size, high + 0.3 * size))
            reach = size * float(rng.uniform(0.3, 1))
            lamp = LightAsset("point" if i % 3 else "spot", intensity=0.2 * size**2, range=reach)
            runtime.scene.lights.add(node, lamp)
        runtime.update(0.4)
        pictures = {}
        for path in ("forward", "deferred", "tiled-deferred", "forward-plus"):
            view = View(runtime.default_camera(1.5), 72, 48, RenderSettings(samples=1, path=path))
            frame = runtime.render(view, hdr=True)
            assert frame.hdr is not None
            assert frame.facts.lighting.path == path
            pictures[path] = np.asarray(frame.hdr.read(), np.float32).copy()
        for path, picture in pictures.items():
            assert np.array_equal(picture, pictures["forward"]), path
    finally:
        runtime.close()
