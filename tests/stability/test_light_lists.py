"""Tiles that hold near and far: the poles sample, where the box between a tile's nearest and farthest depth is mostly
air. Lists by bins of depth keep few more lights than the tile's pixels really need."""

from __future__ import annotations

from pathlib import Path

import pytest

from engine.app.runtime import Runtime
from engine.assets.samples.sample import make_sample, write_sample
from engine.gpu.types import Device
from engine.render.light_lists import ListStats
from engine.render.settings import RenderSettings
from engine.render.view import View
from tests.stability.rows import covers

pytestmark = pytest.mark.gl

LIGHTS, SIZE = 256, (96, 64)


@covers("light.tile-discontinuities")
def test_poles_keep_at_most_twice_the_lights_they_need(gl_device: Device, tmp_path: Path) -> None:
    runtime = Runtime(gl_device, profile=False)
    try:
        runtime.open(write_sample(make_sample("poles", lights=LIGHTS), tmp_path))
        runtime.update(0.0)

        def lists(depth: str) -> ListStats:
            settings = RenderSettings(samples=1, path="tiled-deferred", light_stats=True, light_depth=depth)
            camera = runtime.default_camera(SIZE[0] / SIZE[1])
            runtime.render(View(camera, *SIZE, settings))
            return runtime.renderer.light_lists.read(wait=True)

        bins, interval = lists("bins"), lists("range")
    finally:
        runtime.close()
    assert bins.needed == interval.needed > bins.tiles, "a scene with lights to tell apart: more than one a tile"
    assert bins.overflow == 0
    assert bins.kept <= 2 * bins.needed
    assert interval.kept > 2 * interval.needed, "and one where it takes more than nearest and farthest"
