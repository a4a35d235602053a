"""`lucarna report`: list, measure, compare; what it refuses."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from engine.experiments.harness import registry, sweep
from importers.cli.main import main

Capture = pytest.CaptureFixture[str]


@pytest.fixture(autouse=True)
def _few_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sweep, "REPEATS", (5, 5))
    monkeypatch.setattr(sweep, "BUDGET_S", (0.1, 0.1))


def test_lists_every_experiment(capsys: Capture) -> None:
    assert main(["report"]) == 0
    out = capsys.readouterr().out
    assert all(f"{name} " in out for name in registry.names())
    assert main(["report", "quaternion", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["quaternion"]["title"]


def test_writes_a_page_and_its_twin(tmp_path: Path, capsys: Capture) -> None:
    code = main(["report", "quaternion", "affine-inverse", "--quick", "--out", str(tmp_path / "r")])
    printed = capsys.readouterr().out
    assert code in (0, 1), "1 where a default is beaten, which is for the machine to say"
    twin = json.loads((tmp_path / "r" / "report.json").read_text("utf-8"))
    assert [e["name"] for e in twin["experiments"]] == ["quaternion", "affine_inverse"]
    assert twin["quick"] is True
    assert twin["versions"]["numpy"]
    assert "<!DOCTYPE html>" in (tmp_path / "r" / "report.html").read_text("utf-8")
    assert str(tmp_path / "r" / "report.html") in printed
    assert "quaternion: " in printed
    code = main(["report", "--compare", *[str(tmp_path / "r" / "report.json")] * 2])
    assert code == 0
    assert "0 worse" in capsys.readouterr().out


def test_json_alone_on_stdout(tmp_path: Path, capsys: Capture) -> None:
    main(["report", "quaternion", "--quick", "--json", "--out", str(tmp_path)])
    assert json.loads(capsys.readouterr().out)["experiments"][0]["name"] == "quaternion"


def test_a_regression_is_exit_code_1(tmp_path: Path, capsys: Capture) -> None:
    point = {"knobs": {"n": 1}, "error": {"rmse": 1.0}, "ms": None}
    for name, error in (("a", 1.0), ("b", 2.0)):
        experiment = {"name": "x", "points": [{**point, "error": {"rmse": error}}]}
        (tmp_path / f"{name}.json").write_text(json.dumps({"experiments": [experiment]}), "utf-8")
    a, b = str(tmp_path / "a.json"), str(tmp_path / "b.json")
    assert main(["report", "--compare", a, b]) == 1
    assert "worse: x [n 1]: rmse 1 -> 2 (×2)" in capsys.readouterr().out
    assert main(["report", "--compare", b, a]) == 0
    assert main(["report", "--compare", a, b, "--json"]) == 1
    out = capsys.readouterr().out
    assert json.loads(out[out.index("{") :])["worse"] == 1


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["quaternoin"], "did you mean 'quaternion'"),
        (["quaternion", "--scene", "x.glb"], "--scene without --out"),
        (["--out", "r", "--scene", "no.glb"], "no such file"),
        (["--out", "r", "--seed", "-1"], "negative"),
        (["--compare", "a.json", "b.json", "--out", "r"], "nothing else"),
    ],
)
def test_refuses(
    words: list[str], message: str, capsys: Capture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["report", *words]) == 2
    assert message in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_a_file_is_no_folder(tmp_path: Path, capsys: Capture) -> None:
    (tmp_path / "r").write_text("mine", "utf-8")
    assert main(["report", "quaternion", "--out", str(tmp_path / "r")]) == 2
    assert "give a folder" in capsys.readouterr().err
    assert (tmp_path / "r").read_text("utf-8") == "mine"


def test_a_folder_that_cannot_be_made_is_known_before_measuring(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("importers.cli.report._measure", lambda chosen, args: pytest.fail("measured first"))
    (tmp_path / "file").touch()
    assert main(["report", "quaternion", "--out", str(tmp_path / "file" / "r")]) == 3
    assert "cannot make the folder" in capsys.readouterr().err


def test_a_scene_that_changes_nothing_is_said(tmp_path: Path, capsys: Capture) -> None:
    (tmp_path / "x.glb").touch()
    words = ["report", "quaternion", "--quick", "--scene", str(tmp_path / "x.glb"), "--out", str(tmp_path / "r")]
    assert main(words) == 0
    assert "quaternion has inputs of its own" in capsys.readouterr().err


def test_compare_needs_reports(tmp_path: Path, capsys: Capture) -> None:
    (tmp_path / "a.json").write_text("{}", "utf-8")
    assert main(["report", "--compare", str(tmp_path / "a.json"), str(tmp_path / "a.json")]) == 1
    assert "no report" in capsys.readouterr().err


def test_a_scene_without_names_chooses_what_measures_scenes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    chosen: list[list[str]] = []
    monkeypatch.setattr("importers.cli.report._measure", lambda found, args: chosen.append(sorted(found)) or 0)
    (tmp_path / "x.glb").touch()
    assert main(["report", "--scene", str(tmp_path / "x.glb"), "--out", str(tmp_path / "r")]) == 0
    assert main(["report", "quaternion", "--scene", str(tmp_path / "x.glb"), "--out", str(tmp_path / "r")]) == 0
    assert chosen[0] == [
        "ambient_light", "antialias", "ao", "bloom", "dof", "exposure", "gi", "local_shadows", "picture",
        "picture_lights", "presets", "pruning", "reflections", "sun_shadows",
    ]  # fmt: skip
    assert chosen[1:] == [["quaternion"]]
