"""Runs the editor's UI scripts (tests/editor/ui), each in a process of its own: imgui has one state per process.

A script's last line of output that begins with "{" is what it saw, as JSON.
"""

from __future__ import annotations

import ast
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

FOLDER = Path(__file__).resolve().parents[1] / "editor" / "ui"
TIMEOUT = 300


def names(script: str) -> list[str]:
    """The functions in the script's TESTS, without importing imgui here."""
    for node in ast.parse((FOLDER / script).read_text(encoding="utf-8")).body:
        if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") == "TESTS":
            return [n.id for n in ast.walk(node.value) if isinstance(n, ast.Name) and n.id not in {"f"}]
    raise AssertionError(f"{script} has no TESTS")


def run(script: str) -> dict[str, str]:
    """Test -> what went wrong, '' for nothing, on imgui's null platform."""
    return _run([sys.executable, str(FOLDER / script)], None)[1]


def run_in_window(script: str, folder: Path, *arguments: str) -> tuple[int, dict[str, Any]]:
    """(exit code, what the script saw) in a real window, with its cache and preferences in `folder`. A virtual display
    where there is none; skips where there is neither."""
    command = on_display([sys.executable, str(FOLDER / script), str(folder), *arguments])
    places = {"LUCARNA_CACHE": str(folder / "cache"), "LUCARNA_CONFIG": str(folder / "config")}
    code, seen = _run(command, {**os.environ, **places})
    assert not seen["error"], seen["error"]
    return code, seen


def on_display(command: list[str]) -> list[str]:
    """`command`, under a virtual display where there is none; skips where there is neither."""
    if sys.platform != "linux" or os.environ.get("DISPLAY"):
        return command
    xvfb = shutil.which("xvfb-run")
    if xvfb is None:
        pytest.skip("no display, and no xvfb-run to make one")
    return [xvfb, "-a", "-s", "-screen 0 1600x1000x24", *command]


def _run(command: list[str], environment: dict[str, str] | None) -> tuple[int, dict[str, Any]]:
    done = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT, check=False, env=environment)
    lines = [line for line in done.stdout.splitlines() if line.startswith("{")]
    assert lines, f"it did not finish (exit {done.returncode}):\n{done.stdout[-2000:]}\n{done.stderr[-4000:]}"
    found: dict[str, Any] = json.loads(lines[-1])
    return done.returncode, found
