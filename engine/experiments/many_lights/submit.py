"""What a frame of many lights costs the processor: the null device draws nothing, so that all time is ours."""

from __future__ import annotations

import time

import numpy as np

from engine.assets.samples.sample import SampleScene
from engine.gpu import open_device
from engine.render.camera import Camera
from engine.render.lighting import PATHS
from engine.render.renderer import Renderer
from engine.render.settings import RenderSettings
from engine.render.view import View
from engine.resources.residency import Residency
from engine.resources.samples import sample_scene


def submit_ms(sample: SampleScene, size: tuple[int, int], frames: int = 15) -> dict[str, float]:
    """Median ms of a frame by path: the scene stands still, the first frames (compiling, uploads) do not count."""
    device = open_device("null")
    residency = Residency(device)
    scene = sample_scene(sample, residency)
    cameras = scene.cameras
    camera = Camera.from_asset(cameras.asset(0), scene.nodes.world_matrix(int(cameras.node[0])))
    renderer = Renderer(device, residency, profile=False)
    found = {}
    for path in PATHS:
        view = View(camera, *size, RenderSettings(samples=1, path=path))
        taken = []
        for _ in range(frames + 3):
            start = time.perf_counter_ns()
            renderer.render(scene, view)
            taken.append((time.perf_counter_ns() - start) / 1e6)
        found[path] = float(np.median(taken[3:]))
    renderer.release()
    residency.effects.release()
    residency.release()
    device.close()
    return found
