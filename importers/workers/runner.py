"""The host's side: start a worker, wait for it within its limits, and read what it left behind."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.assets.container import read_container
from engine.core.errors import FormatError, InputError, LucarnaError, OutputError, Place

SCHEMA = "lucarna.worker/1"
REQUEST, RESULT, FAILURE, LOG = "request.json", "result.bin", "failure.json", "log.txt"


@dataclass(frozen=True, slots=True)
class WorkerLimits:
    """`seconds` of wall-clock time; `memory_bytes` of address space (0 = none; not enforced on Windows)."""

    seconds: float = 300.0
    memory_bytes: int = 4 << 30


@dataclass(slots=True)
class WorkerResult:
    """`data`: JSON; `arrays`: by the names that `data` uses, in memory of their own."""

    data: dict[str, Any]
    arrays: dict[str, NDArray[Any]]


def run_in_worker(
    task: str, request: dict[str, Any], where: Path, limits: WorkerLimits | None = None, what: str = "the reader"
) -> WorkerResult:
    """Call `task` ("package.module:function") with `request` (JSON) in a new process.

    The function returns (JSON object, {name: array}). `where`: the file it is about; `what`: how errors call the task.
    Raises FormatError, naming the file, when the worker crashes, runs out of time or memory, or leaves no result; and
    whatever InputError the task raised itself.
    """
    limits = limits or WorkerLimits()
    try:
        folder = Path(tempfile.mkdtemp(prefix="lucarna-worker-"))
    except OSError as error:
        raise OutputError(f"cannot make a temporary folder: {error.strerror or error}") from error
    try:
        order = {"task": task, "request": request, "seconds": limits.seconds, "memory_bytes": limits.memory_bytes}
        (folder / REQUEST).write_text(json.dumps(order), encoding="utf-8")
        code = _wait(folder, where, limits, what)
        failure = folder / FAILURE
        if failure.is_file():
            raise _failure(failure, where, limits, what)
        if code != 0 or not (folder / RESULT).is_file():
            raise FormatError(
                f"{what} {_ending(code)}; the file is damaged, or made to do harm", where=where,
                hint="export the file again" + _last_words(folder / LOG),
            )  # fmt: skip
        data, arrays = read_container(folder / RESULT, SCHEMA)
        # copied, so that the mapped file can be deleted on every system
        return WorkerResult(data["data"], {name: np.array(array) for name, array in arrays.items()})
    except OSError as error:
        raise OutputError(f"cannot use the temporary folder: {error.strerror or error}", where=folder) from error
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _wait(folder: Path, where: Path, limits: WorkerLimits, what: str) -> int:
    environment = dict(os.environ)
    packages = str(Path(__file__).resolve().parents[2])
    environment["PYTHONPATH"] = os.pathsep.join(p for p in (packages, environment.get("PYTHONPATH")) if p)
    # thread pools of numerical libraries reserve address space for each processor
    environment |= {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    # -P: never import from the working directory, which may be a folder of downloaded assets
    command = [sys.executable, "-P", "-m", "importers.workers.child", str(folder)]
    with (folder / LOG).open("wb") as log:
        process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=log,
            stderr=log,
            env=environment,
            start_new_session=os.name == "posix",
        )
        try:
            return process.wait(limits.seconds)
        except subprocess.TimeoutExpired:
            raise FormatError(
                f"{what} did not finish within {limits.seconds:g} s and was stopped", where=where,
                hint="the file is damaged, or too large: raise the worker's time limit",
            ) from None  # fmt: skip
        finally:
            # also on KeyboardInterrupt; the worker ends by itself when this pipe closes
            if process.poll() is None:
                process.kill()
                process.wait()
            if process.stdin is not None:
                process.stdin.close()


def _failure(path: Path, where: Path, limits: WorkerLimits, what: str) -> LucarnaError:
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
        kind, message, hint, place = (str(data[key]) for key in ("kind", "message", "hint", "path"))
    except (OSError, ValueError, KeyError, TypeError):
        return FormatError(f"{what} failed without saying why", where=where)
    if kind == "memory":
        size = f"{limits.memory_bytes / 2**30:.3g} GiB" if limits.memory_bytes else "the machine has"
        return FormatError(
            f"{what} wanted more memory than its limit of {size}", where=where,
            hint="the file is damaged, or too large: raise the worker's memory limit",
        )  # fmt: skip
    error = InputError if kind == "input" else FormatError
    return error(message, where=Place(str(where), path=place), hint=hint)


def _ending(code: int) -> str:
    if code < 0:
        try:
            name = signal.Signals(-code).name
        except ValueError:
            name = f"signal {-code}"
        if name == "SIGXCPU":
            return "used up its processor time"
        return f"crashed ({name})"
    if os.name == "nt" and code & 0xC0000000 == 0xC0000000:
        return f"crashed (0x{code:08X})"
    return f"ended with code {code} and left no result"


def _last_words(log: Path) -> str:
    """The last line that the worker printed, for bug reports."""
    try:
        lines = log.read_text(encoding="utf-8", errors="replace").strip().splitlines()
    except OSError:
        return ""
    return f"; its last words: {lines[-1][:200]}" if lines else ""
