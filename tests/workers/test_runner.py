"""Workers that behave, and workers that crash, hang, eat memory, lie or leave nothing: one clear error each."""

from __future__ import annotations

import os
import sys
import textwrap
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from engine.core.errors import FormatError, InputError
from importers.workers import forker
from importers.workers.runner import WorkerLimits, run_in_worker

TASKS = """
import ctypes, os, sys, time
import numpy as np
from engine.core.errors import FormatError, InputError

def echo(request):
    return {"said": request["say"]}, {"a": np.arange(6, dtype="<f8").reshape(2, 3), "b": np.zeros((0, 3), np.uint32)}

calls = []

def count(request):
    calls.append(1)
    return {"calls": len(calls), "said": request["say"]}, {}

def crash(request):
    ctypes.string_at(0)

def hang(request):
    time.sleep(60)

def spin(request):
    while True: pass

def eat(request):
    keep = [bytearray(64 << 20) for _ in range(1000)]
    return {}, {}

def refuse(request):
    raise FormatError("bad magic", hint="export again")

def missing(request):
    raise InputError("is not there")

def bug(request):
    raise RuntimeError("a mistake in the reader")

def leave(request):
    os._exit(0)

def nan(request):
    return {"x": float("nan")}, {}

def orphan(request):
    open(request["file"], "w").write(str(os.getpid()))
    time.sleep(60)

def where(request):
    return {"folder": os.getcwd(), "path": sys.path}, {}
"""


@pytest.fixture
def tasks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    folder = tmp_path / "modules"
    folder.mkdir()
    (folder / "worker_tasks.py").write_text(textwrap.dedent(TASKS), encoding="utf-8")
    monkeypatch.setenv("PYTHONPATH", str(folder))
    return "worker_tasks"


FILE = Path("models/thing.fbx")


@pytest.fixture
def forking() -> Iterator[None]:
    """Children forked by a server, as warm workers on Linux have them."""
    if sys.platform != "linux":
        pytest.skip("forks on Linux only")
    forker.enable()
    yield
    server = forker._enabled.pop()
    server.close()


def test_forked_children_are_fresh_and_as_limited(tasks: str, forking: None) -> None:
    for word in ("one", "two"):
        assert run_in_worker(f"{tasks}:count", {"say": word}, FILE).data == {"calls": 1, "said": word}
    with pytest.raises(FormatError, match=r"the reader crashed \(SIGSEGV\)"):
        run_in_worker(f"{tasks}:crash", {}, FILE)
    with pytest.raises(FormatError, match=r"did not finish within 0\.5 s"):
        run_in_worker(f"{tasks}:hang", {}, FILE, WorkerLimits(seconds=0.5))
    with pytest.raises(FormatError, match="wanted more memory than its limit of 1 GiB"):
        run_in_worker(f"{tasks}:eat", {}, FILE, WorkerLimits(memory_bytes=1 << 30))
    with pytest.raises(FormatError, match="RuntimeError: a mistake in the reader"):
        run_in_worker(f"{tasks}:bug", {}, FILE)
    server = forker.forker()
    assert server is not None
    for process in server._servers.values():
        process.kill()
    assert run_in_worker(f"{tasks}:count", {"say": "again"}, FILE).data["calls"] == 1


def test_result_comes_back(tasks: str) -> None:
    result = run_in_worker(f"{tasks}:echo", {"say": "grüß"}, FILE)
    assert result.data == {"said": "grüß"}
    np.testing.assert_array_equal(result.arrays["a"], [[0, 1, 2], [3, 4, 5]])
    assert result.arrays["b"].shape == (0, 3)
    result.arrays["a"][0, 0] = 7.0  # the caller's own


@pytest.mark.skipif(os.name != "posix", reason="signals")
def test_crash(tasks: str) -> None:
    with pytest.raises(FormatError, match=r"thing\.fbx: the reader crashed \(SIGSEGV\)"):
        run_in_worker(f"{tasks}:crash", {}, FILE)


def test_hang(tasks: str) -> None:
    started = time.monotonic()
    with pytest.raises(FormatError, match=r"thing\.fbx: the reader did not finish within 1 s"):
        run_in_worker(f"{tasks}:hang", {}, FILE, WorkerLimits(seconds=1.0))
    assert time.monotonic() - started < 20


def test_busy_loop(tasks: str) -> None:
    with pytest.raises(FormatError, match="did not finish"):
        run_in_worker(f"{tasks}:spin", {}, FILE, WorkerLimits(seconds=1.0))


@pytest.mark.skipif(sys.platform != "linux", reason="the address space is limited on Linux")
def test_memory(tasks: str) -> None:
    with pytest.raises(FormatError, match=r"thing\.fbx: the reader wanted more memory than its limit of 1 GiB"):
        run_in_worker(f"{tasks}:eat", {}, FILE, WorkerLimits(memory_bytes=1 << 30))


def test_the_tasks_own_refusal(tasks: str) -> None:
    with pytest.raises(FormatError, match=r"thing\.fbx: bad magic \(export again\)"):
        run_in_worker(f"{tasks}:refuse", {}, FILE)
    with pytest.raises(InputError, match="is not there") as caught:
        run_in_worker(f"{tasks}:missing", {}, FILE)
    assert not isinstance(caught.value, FormatError)


def test_a_mistake_in_the_task(tasks: str) -> None:
    with pytest.raises(FormatError, match="RuntimeError: a mistake in the reader"):
        run_in_worker(f"{tasks}:bug", {}, FILE)
    with pytest.raises(FormatError, match="left no result"):
        run_in_worker(f"{tasks}:leave", {}, FILE)
    with pytest.raises(FormatError, match="ValueError"):
        run_in_worker(f"{tasks}:nan", {}, FILE)
    with pytest.raises(FormatError, match="AttributeError"):
        run_in_worker(f"{tasks}:no_such_task", {}, FILE)


def test_nothing_is_left_behind(tasks: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(scratch))
    run_in_worker(f"{tasks}:echo", {"say": ""}, FILE)
    with pytest.raises(FormatError):
        run_in_worker(f"{tasks}:refuse", {}, FILE)
    assert list(scratch.iterdir()) == []


def test_the_working_folder_is_no_place_to_import_from(
    tasks: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "assets"
    folder.mkdir()
    (folder / "numpy.py").write_text("raise RuntimeError('planted')", encoding="utf-8")
    monkeypatch.chdir(folder)
    result = run_in_worker(f"{tasks}:where", {}, FILE)
    assert str(folder) not in result.data["path"]
    assert "" not in result.data["path"]


@pytest.mark.skipif(os.name != "posix", reason="signals")
def test_a_worker_ends_with_its_parent(tasks: str, tmp_path: Path) -> None:
    import subprocess

    note = tmp_path / "pid"
    code = (
        "from pathlib import Path; from importers.workers.runner import run_in_worker; "
        f"run_in_worker('worker_tasks:orphan', {{'file': {str(note)!r}}}, Path('x'))"
    )
    root = Path(__file__).resolve().parents[2]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(root), os.environ["PYTHONPATH"]])}
    with subprocess.Popen([sys.executable, "-c", code], env=environment) as parent:
        deadline = time.monotonic() + 20
        while not (note.is_file() and note.read_text()) and time.monotonic() < deadline:
            time.sleep(0.05)
        worker = int(note.read_text())
        parent.kill()
    while time.monotonic() < deadline:
        try:
            state = Path(f"/proc/{worker}/stat").read_text(encoding="ascii").rsplit(")", 1)[1].split()[0]
        except (OSError, IndexError):
            return
        if state == "Z":  # dead; nobody is left to collect it
            return
        time.sleep(0.05)
    pytest.fail("the worker outlived its parent")
