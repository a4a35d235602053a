"""Past one machine: a cache on a URL, and a Dask cluster of which a worker is killed."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from importers.cli.main import main
from tests.support.gltf_builder import png, textured_triangle

pytest.importorskip("fsspec")
Capture = pytest.CaptureFixture[str]


def digests(out: Path) -> dict[str, str]:
    files = [p for p in sorted(out.rglob("*")) if p.is_file() and ".lucarna" not in p.parts]
    return {p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in files}


def test_another_machine_takes_it_from_the_shared_cache(
    depot: Path, tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    url = (tmp_path / "shared").as_uri()

    def on(machine: str) -> str:
        monkeypatch.setenv("LUCARNA_CACHE", str(tmp_path / machine))
        assert main(["convert", str(depot), "--out", str(tmp_path / f"out-{machine}"), "--cache", url]) == 0
        return capsys.readouterr().out

    assert "3 converted" in on("a")
    archives = sorted((tmp_path / "shared").glob("*"))
    assert [p.suffix for p in archives] == [".zip"] * 3
    assert "3 from the cache" in on("b")
    assert digests(tmp_path / "out-a") == digests(tmp_path / "out-b")
    data = bytearray(archives[0].read_bytes())
    data[200] ^= 1
    archives[0].write_bytes(data)
    archives[1].write_bytes(b"no archive")
    assert "2 converted, 1 from the cache" in on("c")
    assert digests(tmp_path / "out-a") == digests(tmp_path / "out-c")


def test_a_cache_that_cannot_be(depot: Path, tmp_path: Path, capsys: Capture) -> None:
    assert main(["convert", str(depot), "--out", str(tmp_path / "out"), "--cache", "nonsense://x"]) != 0
    assert "nonsense" in capsys.readouterr().err


@pytest.mark.skipif(os.name != "posix", reason="kills by signal")
def test_a_dask_cluster_with_a_worker_killed(tmp_path: Path, real_workers: None) -> None:
    pytest.importorskip("distributed")
    many = tmp_path / "many"
    many.mkdir()
    for number in range(14):
        textured_triangle(png(160, 160, (number, 1, 2))).write_glb(many / f"m{number}.glb")
    root, address = Path(__file__).resolve().parents[2], tmp_path / "scheduler.json"

    def start(module: str, cache: str, *words: str) -> subprocess.Popen[bytes]:
        environment = os.environ | {"LUCARNA_CACHE": str(tmp_path / cache), "PYTHONPATH": str(root)}
        with (tmp_path / f"{cache}.log").open("wb") as log:
            return subprocess.Popen([sys.executable, "-m", module, *words], env=environment, stdout=log, stderr=log)

    def convert(out: str, cache: str, *words: str) -> subprocess.Popen[bytes]:
        return start("importers.cli", cache, "convert", str(many), "--out", str(tmp_path / out), *words)

    running = [start("distributed.cli.dask_scheduler", "s", "--port", "0", "--no-dashboard", "--host", "127.0.0.1",
                     "--scheduler-file", str(address))]  # fmt: skip
    try:
        for name in ("w1", "w2"):
            running.append(start("distributed.cli.dask_worker", name, "--nthreads", "1", "--no-nanny", "--no-dashboard",
                                 "--scheduler-file", str(address)))  # fmt: skip
        deadline = time.monotonic() + 60
        while not all(b"Registered to" in (tmp_path / f"{w}.log").read_bytes() for w in ("w1", "w2")):
            assert time.monotonic() < deadline, "the cluster does not start"
            time.sleep(0.1)
        import json

        tcp = json.loads(address.read_text())["address"]
        run = convert("far", "host", "--scheduler", tcp)
        while len(list((tmp_path / "far").rglob("*.scene.json"))) < 2:
            assert run.poll() is None
            assert time.monotonic() < deadline
            time.sleep(0.02)
        running[1].kill()
        made = len(list((tmp_path / "far").rglob("*.scene.json")))
        assert run.wait(90) == 0, (tmp_path / "host.log").read_text()
        assert made < 14, "the worker was killed when all was done"
    finally:
        for process in reversed(running):
            process.kill()
            process.wait()
    assert convert("near", "alone", "--jobs", "2").wait(90) == 0
    assert len(digests(tmp_path / "near")) == 14 * 5
    assert digests(tmp_path / "far") == digests(tmp_path / "near")
