"""Warm workers: reused while they behave, replaced when they do not; each mishap costs the one task."""

from __future__ import annotations

import os
import sys
import textwrap
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from engine.core.errors import FormatError, InputError, LucarnaError, OutputError
from importers.workers.pool import WorkerPool
from importers.workers.process import WorkerLimits

TASKS = """
import ctypes, os, time
from engine.core.errors import InputError, OutputError, Place

def who(request, progress):
    print("a library chatters")
    os.write(1, b"in C, too")
    progress("half", 0.5)
    return {"pid": os.getpid(), "said": request.get("say", "")}

def crash(request, progress):
    ctypes.string_at(0)

def hang(request, progress):
    progress("hanging", 0.1)
    time.sleep(60)

def eat(request, progress):
    return {"size": sum(len(bytearray(64 << 20)) for _ in range(2)), "keep": [bytearray(64 << 20) for _ in range(50)]}

def refuse(request, progress):
    raise InputError("is not there", where=Place("other.bin", path="buffers[0]"), hint="look for it")

def full(request, progress):
    raise OutputError("no space")

def bug(request, progress):
    raise RuntimeError("a mistake in the reader")
"""
FILE = Path("models/thing.glb")


@pytest.fixture(scope="module")
def pool(tmp_path_factory: pytest.TempPathFactory) -> Iterator[WorkerPool]:
    folder = tmp_path_factory.mktemp("modules")
    (folder / "pool_tasks.py").write_text(textwrap.dedent(TASKS), encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch, WorkerPool(1) as pool:
        patch.setenv("PYTHONPATH", str(folder))
        yield pool


def ask(pool: WorkerPool, task: str, limits: WorkerLimits | None = None, **request: Any) -> dict[str, Any]:
    return pool.run(f"pool_tasks:{task}", request, FILE, limits)


def test_a_process_is_reused_and_tells_its_progress(pool: WorkerPool) -> None:
    heard: list[tuple[str, float]] = []
    first = pool.run("pool_tasks:who", {"say": "grüß"}, FILE, progress=lambda what, share: heard.append((what, share)))
    assert first["said"] == "grüß"
    assert heard == [("half", 0.5)]
    assert ask(pool, "who")["pid"] == first["pid"]


@pytest.mark.skipif(os.name != "posix", reason="signals")
def test_a_crash_costs_one_task(pool: WorkerPool) -> None:
    before = ask(pool, "who")["pid"]
    with pytest.raises(FormatError, match=r"thing\.glb: the importer crashed \(SIGSEGV\)"):
        ask(pool, "crash")
    assert ask(pool, "who")["pid"] != before


def test_a_hang_costs_its_time(pool: WorkerPool) -> None:
    with pytest.raises(FormatError, match=r"did not finish within 0\.5 s"):
        ask(pool, "hang", WorkerLimits(seconds=0.5))


@pytest.mark.skipif(sys.platform != "linux", reason="the address space is limited on Linux")
def test_memory(pool: WorkerPool) -> None:
    with pytest.raises(FormatError, match=r"wanted more memory than its limit of 1 GiB"):
        ask(pool, "eat", WorkerLimits(memory_bytes=1 << 30))


def test_errors_come_back_as_they_were(pool: WorkerPool) -> None:
    before = ask(pool, "who")["pid"]
    with pytest.raises(InputError, match=r"other\.bin: buffers\[0\]: is not there \(look for it\)"):
        ask(pool, "refuse")
    with pytest.raises(OutputError, match="no space"):
        ask(pool, "full")
    assert ask(pool, "who")["pid"] == before
    with pytest.raises(FormatError, match="RuntimeError: a mistake in the reader"):
        ask(pool, "bug")


def test_a_cancel_stops_the_work(pool: WorkerPool) -> None:
    class Cancelled(Exception):
        pass

    def cancel(what: str, share: float) -> None:
        raise Cancelled

    started = time.monotonic()
    with pytest.raises(Cancelled):
        pool.run("pool_tasks:hang", {}, FILE, progress=cancel)
    assert time.monotonic() - started < 30


def test_old_processes_are_replaced(pool: WorkerPool) -> None:
    with WorkerPool(1, recycle_after=2) as other:
        found = [ask(other, "who")["pid"] for _ in range(4)]
    assert found[0] == found[1] != found[2] == found[3]
    if sys.platform == "linux":
        with WorkerPool(1, recycle_bytes=1) as other:
            assert len({ask(other, "who")["pid"] for _ in range(2)}) == 2


def test_closing_stops_what_is_at_work(pool: WorkerPool) -> None:
    other = WorkerPool(1)
    caught: list[BaseException] = []

    def work() -> None:
        try:
            ask(other, "hang")
        except LucarnaError as error:
            caught.append(error)

    thread = threading.Thread(target=work)
    thread.start()
    while not other._busy:
        time.sleep(0.01)
    time.sleep(0.1)
    other.close()
    thread.join(20)
    assert not thread.is_alive()
    assert len(caught) == 1
    with pytest.raises(LucarnaError, match="stopped"):
        ask(other, "who")
