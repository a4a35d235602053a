"""UI tests of animation: real clicks and drags on imgui's null platform, each reported by its name.

The script runs once, in a process of its own: a second null platform in one process fails."""

from __future__ import annotations

import ast
import json
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parent / "ui" / "animation_ui.py"


def names() -> list[str]:
    """The functions in the script's TESTS, without importing imgui here."""
    for node in ast.parse(SCRIPT.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") == "TESTS":
            return [n.id for n in ast.walk(node.value) if isinstance(n, ast.Name) and n.id not in {"f"}]
    raise AssertionError(f"{SCRIPT} has no TESTS")


@pytest.fixture(scope="module")
def results() -> dict[str, str]:
    done = subprocess.run(
        [sys.executable, str(SCRIPT)], capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip
    lines = [line for line in done.stdout.splitlines() if line.startswith("{")]
    assert lines, f"the UI tests did not finish (exit {done.returncode}):\n{done.stdout[-2000:]}\n{done.stderr[-4000:]}"
    found: dict[str, str] = json.loads(lines[-1])
    return found


@pytest.mark.parametrize("name", names())
def test_ui(results: dict[str, str], name: str) -> None:
    assert name in results, "the test did not run"
    assert not results[name], results[name]
