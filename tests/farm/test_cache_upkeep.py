"""`lucarna cache info|prune`, and a cache that several use at once."""

from __future__ import annotations

import json
import os
import threading
from pathlib import Path

import pytest

from engine.core.errors import UsageError
from importers.cache import RECORD, scene_for
from importers.cache_upkeep import parse_age, parse_size, prune
from importers.cli.main import main
from importers.farm.publish import EntryLost, publish
from tests.support.gltf_builder import triangle

Capture = pytest.CaptureFixture[str]


def fill(folder: Path, count: int) -> list[Path]:
    """So many converted sources, used 100, 90, 80 … hours ago; returns their folders, the oldest first."""
    found = []
    for number in range(count):
        scene, _ = scene_for(triangle([[0, 0, 0], [number + 1, 0, 0], [0, 1, 0]]).write_glb(folder / f"t{number}.glb"))
        found.append(scene.parent)
        moment = 1_000_000_000 + number * 36_000
        os.utime(scene.parent / RECORD, (moment, moment))
    return found


def test_the_least_recently_used_go_first(tmp_path: Path, capsys: Capture) -> None:
    folders = fill(tmp_path, 4)
    assert main(["cache", "info", "--json"]) == 0
    info = json.loads(capsys.readouterr().out)
    assert info["parts"]["converted"]["entries"] == 4
    size = sum(p.stat().st_size for p in folders[0].iterdir())
    now = 1_000_000_000 + 3 * 36_000
    assert [kept.path for kept in prune(older_than=75_000, dry_run=True, now=now)][:1] == folders[:1]
    assert all(folder.is_dir() for folder in folders)
    rest = info["bytes"] - info["parts"]["converted"]["bytes"]
    assert main(["cache", "prune", "--max-size", str(rest + size * 2 + 200)]) == 0
    assert [folder.is_dir() for folder in folders] == [False, False, True, True]
    assert "2 entries" in capsys.readouterr().out
    assert scene_for(tmp_path / "t0.glb")[0].is_file()


def test_use_keeps_an_entry(tmp_path: Path) -> None:
    folders = fill(tmp_path, 2)
    scene_for(tmp_path / "t0.glb")
    assert prune(older_than=3600, dry_run=True)[-1].path == folders[1]


def test_litter_goes_when_it_is_old(tmp_path: Path) -> None:
    folder = fill(tmp_path, 1)[0]
    litter = folder.parent / ".abc.1234-99999999.x.tmp"
    litter.mkdir()
    assert not [kept for kept in prune(older_than=10**12) if kept.litter]
    os.utime(litter, (1, 1))
    assert [kept.path for kept in prune(older_than=10**12)] == [litter]
    assert folder.is_dir()


def test_a_copy_from_an_entry_that_was_pruned(tmp_path: Path) -> None:
    from importers.farm.job import Job
    from importers.farm.single import record_from, run_one
    from importers.farm.task import request_for
    from importers.settings import ImportSettings

    source = triangle().write_glb(tmp_path / "t.glb")
    reply = run_one(request_for(source, "t", ImportSettings()), source, ImportSettings(), None)
    with pytest.raises(EntryLost):
        publish(tmp_path / "pruned", record_from(reply), None, Job(source, tmp_path / "out", "t"))
    assert not [p for p in (tmp_path / "out").rglob("*") if p.is_file()]


def test_threads_that_want_the_same_at_once(tmp_path: Path) -> None:
    source = triangle().write_glb(tmp_path / "t.glb")
    found: list[Path] = []
    threads = [threading.Thread(target=lambda: found.append(scene_for(source, force=True)[0])) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(set(found)) == 1
    assert len(found) == 4
    assert found[0].is_file()
    assert not list(found[0].parent.parent.glob(".*.tmp"))


def test_sizes_and_ages() -> None:
    assert parse_size("5GB") == 5_000_000_000
    assert parse_size("1.5 MiB") == 1_572_864
    assert parse_size("0") == 0
    assert parse_age("2w") == 1_209_600
    for text in ("many", "-1", "5 parsecs", "30d"):
        with pytest.raises(UsageError):
            parse_size(text)
    with pytest.raises(UsageError):
        parse_age("30")


def test_usage(capsys: Capture) -> None:
    assert main(["cache", "prune"]) == 2
    assert "--max-size" in capsys.readouterr().err
    assert main(["cache", "info", "--dry-run"]) == 2
