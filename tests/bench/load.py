"""From file to first picture: our converted format against the source, for DamagedHelmet (skipped without the assets).

The device and its programs are warm in both, so that the difference is loading alone."""

from __future__ import annotations

import os
import shutil
import tempfile
import time
from pathlib import Path

from engine.app.headless import render_image
from engine.app.runtime import Runtime
from engine.gpu import open_device
from engine.gpu.types import Device
from engine.render.settings import RenderSettings
from engine.render.view import View
from engine.report.summary import summarise
from importers.convert import convert
from importers.settings import ImportSettings
from tests.bench.harness import Context, Row

ROOT = Path(__file__).resolve().parents[2]


def run(ctx: Context) -> list[Row]:
    assets = Path(os.environ.get("LUCARNA_ASSETS", ROOT.parent / "shared" / "assets"))
    source = assets / "gltf/DamagedHelmet/glTF-Binary/DamagedHelmet.glb"
    if not source.is_file():
        return []
    device = open_device("gl")
    times: dict[str, list[float]] = {"source": [], "converted": []}
    with tempfile.TemporaryDirectory() as name:
        os.environ["LUCARNA_CACHE"] = str(Path(name) / "cache")
        first = convert(source, Path(name) / "warm", ImportSettings())
        assert first.scene is not None
        warm = Runtime(device, profile=False)  # stays open, so that its programs do
        warm.open(first.scene)
        _draw(warm)
        for i in range(2 + (2 if ctx.quick else 5)):
            shutil.rmtree(Path(name) / "cache", ignore_errors=True)
            shutil.rmtree(Path(name) / "out", ignore_errors=True)
            start = time.perf_counter()
            result = convert(source, Path(name) / "out", ImportSettings())
            assert result.scene is not None
            _picture(device, result.scene)
            middle = time.perf_counter()
            _picture(device, result.scene)
            if i >= 2:
                times["source"].append((middle - start) * 1e3)
                times["converted"].append((time.perf_counter() - middle) * 1e3)
        del os.environ["LUCARNA_CACHE"]
        warm.close()
    device.release()
    rows = {name: summarise(values) for name, values in times.items()}
    ratio = rows["source"].median / rows["converted"].median
    return [
        Row("DamagedHelmet", "from .glb, nothing cached", rows["source"]),
        Row("DamagedHelmet", "from .scene.json", rows["converted"], note=f"{ratio:.1f}x faster, goal 10x"),
    ]


def _picture(device: Device, scene: Path) -> None:
    runtime = Runtime(device, profile=False)
    runtime.open(scene)
    _draw(runtime)
    runtime.close()


def _draw(runtime: Runtime) -> None:
    runtime.update()
    settings = RenderSettings(samples=1, anisotropy=1.0)
    render_image(runtime, View(runtime.default_camera(16 / 9), 320, 180, settings))
