"""Warm workers: processes that do one task after another, and are replaced when they crash, hang, grow or get old.

    pool.run(task, request, where, limits)  ─ a JSON line ─>  importers.workers.server  ─ JSON lines ─> the result

A crash, a hang or a lack of memory costs the one task: it raises, and the next one gets a new process. Processes are
started when they are first needed, by command line alone, so that every system can.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import IO, Any

from engine.core.errors import FormatError, InputError, LucarnaError, OutputError, Place
from importers.workers.process import WorkerLimits, environment, last_line, memory_text, spell_ending

Progress = Callable[[str, float], None]

#: tasks after which a process is replaced: native libraries leak
RECYCLE_AFTER = 100
#: resident memory after a task beyond which a process is replaced
RECYCLE_BYTES = 1 << 30


class _Worker:
    """One process and its pipes."""

    def __init__(self) -> None:
        self.tasks = 0
        self.resident = 0
        self.stopped = False
        self._log: IO[bytes] = tempfile.TemporaryFile(prefix="lucarna-worker-")  # noqa: SIM115  (it lives as long as the process)
        # -P: never import from the working directory, which may be a folder of downloaded assets
        self._process = subprocess.Popen(
            [sys.executable, "-P", "-m", "importers.workers.server"],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._log, env=environment(),
            start_new_session=os.name == "posix", creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),
        )  # fmt: skip

    def ask(self, order: dict[str, Any], seconds: float, progress: Progress | None) -> dict[str, Any] | None:
        """The answer to `order`; None when the process ended or had to be stopped."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self.tasks += 1
        clock = threading.Timer(seconds, self.stop)
        clock.start()
        try:
            self._process.stdin.write(json.dumps(order).encode("ascii") + b"\n")
            self._process.stdin.flush()
            while line := self._process.stdout.readline():
                reply: dict[str, Any] = json.loads(line)
                if "progress" not in reply:
                    self.resident = int(reply["resident"])
                    return reply
                if progress is not None:
                    progress(*reply["progress"])
            return None
        except (BrokenPipeError, ConnectionError, ValueError):
            return None
        finally:
            clock.cancel()

    def stop(self) -> None:
        self.stopped = True
        self._process.kill()

    def close(self) -> int:
        """End the process if it has not; its exit code."""
        if self._process.poll() is None:
            if self._process.stdin is not None and not self.stopped:
                try:
                    self._process.stdin.close()
                    self._process.wait(0.5)
                except (OSError, subprocess.TimeoutExpired):
                    pass
            self._process.kill()
        code = self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                try:
                    pipe.close()
                except OSError:
                    continue  # what was left to write has no reader any more
        return code

    def last_words(self) -> str:
        self._log.seek(0)
        return last_line(self._log.read(1 << 20))

    def forget(self) -> None:
        self._log.close()


class WorkerPool:
    """At most `size` worker processes. Threads may share it; use it as a context manager, or call `close`."""

    def __init__(self, size: int, *, recycle_after: int = RECYCLE_AFTER, recycle_bytes: int = RECYCLE_BYTES) -> None:
        self.size = max(1, size)
        self.started = 0
        self._recycle = recycle_after, recycle_bytes
        self._free = threading.Semaphore(self.size)
        self._lock = threading.Lock()
        self._idle: list[_Worker] = []
        self._busy: set[_Worker] = set()
        self._closed = False

    def __enter__(self) -> WorkerPool:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def run(
        self, task: str, request: dict[str, Any], where: Path, limits: WorkerLimits | None = None,
        what: str = "the importer", progress: Progress | None = None,
    ) -> dict[str, Any]:  # fmt: skip
        """Call `task` ("package.module:function") with (request, progress) in a worker, and return its JSON.

        Waits for a free process. `where`: the file it is about. Raises FormatError, naming the file, when the worker
        crashes or runs out of time or memory, and whatever LucarnaError the task raised. What `progress` raises
        (a cancel) stops the work and goes through.
        """
        limits = limits or WorkerLimits()
        order = {"task": task, "request": request, "seconds": limits.seconds, "memory_bytes": limits.memory_bytes}
        worker = self._take()
        reply: dict[str, Any] | None = None
        started = time.monotonic()
        try:
            reply = worker.ask(order, limits.seconds, progress)
        finally:
            if reply is None or ("failure" in reply and reply["failure"]["kind"] in ("memory", "bug")):
                code = self._drop(worker)
                words = worker.last_words()
                worker.forget()
            else:
                self._give_back(worker)
        if reply is None:
            if worker.stopped and time.monotonic() - started >= limits.seconds:
                raise FormatError(
                    f"{what} did not finish within {limits.seconds:g} s and was stopped", where=where,
                    hint="the file is damaged, or too large: raise --max-worker-seconds",
                )  # fmt: skip
            if self._closed:
                raise LucarnaError("stopped", where=where)
            raise FormatError(
                f"{what} {spell_ending(code)}; the file is damaged, or made to do harm", where=where,
                hint="export the file again" + (f"; its last words: {words}" if words else ""),
            )  # fmt: skip
        if "failure" in reply:
            raise _error(reply["failure"], where, limits, what)
        data: dict[str, Any] = reply["data"]
        return data

    def close(self) -> None:
        """End all processes, also those at work: their tasks raise. The pool starts no more."""
        with self._lock:
            self._closed = True
            idle, self._idle = self._idle, []
            busy = list(self._busy)
        for worker in busy:
            worker.stop()
        for worker in idle:
            worker.close()
            worker.forget()

    def _take(self) -> _Worker:
        self._free.acquire()
        with self._lock:
            if self._closed:
                self._free.release()
                raise LucarnaError("the workers were stopped")
            try:
                worker = self._idle.pop() if self._idle else self._start()
            except OSError as error:
                self._free.release()
                raise OutputError(f"cannot start a worker process: {error.strerror or error}") from error
            self._busy.add(worker)
        return worker

    def _start(self) -> _Worker:
        self.started += 1
        return _Worker()

    def _drop(self, worker: _Worker) -> int:
        with self._lock:
            self._busy.discard(worker)
        code = worker.close()
        self._free.release()
        return code

    def _give_back(self, worker: _Worker) -> None:
        count, size = self._recycle
        old = worker.tasks >= count or worker.resident > size
        with self._lock:
            self._busy.discard(worker)
            keep = not old and not self._closed
            if keep:
                self._idle.append(worker)
        if not keep:
            worker.close()
            worker.forget()
        self._free.release()


def _error(failure: dict[str, Any], where: Path, limits: WorkerLimits, what: str) -> LucarnaError:
    kind, message, hint = failure["kind"], str(failure["message"]), str(failure["hint"])
    if kind == "memory":
        return FormatError(
            f"{what} wanted more memory than its limit of {memory_text(limits)}", where=where,
            hint="the file is damaged, or too large: raise --max-worker-bytes",
        )  # fmt: skip
    if kind == "bug":
        return FormatError(f"{what} failed: {message}", where=where, hint="please report this file")
    tree = {"format": FormatError, "input": InputError, "output": OutputError}.get(kind, LucarnaError)
    return tree(message, where=Place(failure["file"] or str(where), path=failure["path"]), hint=hint)


def in_process(task: str, request: dict[str, Any], progress: Progress | None = None) -> dict[str, Any]:
    """The same call in this process: for looking into an importer with a debugger. A crash ends everything."""
    import importlib

    module, function = task.split(":")
    order = request | {"threads": True}
    data: dict[str, Any] = getattr(importlib.import_module(module), function)(order, progress or _silent)
    return data


def _silent(what: str, share: float) -> None:
    """No progress is wanted."""
