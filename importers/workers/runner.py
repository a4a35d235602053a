"""The host's side: start a worker, wait for it within its limits, and read what it left behind."""

from __future__ import annotations

import json
import os
import shutil
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
from importers.workers.forker import forker
from importers.workers.process import WorkerLimits, environment, last_line, memory_text, spell_ending

SCHEMA = "lucarna.worker/1"
REQUEST, RESULT, FAILURE, LOG = "request.json", "result.bin", "failure.json", "log.txt"


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
        code = _fork(task, folder, where, limits, what)
        if code is None:
            code = _wait(folder, where, limits, what)
        failure = folder / FAILURE
        if failure.is_file():
            raise _failure(failure, where, limits, what)
        if code != 0 or not (folder / RESULT).is_file():
            raise FormatError(
                f"{what} {spell_ending(code)}; the file is damaged, or made to do harm", where=where,
                hint="export the file again" + _last_words(folder / LOG),
            )  # fmt: skip
        data, arrays = read_container(folder / RESULT, SCHEMA)
        # copied, so that the mapped file can be deleted on every system
        return WorkerResult(data["data"], {name: np.array(array) for name, array in arrays.items()})
    except OSError as error:
        raise OutputError(f"cannot use the temporary folder: {error.strerror or error}", where=folder) from error
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _fork(task: str, folder: Path, where: Path, limits: WorkerLimits, what: str) -> int | None:
    """The exit code of a forked child; None where this process has no fork server (see forker)."""
    server = forker()
    if server is None:
        return None
    try:
        code = server.run(task.split(":")[0], folder, limits.seconds)
    except OSError:
        return None
    if code is None:
        raise _too_slow(where, limits, what)
    return code


def _wait(folder: Path, where: Path, limits: WorkerLimits, what: str) -> int:
    # -P: never import from the working directory, which may be a folder of downloaded assets
    command = [sys.executable, "-P", "-m", "importers.workers.child", str(folder)]
    with (folder / LOG).open("wb") as log:
        process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=log,
            stderr=log,
            env=environment(),
            start_new_session=os.name == "posix",
        )
        try:
            return process.wait(limits.seconds)
        except subprocess.TimeoutExpired:
            raise _too_slow(where, limits, what) from None
        finally:
            # also on KeyboardInterrupt; the worker ends by itself when this pipe closes
            if process.poll() is None:
                process.kill()
                process.wait()
            if process.stdin is not None:
                process.stdin.close()


def _too_slow(where: Path, limits: WorkerLimits, what: str) -> FormatError:
    return FormatError(
        f"{what} did not finish within {limits.seconds:g} s and was stopped", where=where,
        hint="the file is damaged, or too large: raise --max-worker-seconds",
    )  # fmt: skip


def _failure(path: Path, where: Path, limits: WorkerLimits, what: str) -> LucarnaError:
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
        kind, message, hint, place = (str(data[key]) for key in ("kind", "message", "hint", "path"))
    except (OSError, ValueError, KeyError, TypeError):
        return FormatError(f"{what} failed without saying why", where=where)
    if kind == "memory":
        return FormatError(
            f"{what} wanted more memory than its limit of {memory_text(limits)}", where=where,
            hint="the file is damaged, or too large: raise --max-worker-bytes",
        )  # fmt: skip
    error = InputError if kind == "input" else FormatError
    return error(message, where=Place(str(where), path=place), hint=hint)


def _last_words(log: Path) -> str:
    """The last line that the worker printed, for bug reports."""
    try:
        words = last_line(log.read_bytes())
    except OSError:
        return ""
    return f"; its last words: {words}" if words else ""
