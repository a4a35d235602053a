"""Real files moved and scaled as a whole: textures, skins and hierarchies of others, not ours."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.app.headless import render_hdr
from engine.app.runtime import Runtime
from engine.gpu.types import Device
from engine.render.camera import Camera
from engine.render.settings import RenderSettings
from engine.render.view import View
from importers.opening import open_path
from importers.settings import ImportSettings
from tests.stability.metamorphic import differing
from tests.stability.rows import covers

pytestmark = pytest.mark.gl

SIZE = (90, 60)
FILES = ("CesiumMan/glTF-Binary/CesiumMan.glb", "CesiumMilkTruck/glTF-Binary/CesiumMilkTruck.glb")
#: (scale, offset) of the node that everything is hung on
CHANGES = ((1e-4, (0.0, 0.0, 0.0)), (1e4, (0.0, 0.0, 0.0)), (1.0, (1e6, -2e5, 1e6)))


@pytest.fixture(params=FILES, ids=lambda name: Path(name).stem)
def opened(
    gl_device: Device, shared_assets: Path, request: pytest.FixtureRequest, tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> Iterator[Runtime]:  # fmt: skip
    monkeypatch.setenv("LUCARNA_CACHE", str(tmp_path))
    runtime = Runtime(gl_device, profile=False)
    try:
        open_path(runtime, shared_assets / "gltf" / request.param, settings=ImportSettings(quality="draft"))
        runtime.update(0.4)
        yield runtime
    finally:
        runtime.close()


def shoot(runtime: Runtime, camera: Camera) -> NDArray[np.float32]:
    """Without shadows: their texels stand still in the world, so their edges do move in a picture that goes along."""
    settings = RenderSettings(samples=1, anisotropy=1.0, background="color", shadows=False)
    return render_hdr(runtime, View(camera, *SIZE, settings))[0].copy()


@covers("pose.tiny-and-huge", "pose.far-from-the-origin")
def test_scaled_and_moved(opened: Runtime) -> None:
    camera = opened.framing_camera(SIZE[0] / SIZE[1])
    before = shoot(opened, camera)
    assert before[..., :3].max() > 0.1
    nodes = opened.scene.nodes
    carrier = nodes.add("carrier")
    for row in np.flatnonzero(nodes.alive & (nodes.parent < 0)).tolist():
        if row != carrier:
            nodes.reparent(row, carrier)
    for scale, offset in CHANGES:
        nodes.set_trs([carrier], [offset], [(0, 0, 0, 1)], [(scale,) * 3])
        opened.scene.update()
        pose = camera.world_from_camera.copy()
        pose[:3, 3] = pose[:3, 3] * scale + offset
        after = shoot(opened, replace(camera, world_from_camera=pose, znear=camera.znear * scale))
        assert differing(before, after, 5e-3) < 1e-3, f"scale {scale}, offset {offset}"
