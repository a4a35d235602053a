"""`lucarna convert` as whole processes: one file cold, a folder cold and warm with a pool, and again when all is done.

Folder: 200 small textured glTF files, so that it runs without the shared assets; with them also 98 real FBX files and
all glTF samples. Peers that convert the same folders are rows that tests/bench/peers.py adds, if it is there.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from engine.report.summary import summarise
from tests.bench.harness import Context, Row
from tests.support.gltf_builder import png, textured_triangle

ROOT = Path(__file__).resolve().parents[2]
ASSETS = Path(os.environ.get("LUCARNA_ASSETS", ROOT.parent / "shared" / "assets"))


def run(ctx: Context) -> list[Row]:
    rows: list[Row] = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        many = folder / "many"
        many.mkdir()
        for number in range(200):
            textured_triangle(png(256, 256, (number, 5, 9))).write_glb(many / f"m{number}.glb")
        one = ASSETS / "gltf/CesiumMan/glTF-Binary/CesiumMan.glb"
        if one.is_file():
            rows += _case(ctx, "CesiumMan.glb", [str(one)], folder, [1])
        rows += _case(ctx, "200 .glb of 256x256", [str(many)], folder, [1, 2])
        if not ctx.quick and ASSETS.is_dir():
            rows += _case(ctx, "98 .fbx", [str(ASSETS / "fbx_ufbx" / "maya_*.fbx")], folder, [1, 2])
            rows += _case(ctx, "57 .gltf/.glb", [str(ASSETS / "gltf")], folder, [1, 2])
    return rows


def _case(ctx: Context, case: str, sources: Sequence[str], folder: Path, jobs: Sequence[int]) -> list[Row]:
    repeats = 2 if ctx.quick else 3
    rows = []
    colds = []
    for count in jobs:
        times = [_convert(sources, folder, count, fresh=True) for _ in range(repeats)]
        colds.append(times)
        rows.append(Row(case, f"cold, {count} worker(s)", summarise(times)))
    shutil.rmtree(folder / "out", ignore_errors=True)
    moved = [_convert(sources, folder, jobs[-1], fresh=False, forget_outputs=True) for _ in range(repeats)]
    warm = [_convert(sources, folder, jobs[-1], fresh=False) for _ in range(repeats + 2)]
    ratio = summarise(colds[-1]).median / summarise(warm).median
    rows.append(Row(case, "outputs gone, cache there", summarise(moved)))
    rows.append(Row(case, "again, all up to date", summarise(warm), note=f"{ratio:.0f}x faster than cold; goal 100x"))
    return rows


def _convert(
    sources: Sequence[str], folder: Path, jobs: int, *, fresh: bool, forget_outputs: bool = False
) -> float:  # fmt: skip
    """ms of one whole process. `fresh`: without cache and outputs."""
    if fresh:
        shutil.rmtree(folder / "cache", ignore_errors=True)
    if fresh or forget_outputs:
        shutil.rmtree(folder / "out", ignore_errors=True)
    command = [sys.executable, "-m", "importers.cli", "convert", *sources, "--out", str(folder / "out"), "--quiet"]
    environment = os.environ | {"LUCARNA_CACHE": str(folder / "cache")}
    started = time.perf_counter()
    subprocess.run([*command, "--jobs", str(jobs)], cwd=ROOT, env=environment, capture_output=True, check=False)
    return (time.perf_counter() - started) * 1e3
