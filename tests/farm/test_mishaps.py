"""Runs that are killed, run side by side, or find no room: never a partial output, and the next run mends."""

from __future__ import annotations

import errno
import hashlib
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from engine.assets.lmesh import read_lmesh
from engine.assets.scene_json import read_scene
from importers.cache import scene_for
from importers.cli.main import main
from tests.support.gltf_builder import png, textured_triangle

COUNT = 8
Capture = pytest.CaptureFixture[str]


@pytest.fixture
def many(tmp_path: Path) -> Path:
    folder = tmp_path / "many"
    folder.mkdir()
    for number in range(COUNT):
        textured_triangle(png(32, 32, (number, 0, 0))).write_glb(folder / f"m{number}.glb")
    return folder


def command(source: Path, out: Path) -> list[str]:
    return [sys.executable, "-m", "importers.cli", "convert", str(source), "--out", str(out), "--jobs", "2", "--quiet"]


def start(source: Path, out: Path, **more: Any) -> subprocess.Popen[bytes]:
    root = str(Path(__file__).resolve().parents[2])
    quiet: dict[str, Any] = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    return subprocess.Popen(command(source, out), cwd=root, **quiet | more)


def visible(out: Path) -> list[Path]:
    return sorted(p for p in out.rglob("*") if p.is_file() and ".lucarna" not in p.parts)


def digests(out: Path) -> dict[str, str]:
    return {p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in visible(out)}


@pytest.mark.skipif(os.name != "posix", reason="signals")
def test_killed_at_any_moment(many: Path, tmp_path: Path, real_workers: None) -> None:
    assert start(many, tmp_path / "whole").wait() == 0
    expected = digests(tmp_path / "whole")
    assert len(expected) == COUNT * 5
    moments = random.Random(3)
    cut = 0
    for number in range(3):
        shutil.rmtree(os.environ["LUCARNA_CACHE"], ignore_errors=True)
        out = tmp_path / f"out{number}"
        run = start(many, out)
        time.sleep(moments.uniform(0.3, 1.0))
        run.kill()
        run.wait()
        found = digests(out)
        assert found.items() <= expected.items()  # every file that is there is whole
        cut += 0 < len(found) < len(expected)
        for path in visible(out):
            if path.name.endswith(".scene.json"):  # the last of its source: what it names is there
                for node in read_scene(path).nodes:
                    assert node.mesh is None or read_lmesh(out / node.mesh.file)
    assert start(many, tmp_path / "out0").wait() == 0
    assert digests(tmp_path / "out0") == expected
    left = [p.name for p in (tmp_path / "out0").rglob("*.tmp")] + [
        p.name for p in (Path(os.environ["LUCARNA_CACHE"]) / "converted").iterdir() if p.name.endswith(".tmp")
    ]
    assert not left


def test_two_processes_at_once(many: Path, tmp_path: Path, real_workers: None) -> None:
    runs = [start(many, tmp_path / "out") for _ in range(2)]
    assert [run.wait() for run in runs] == [0, 0]
    assert len(digests(tmp_path / "out")) == COUNT * 5
    assert len(list((Path(os.environ["LUCARNA_CACHE"]) / "converted").iterdir())) == COUNT
    again = subprocess.run([*command(many, tmp_path / "out")[:-1], "--verify"], cwd=Path(__file__).resolve().parents[2],
                           capture_output=True, text=True, check=True)  # fmt: skip
    assert f"nothing to do: {COUNT} up to date" in again.stdout


@pytest.mark.skipif(os.name != "posix", reason="signals")
def test_ctrl_c_leaves_nothing_half_done(many: Path, tmp_path: Path, real_workers: None) -> None:
    run = start(many, tmp_path / "out", start_new_session=True, stderr=subprocess.PIPE)
    time.sleep(0.6)
    run.send_signal(signal.SIGINT)
    _, errors = run.communicate(timeout=30)
    assert run.returncode in (0, 130)
    assert b"Traceback" not in errors
    assert not list((tmp_path / "out").rglob("*.tmp"))


@pytest.mark.parametrize("at", ["importers.farm.publish.os.fsync", "engine.core.atomic.os.fsync"])
def test_the_disk_is_full(
    many: Path, tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch, at: str
) -> None:
    left = [9]

    def fsync(handle: int) -> None:
        left[0] -= 1
        if left[0] < 0:
            raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(at, fsync)
        assert main(["convert", str(many), "--out", str(tmp_path / "out"), "--jobs", "1"]) == 3
    printed = capsys.readouterr()
    assert "No space left on device" in printed.err
    assert "Traceback" not in printed.err
    assert not list((tmp_path / "out").rglob("*.tmp"))
    scenes = [p for p in visible(tmp_path / "out") if p.name.endswith(".scene.json")]
    assert len(visible(tmp_path / "out")) == len(scenes) * 5  # of each source all or nothing
    assert "m0.glb" in printed.err or "m1" in printed.err
    assert main(["convert", str(many), "--out", str(tmp_path / "out")]) == 0
    assert len(visible(tmp_path / "out")) == COUNT * 5


@pytest.mark.skipif(not Path("/dev/shm").is_dir() or os.name != "posix", reason="needs a file system in memory")
def test_sources_that_vanish_or_cannot_be_read(many: Path, tmp_path: Path, capsys: Capture, monkeypatch: Any) -> None:
    from importers.farm import run as farm_run

    plain = farm_run.LocalWorkers.perform

    def vanish(self: Any, request: dict[str, Any], job: Any) -> Any:
        if job.name == "m3":
            job.source.unlink()
        return plain(self, request, job)

    monkeypatch.setattr(farm_run.LocalWorkers, "perform", vanish)
    (many / "dangling.glb").symlink_to(many / "nowhere.glb")
    assert main(["convert", str(many), "--out", str(tmp_path / "out")]) == 1
    printed = capsys.readouterr()
    assert "m3.glb: there is no such file" in printed.err
    assert "dangling.glb" in printed.err
    assert f"{COUNT - 1} converted, 2 failed" in printed.out


def test_an_output_folder_inside_the_sources(many: Path, capsys: Capture) -> None:
    for expected in (f"{COUNT} converted", "nothing to do"):
        assert main(["convert", str(many), "--out", str(many / "build")]) == 0
        assert expected in capsys.readouterr().out
    assert len(visible(many / "build")) == COUNT * 5


def test_opening_a_source_can_be_called_off(many: Path, real_workers: None) -> None:
    class Cancelled(Exception):
        pass

    def cancel(what: str, share: float) -> None:
        raise Cancelled

    with pytest.raises(Cancelled):
        scene_for(many / "m0.glb", progress=cancel)
    assert not list((Path(os.environ["LUCARNA_CACHE"]) / "converted").iterdir())
    assert scene_for(many / "m0.glb")[0].is_file()
