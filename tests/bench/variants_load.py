"""A scene of 20 surface variants comes up: by one frame that waits, and in slices as the editor's window does it.

With nothing known to any cache, with the program cache alone (the driver's own is emptied), and with both."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from engine.report.summary import summarise
from tests.bench.harness import Context, Row

VARIANTS = 20
LONG = 100.0
CACHES = ("none", "of programs", "of programs, the driver's")


def run(ctx: Context) -> list[Row]:
    """In processes of their own: caches and machine code are per process or per folder."""
    found: dict[tuple[str, str], list[dict[str, float]]] = {(c, h): [] for c in CACHES for h in ("waits", "slices")}
    for _ in range(1 if ctx.quick else 5):
        with tempfile.TemporaryDirectory() as folder:
            for caches in CACHES:
                for how in ("waits", "slices"):
                    if caches == "of programs":
                        shutil.rmtree(f"{folder}/{how}/driver", ignore_errors=True)
                    found[caches, how].append(_child(how, f"{folder}/{how}"))
    rows = []
    for (caches, how), runs in found.items():
        note = (
            f"{runs[0]['variants']:.0f} variants, {summarise([r['compile'] for r in runs]).median:.0f} ms compiling; "
        )
        note += (
            f"frames over {LONG:.0f} ms: {max(r['long'] for r in runs):.0f} of {max(r['frames'] for r in runs):.0f}, "
        )
        note += f"longest {max(run['longest'] for run in runs):.0f} ms"
        rows.append(Row(f"caches: {caches}", how, summarise([run["ms"] for run in runs]), note=note))
    return rows


def _child(how: str, folder: str) -> dict[str, float]:
    environment = {**os.environ, "LUCARNA_CACHE": folder, "MESA_SHADER_CACHE_DIR": f"{folder}/driver"}
    environment.pop("LUCARNA_PROGRAM_CACHE", None)
    done = subprocess.run(
        [sys.executable, "-m", "tests.bench.variants_load", how], capture_output=True, text=True, env=environment,
        check=True,
    )  # fmt: skip
    return {name: float(value) for name, value in (pair.split("=") for pair in done.stdout.split())}


def _measure(how: str) -> None:
    from engine.app.runtime import Runtime
    from engine.assets.material import MaterialAsset, TextureRef
    from engine.assets.primitives import cube
    from engine.assets.scene import EnvironmentAsset, SceneAsset
    from engine.gpu import open_device
    from engine.render.settings import RenderSettings
    from engine.render.view import View

    patience = 0.02  # as the editor has it
    device = open_device("gl")
    runtime = Runtime(device, profile=False)
    runtime.load(SceneAsset("bench", environment=EnvironmentAsset("studio")), Path())
    residency = runtime.residency
    mesh = residency.add_meshes([cube()])[0]
    slots = [slot.name for slot in residency.effects.get("surface").textures]
    for i in range(VARIANTS):
        features = [name for bit, name in enumerate(("double_sided", "unlit")) if i >> bit & 1]
        textures = {slot: TextureRef("") for j, slot in enumerate(slots) if (i * 7) >> j & 1}
        material = residency.add_material(MaterialAsset(f"m{i}", features=features, textures=textures), Path())
        node = runtime.scene.nodes.add(f"n{i}", -1, (1.5 * (i % 5), 1.5 * (i // 5), 0.0))
        runtime.add_instances([(node, mesh, 0, material)])
    runtime.update()
    view = View(runtime.default_camera(640 / 360), 640, 360, RenderSettings(samples=1))
    begun = time.perf_counter()
    frames: list[float] = []
    frame = None
    while frame is None:
        start = time.perf_counter()
        frame = runtime.render(view) if how == "waits" else runtime.follow(view, patience)
        device.finish()
        frames.append(1e3 * (time.perf_counter() - start))
    frame.color.read()
    total = 1e3 * (time.perf_counter() - begun)
    variants = len(residency.effects.variants())
    compiling = sum(variant.compile_ms for variant in residency.effects.variants())
    long = sum(ms > LONG for ms in frames)
    print(f"ms={total} variants={variants} compile={compiling} frames={len(frames)} long={long} longest={max(frames)}")
    runtime.close()
    device.release()


if __name__ == "__main__":
    _measure(sys.argv[1])
