"""Runs over a folder: nothing is done twice, everything that matters is noticed, and each reason is said."""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path
from typing import Any

import pytest

from importers.cache import scene_for
from importers.cli.main import main
from importers.convert import convert
from importers.settings import ImportSettings
from tests.support.gltf_builder import png, textured_triangle, triangle
from tests.support.ogre_builder import SQUARE_INDICES, OgreBytes

Capture = pytest.CaptureFixture[str]


def run(depot: Path, *flags: str, capsys: Capture) -> dict[str, dict[str, Any]]:
    main(["convert", str(depot), "--out", str(depot.parent / "out"), "--json", *flags])
    return {Path(item["source"]).name: item for item in json.loads(capsys.readouterr().out)}


def states(found: dict[str, dict[str, Any]]) -> dict[str, str]:
    return {name: item["state"] for name, item in found.items()}


def digests(folder: Path) -> dict[str, str]:
    files = [p for p in sorted(folder.rglob("*")) if p.is_file() and ".lucarna" not in p.parts]
    return {p.relative_to(folder).as_posix(): hashlib.sha256(p.read_bytes()).hexdigest() for p in files}


def test_the_second_run_does_nothing(depot: Path, capsys: Capture) -> None:
    assert set(states(run(depot, capsys=capsys)).values()) == {"converted"}
    before = {p: p.stat().st_mtime_ns for p in (depot.parent / "out").rglob("*") if p.is_file()}
    assert set(states(run(depot, capsys=capsys)).values()) == {"up to date"}
    assert {p: p.stat().st_mtime_ns for p in (depot.parent / "out").rglob("*") if p.is_file()} == before
    assert main(["convert", str(depot), "--out", str(depot.parent / "out")]) == 0
    assert "nothing to do: 3 up to date" in capsys.readouterr().out


def test_a_changed_texture_rebuilds_its_dependants_alone(depot: Path, capsys: Capture) -> None:
    run(depot, capsys=capsys)
    (depot / "paint.png").write_bytes(png(4, 4, (1, 2, 3)))
    found = run(depot, "--explain", capsys=capsys)
    assert states(found) == {"blue.gltf": "converted", "red.gltf": "converted", "plain.glb": "up to date"}
    assert found["red.gltf"]["reasons"] == ["the dependency paint.png has other bytes"]
    changed = {Path(o["path"]).name for o in found["red.gltf"]["outputs"] if o["changed"]}
    assert "red.paint.dds" in changed
    assert "red.paint.normal.dds" not in changed
    os.utime(depot / "paint.png", (1, 1))
    assert set(states(run(depot, capsys=capsys)).values()) == {"up to date"}


def test_explain_in_words(depot: Path, capsys: Capture) -> None:
    words = ["convert", str(depot), "--out", str(depot.parent / "out"), "--explain"]
    main(words)
    (depot / "paint.png").write_bytes(png(4, 4, (1, 2, 3)))
    capsys.readouterr()
    main(words)
    text = capsys.readouterr().out
    assert "because the dependency paint.png has other bytes" in text
    assert "red.paint.dds: written" in text
    assert "red.lmesh: the same bytes, left alone" in text
    assert "red.scene.json: the same bytes, left alone" in text
    assert "red.paint.normal.dds: the same bytes, left alone" in text


def test_every_other_reason(depot: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    run(depot, capsys=capsys)
    out = depot.parent / "out"

    def reasons(*flags: str) -> dict[str, list[str]]:
        return {name: item["reasons"] for name, item in run(depot, *flags, capsys=capsys).items() if item["reasons"]}

    (depot / "red.gltf.import").write_text("max_texture_size = 2\n")
    assert reasons() == {"red.gltf": ["the setting max_texture_size is 2 (red.gltf.import:1), was 0"]}
    (out / "blue.lmesh").unlink()
    assert reasons() == {"blue.gltf": ["the output blue.lmesh is gone"]}
    (out / "blue.lmesh").write_bytes(b"mine")
    assert reasons() == {"blue.gltf": ["the output blue.lmesh was changed by something else"]}
    (depot / "paint.png").rename(depot / "gone.png")
    assert set(reasons()) == {"red.gltf", "blue.gltf"}
    (depot / "gone.png").rename(depot / "paint.png")
    assert reasons()["blue.gltf"] == ["the dependency paint.png has appeared"]
    assert reasons("--force")["blue.gltf"] == ["it is forced"]
    for module in ("importers.farm.record", "importers.farm.task", "importers.fingerprint"):
        monkeypatch.setattr(f"{module}.CONVERT_VERSION", "another")
    assert "the writer has version" in reasons()["plain.glb"][0]


def test_a_dry_run_says_what_would_be_done_and_writes_nothing(depot: Path, capsys: Capture) -> None:
    words = ["convert", str(depot), "--out", str(depot.parent / "out"), "--dry-run"]
    assert main(words) == 0
    assert "3 to convert, 0 up to date" in capsys.readouterr().out
    assert not (depot.parent / "out").exists()
    main(words[:-1])
    (depot / "sub" / "plain.glb").write_bytes(triangle([[0, 0, 0], [2, 0, 0], [0, 2, 0]]).glb())
    capsys.readouterr()
    main(words)
    text = capsys.readouterr().out
    assert "plain.glb: the source plain.glb has other bytes" in text
    assert "1 to convert, 2 up to date" in text


def test_failures_are_remembered_until_something_changes(depot: Path, capsys: Capture) -> None:
    bad = depot / "bad.gltf"
    bad.write_text("{")
    words = ["convert", str(depot), "--out", str(depot.parent / "out")]
    assert main(words) == 1
    assert main(words) == 1
    printed = capsys.readouterr()
    assert "nothing to do: 3 up to date, 1 failed as before" in printed.out
    assert "bad.gltf" in printed.err
    assert not (depot.parent / "out" / ".lucarna" / "bad.json").exists()
    triangle().write_gltf(bad)
    assert main(words) == 0
    assert "1 converted, 3 up to date" in capsys.readouterr().out


def test_what_is_made_no_more_goes_and_what_was_edited_stays(depot: Path, capsys: Capture) -> None:
    source = depot / "sub" / "plain.glb"
    builder = triangle()
    builder.material(name="old")
    builder.material(name="kept")
    builder.write_glb(source)
    run(depot, capsys=capsys)
    (depot.parent / "out/sub/plain.kept.material.toml").write_text("# mine")
    triangle().write_glb(source)
    assert run(depot, capsys=capsys)["plain.glb"]["removed"] == ["plain.old.material.toml"]
    assert (depot.parent / "out/sub/plain.kept.material.toml").is_file()


def test_clean_removes_the_outputs_of_vanished_sources(depot: Path, capsys: Capture) -> None:
    run(depot, capsys=capsys)
    (depot / "red.gltf").unlink()
    run(depot, capsys=capsys)
    out = depot.parent / "out"
    assert (out / "red.scene.json").is_file()
    run(depot, "--clean", capsys=capsys)
    assert not list(out.glob("red.*"))
    assert (out / "blue.scene.json").is_file()


def test_job_count_force_cache_and_doors_do_not_change_the_bytes(
    depot: Path, tmp_path: Path, capsys: Capture, real_workers: None
) -> None:
    for name, flags in (("one", ["--jobs", "1"]), ("two", ["--jobs", "2", "--force"]), ("three", [])):
        assert main(["convert", str(depot), "--out", str(tmp_path / name), "--quiet", *flags]) == 0
    assert "3 from the cache" in capsys.readouterr().out
    opened = {
        p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in scene_for(depot / "red.gltf")[0].parent.iterdir()
    }
    opened.pop("import.json")
    assert opened.items() <= digests(tmp_path / "one").items()  # what the editor opens
    for folder, source in (("", "red.gltf"), ("", "blue.gltf"), ("sub", "sub/plain.glb")):
        convert(depot / source, tmp_path / "four" / folder, ImportSettings())
    assert digests(tmp_path / "one") == digests(tmp_path / "two")
    assert digests(tmp_path / "one") == digests(tmp_path / "three") == digests(tmp_path / "four")


def test_a_new_file_that_an_importer_would_find(tmp_path: Path, capsys: Capture) -> None:
    """An Ogre mesh finds its materials by looking around; a script that comes later must count."""
    depot = tmp_path / "depot"
    depot.mkdir()
    ogre = OgreBytes()
    mesh = ogre.mesh(ogre.submesh("stone", SQUARE_INDICES, ogre.square_geometry()))
    (depot / "wall.mesh").write_bytes(mesh)
    run(depot, capsys=capsys)
    (depot / "notes.txt").write_text("nothing to anybody")
    assert states(run(depot, capsys=capsys)) == {"wall.mesh": "up to date"}
    (depot / "all.material").write_text("material stone { technique { pass { diffuse 1 0 0 } } }")
    again = run(depot, capsys=capsys)["wall.mesh"]
    assert again["state"] == "converted"
    assert again["reasons"] == ["files came to or left the folder ."]
    assert states(run(depot, capsys=capsys)) == {"wall.mesh": "up to date"}


def test_one_bad_file_costs_one_file(depot: Path, capsys: Capture, real_workers: None) -> None:
    """By limits of its own, one source runs out of time and another out of memory."""
    for name, text in (("slow", "max_worker_seconds = 0.1\n"), ("fat", "max_worker_bytes = 60000000\n")):
        textured_triangle(png(1024, 1024)).write_glb(depot / f"{name}.glb")  # more than a tenth of a second's work
        (depot / f"{name}.glb.import").write_text(text)
    found = run(depot, "--jobs", "2", capsys=capsys)
    assert {name for name, item in found.items() if item["error"]} == {"slow.glb", "fat.glb"}
    assert "did not finish within 0.1 s" in found["slow.glb"]["error"]
    assert states(found)["red.gltf"] == "converted"


def test_no_word_names_a_file_of_another(tmp_path: Path, capsys: Capture) -> None:
    triangle().write_glb(tmp_path / "a.glb")
    assert main(["convert", str(tmp_path / "a.glb"), str(tmp_path / "b.glb"), "--out", str(tmp_path / "out")]) == 1
    printed = capsys.readouterr()
    assert "there is no such file" in printed.err
    assert (tmp_path / "out" / "a.scene.json").is_file()


def test_save_settings_writes_sidecars(depot: Path, capsys: Capture) -> None:
    words = ["convert", str(depot / "red.gltf"), "--save-settings", "--max-texture-size", "2"]
    assert main(words) == 0
    assert (depot / "red.gltf.import").read_text() == "max_texture_size = 2\n"
    assert main(["convert", str(depot / "red.gltf"), "--save-settings"]) == 2
