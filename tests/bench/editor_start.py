"""How soon the editor's window is there, and the sample in it: whole processes, on a virtual display where there is no
other. First start: nothing converted, no shader compiled; then as on any other day."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from engine.report.summary import summarise
from tests.bench.harness import Context, Row
from tests.support.ui_scripts import on_display

SCRIPT = Path(__file__).resolve().parents[1] / "editor" / "support" / "start_times.py"
GOALS = {"window": "goal 2,000 ms", "picture": "goal 2,000 ms"}


def run(ctx: Context) -> list[Row]:
    rows = []
    with tempfile.TemporaryDirectory(prefix="lucarna-start-") as folder:
        places = {
            name: str(Path(folder) / name) for name in ("LUCARNA_CACHE", "LUCARNA_CONFIG", "MESA_SHADER_CACHE_DIR")
        }
        environment = {**os.environ, **places}
        first = [_start(environment)]
        later = [_start(environment) for _ in range(2 if ctx.quick else 7)]
    for case, runs in (("first start", first), ("later starts", later)):
        for stage in ("window", "window_cpu", "picture", "picture_cpu"):
            note = GOALS.get(stage, "") if case == "later starts" else ""
            rows.append(Row(case, stage, summarise([1e3 * r[stage] for r in runs if stage in r]), note=note))
    return rows


def _start(environment: dict[str, str]) -> dict[str, float]:
    clock = f"import os, sys, time; os.execv(sys.executable, [sys.executable, {str(SCRIPT)!r}, str(time.time())])"
    command = on_display([sys.executable, "-c", clock])  # the display's own start does not count
    done = subprocess.run(command, check=True, capture_output=True, text=True, env=environment)
    found: dict[str, float] = json.loads([line for line in done.stdout.splitlines() if line.startswith("{")][-1])
    return found
