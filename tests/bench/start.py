"""Start-up, whole processes: the CLI's help, and a picture of a small converted scene."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

from engine.assets.lmesh import write_lmesh
from engine.assets.primitives import cube
from engine.assets.scene import MeshRef, NodeAsset, SceneAsset
from engine.assets.scene_json import write_scene
from tests.bench.harness import Context, Row


def run(ctx: Context) -> list[Row]:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_lmesh(folder / "cube.lmesh", [cube()], {})
        write_scene(folder / "cube.scene.json", SceneAsset("cube", [NodeAsset("cube", mesh=MeshRef("cube.lmesh", 0))]))
        command = [sys.executable, "-m", "importers.cli"]
        picture = ["render", str(folder / "cube.scene.json"), "--out", str(folder / "a.png")]
        few = Context(quick=True)
        return [
            few.measure("lucarna --help", "wall", lambda: _run([*command, "--help"]), note="goal 300 ms"),
            few.measure("lucarna render, 1280x720", "wall", lambda: _run([*command, *picture]), note="goal 2,000 ms"),
        ]


def _run(command: list[str]) -> None:
    subprocess.run(command, check=True, capture_output=True)
