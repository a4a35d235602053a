"""CPU time of the editor's own frames over 10,000 nodes, with tree, inspector and history open (a process of its own:
imgui has one state per process). The fake engine draws nothing: what is left is the window's work."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

from engine.report.summary import summarise
from tests.bench.harness import Context, Row

SCRIPT = Path(__file__).resolve().parents[1] / "editor" / "support" / "frame_times.py"
NODES = 10_000
GOALS = {"at rest": "goal 3 ms", "one node dragged": "goal 3 ms", "another node selected": "goal 3 ms"}


def run(ctx: Context) -> list[Row]:
    frames = 20 if ctx.quick else 100
    done = subprocess.run(
        [sys.executable, str(SCRIPT), str(NODES), str(frames)], check=True, capture_output=True, text=True
    )
    found = json.loads([line for line in done.stdout.splitlines() if line.startswith("{")][-1])
    case = f"{NODES:,} nodes, 1,000 edits"
    return [Row(case, stage, summarise(ms), note=GOALS.get(stage, "")) for stage, ms in found.items()]
