"""The whole check, as CI runs it: `python3 packaging/test.py [pytest's arguments]`.

Format, lint, types, layers, tests, in this order; all of them run even if one fails. The exit code is 1 if any failed.
The tests run on the software rasteriser and, where there is no display, on a virtual one; the files of tests are shared
out to one process per core (`-n 0`: none, to see what a test prints as it prints it).
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import _interpreter  # first of ours: leaves when this Python is too old
import bootstrap

#: the software rasteriser uses all cores for each picture: more processes than this only wait for one another
MAX_PROCESSES = 4
VIRTUAL_DISPLAY = ["xvfb-run", "-a", "-s", "-screen 0 1400x900x24"]


@dataclass(frozen=True, slots=True)
class Step:
    name: str
    command: list[str]


@dataclass(frozen=True, slots=True)
class Outcome:
    name: str
    code: int
    seconds: float


def steps(setup: bootstrap.Setup, pytest_arguments: Sequence[str], *, virtual_display: bool) -> list[Step]:
    python = str(setup.python)
    return [
        Step("format", [python, "-m", "ruff", "format", "--check"]),
        Step("lint", [python, "-m", "ruff", "check"]),
        Step("types", [python, "-m", "mypy"]),
        Step("layers", [setup.script("lint-imports")]),
        Step(
            "tests",
            [*(VIRTUAL_DISPLAY if virtual_display else []), python, "-m", "pytest", *side_by_side(), *pytest_arguments],
        ),
    ]


def side_by_side() -> list[str]:
    """A file's tests stay in one process, because they share what is slow to make."""
    return ["-n", str(min(os.cpu_count() or 1, MAX_PROCESSES)), "--dist", "loadfile"]


def wants_virtual_display(environment: Mapping[str, str]) -> bool:
    return sys.platform.startswith("linux") and not environment.get("DISPLAY") and bool(shutil.which("xvfb-run"))


def test_environment(environment: Mapping[str, str]) -> dict[str, str]:
    """Software rendering, so that every machine compares the same pictures, with compiled shaders kept between runs.
    What the caller has set stays."""
    defaults = {
        "LIBGL_ALWAYS_SOFTWARE": "1",
        "MESA_SHADER_CACHE_DIR": str(bootstrap.ROOT / ".cache" / "mesa"),
        "PYTHONUTF8": "1",
    }
    return {**defaults, **environment}


def run(step: Step, environment: Mapping[str, str]) -> Outcome:
    print(f"\n== {step.name}: {' '.join(step.command)}", flush=True)
    start = time.monotonic()
    try:
        code = subprocess.run(step.command, cwd=bootstrap.ROOT, env=dict(environment), check=False).returncode
    except OSError as error:
        print(f"cannot start: {error}", file=sys.stderr)
        code = 127
    return Outcome(step.name, code, time.monotonic() - start)


def summary(outcomes: Sequence[Outcome]) -> str:
    lines = [f"{'step':<8} {'result':<12} {'seconds':>7}"]
    for outcome in outcomes:
        result = "ok" if outcome.code == 0 else f"FAILED ({outcome.code})"
        lines.append(f"{outcome.name:<8} {result:<12} {outcome.seconds:>7.1f}")
    return "\n".join(lines)


def main(arguments: list[str]) -> int:
    _interpreter.require()
    try:
        setup = bootstrap.prepare(extras=("dev",), tests=True)
    except bootstrap.SetupError as error:
        bootstrap.say(str(error))
        return 3
    environment = test_environment(os.environ)
    # Mesa makes no parents of its folder: without them it would keep nothing, and compile each shader again and again
    Path(environment["MESA_SHADER_CACHE_DIR"]).mkdir(parents=True, exist_ok=True)
    todo = steps(setup, arguments, virtual_display=wants_virtual_display(environment))
    outcomes = [run(step, environment) for step in todo]
    print("\n" + summary(outcomes), flush=True)
    return 1 if any(outcome.code for outcome in outcomes) else 0


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except KeyboardInterrupt:
        sys.exit(130)
