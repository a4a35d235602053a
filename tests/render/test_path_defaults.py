"""Settings as they are at first: going from path to path leaves the picture of the sample scenes as it is."""

from __future__ import annotations

import importlib

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.assets.samples import SAMPLES
from engine.gpu.types import Device
from engine.render.camera import Camera
from engine.render.lighting import PATH_CHOICES
from engine.render.renderer import Renderer
from engine.render.settings import RenderSettings
from engine.render.view import View
from engine.resources.residency import Residency
from engine.resources.samples import sample_scene

pytestmark = pytest.mark.gl

SIZE = (96, 54)


@pytest.mark.parametrize("sample", SAMPLES)
def test_the_path_changes_no_picture(gl_device: Device, sample: str) -> None:
    residency = Residency(gl_device)
    scene = sample_scene(importlib.import_module(SAMPLES[sample][0]).build(48), residency)
    renderer = Renderer(gl_device, residency, profile=False)
    camera = Camera.from_asset(scene.cameras.asset(0), scene.nodes.world_matrix(int(scene.cameras.node[0])))
    try:
        for samples in (None, 1):
            pictures: dict[str, NDArray[np.float32]] = {}
            for path in PATH_CHOICES:
                settings = RenderSettings(path=path) if samples is None else RenderSettings(path=path, samples=samples)
                frame = renderer.render(scene, View(camera, *SIZE, settings), hdr=True)
                assert frame.hdr is not None
                pictures[path] = np.asarray(frame.hdr.read(), np.float32).copy()
                if samples == 1 and path != "auto":
                    assert frame.path.path == path
            assert pictures["forward"][..., :3].std() > 0.01
            for path, picture in pictures.items():
                assert np.array_equal(picture, pictures["forward"]), f"{path} at {samples or 'default'} samples"
    finally:
        renderer.release()
        residency.effects.release()
        residency.release()
