"""From a saved shader to new pixels: 20 edits of surface.frag in a scene of a few materials at 640x360."""

from __future__ import annotations

import shutil
import tempfile
import time
from pathlib import Path

from engine.app.headless import render_image
from engine.app.runtime import Runtime
from engine.assets.material import MaterialAsset
from engine.assets.primitives import card, cube
from engine.assets.scene import EnvironmentAsset, SceneAsset
from engine.core.errors import DeviceError
from engine.core.paths import shaders_dir
from engine.gpu import open_device
from engine.gpu.types import Device
from engine.render.settings import RenderSettings
from engine.render.view import View
from engine.report.summary import summarise
from tests.bench.harness import Context, Row

EDITS = 20
SIZE = (640, 360)
LAST = "sanitise(color), 1.0)"


def run(ctx: Context) -> list[Row]:
    """The look at the files is part of it, the wait for it (0.1 s at most in the editor) is not."""
    try:
        device = open_device("gl")
    except DeviceError:
        return []
    try:
        return [_edits(device, variants, 5 if ctx.quick else EDITS) for variants in (1, 2)]
    finally:
        device.release()


def _edits(device: Device, variants: int, count: int) -> Row:
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        shutil.copytree(shaders_dir(), root / "shaders")
        runtime = Runtime(device, profile=False)
        runtime.load(SceneAsset("bench", environment=EnvironmentAsset("uniform")), root, shaders=[root / "shaders"])
        residency = runtime.residency
        for i, mesh in enumerate(residency.add_meshes([cube(), card()][:variants])):
            material = residency.add_material(MaterialAsset(f"m{i}", features=["double_sided"] if i else []), root)
            node = runtime.scene.nodes.add(f"n{i}", -1, (1.5 * i, 0.0, 0.0))
            runtime.add_instances([(node, mesh, 0, material)])
        runtime.update()
        view = View(runtime.default_camera(SIZE[0] / SIZE[1]), *SIZE, RenderSettings(samples=1))
        render_image(runtime, view)
        path = root / "shaders/effects/surface.frag"
        text = path.read_text(encoding="utf-8")
        assert LAST in text
        times, compiling = [], []
        fresh = time.time() % 1.0  # or the driver's own cache would know the text from the last run
        for i in range(count):
            path.write_text(text.replace(LAST, f"sanitise(color) * {fresh + 0.01 * i:.6f}, 1.0)"), encoding="utf-8")
            begun = time.perf_counter()
            result = runtime.hot_reload.poll(1e6 + i)
            assert result is not None
            assert not result.problems, result.problems
            render_image(runtime, view)
            times.append(1e3 * (time.perf_counter() - begun))
            compiling.append(result.ms)
        runtime.close()
    note = f"worst {max(times):.0f} ms of {count}; {summarise(compiling).median:.0f} ms of it reload"
    case = f"{SIZE[0]}x{SIZE[1]}, {variants} variant{'s' if variants > 1 else ''}"
    return Row(case, "save to pixels", summarise(times), note=note)
