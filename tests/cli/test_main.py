"""The command line: help without heavy imports, exit codes, streams, JSON."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from importers.cli import main as cli
from importers.cli.main import COMMANDS, main
from tests.support.gltf_builder import png, textured_triangle, triangle

Capture = pytest.CaptureFixture[str]


def test_bare_call_and_help_list_every_command(capsys: Capture) -> None:
    assert main([]) == 0
    bare = capsys.readouterr().out
    assert main(["--help"]) == 0
    assert capsys.readouterr().out == bare
    assert all(f"  {name} " in bare for name in COMMANDS)


def test_help_imports_nothing_heavy() -> None:
    code = (
        "import sys; from importers.cli.main import main; main(['--help']);"
        "bad = [m for m in ('numpy', 'pydantic', 'PIL', 'moderngl', 'importers.convert') if m in sys.modules];"
        "sys.exit(' '.join(bad) or None)"
    )
    root = Path(cli.__file__).resolve().parents[2]
    done = subprocess.run([sys.executable, "-c", code], cwd=root, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_runs_as_a_module() -> None:
    root = Path(cli.__file__).resolve().parents[2]
    done = subprocess.run(
        [sys.executable, "-m", "importers.cli", "nonsense"], cwd=root, capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    assert done.stderr.startswith("lucarna: error: unknown command 'nonsense'")


def test_usage_errors(capsys: Capture) -> None:
    assert main(["convrt"]) == 2
    assert "did you mean `lucarna convert`?" in capsys.readouterr().err
    assert main(["convert", "a.glb"]) == 2
    assert "--out" in capsys.readouterr().err
    assert main(["convert", "a.glb", "--out", "o", "--quality", "best"]) == 2
    assert "--quality: unknown quality 'best'" in capsys.readouterr().err
    assert main(["convert", "a.glb", "--out", "o", "--jobs", "-1"]) == 2
    assert main(["convert", "--help"]) == 0


def test_convert_prints_files_and_findings(tmp_path: Path, capsys: Capture) -> None:
    b = textured_triangle()
    b.root["images"][0] = {"uri": "gone.png"}
    source = b.write_gltf(tmp_path / "a.gltf")
    assert main(["convert", str(source), "--out", str(tmp_path / "out")]) == 1
    printed = capsys.readouterr()
    assert "a.scene.json" in printed.out
    assert f"error: {source}: images[0].uri" in printed.err


def test_warnings_do_not_change_the_exit_code(tmp_path: Path, capsys: Capture) -> None:
    b = triangle()
    b.root["nodes"][0]["rotation"] = [0, 0, 0, 2]
    source = b.write_gltf(tmp_path / "a.gltf")
    assert main(["convert", str(source), "--out", str(tmp_path / "out")]) == 0
    assert "warning" in capsys.readouterr().out


def test_convert_json_is_alone_on_stdout(tmp_path: Path, capsys: Capture) -> None:
    good = triangle().write_gltf(tmp_path / "a.gltf")
    bad = tmp_path / "b.gltf"
    bad.write_text("{")
    assert main(["convert", str(good), str(bad), "--out", str(tmp_path / "out"), "--json"]) == 1
    reports = json.loads(capsys.readouterr().out)
    assert [bool(r.get("error")) for r in reports] == [False, True]
    assert reports[0]["scene"].endswith("a.scene.json")
    assert (tmp_path / "out" / "a.scene.json").is_file()


def test_convert_folder_keeps_structure_and_splits_equal_names(tmp_path: Path) -> None:
    tree = tmp_path / "tree"
    (tree / "sub").mkdir(parents=True)
    triangle().write_glb(tree / "a.glb")
    triangle().write_gltf(tree / "a.gltf")
    triangle().write_glb(tree / "sub" / "b.glb")
    assert main(["convert", str(tree), "--out", str(tmp_path / "out")]) == 0
    scenes = sorted(str(p.relative_to(tmp_path / "out")) for p in (tmp_path / "out").rglob("*.scene.json"))
    assert scenes == ["a.scene.json", "a_gltf.scene.json", "sub/b.scene.json"]


def test_check_writes_nothing_and_finds_the_same(tmp_path: Path, capsys: Capture) -> None:
    good = textured_triangle().write_glb(tmp_path / "good.glb")
    assert main(["check", str(good)]) == 0
    capsys.readouterr()
    b = textured_triangle()
    b.root["images"][0] = {"bufferView": b.view(png(4, 4)[:40]), "mimeType": "image/png"}
    bad = b.write_glb(tmp_path / "bad.glb")
    before = sorted(p.name for p in tmp_path.iterdir())
    assert main(["check", str(good), str(bad), "--json"]) == 1
    reports = json.loads(capsys.readouterr().out)
    assert [len(r["findings"]) for r in reports] == [0, 1]
    assert sorted(p.name for p in tmp_path.iterdir()) == before


def test_check_finds_a_lost_reference(tmp_path: Path, capsys: Capture) -> None:
    source = textured_triangle().write_glb(tmp_path / "a.glb")
    assert main(["convert", str(source), "--out", str(tmp_path / "out")]) == 0
    assert main(["check", str(tmp_path / "out")]) == 0
    (tmp_path / "out" / "a.lmesh").unlink()
    assert main(["check", str(tmp_path / "out")]) == 1
    assert "the file 'a.lmesh' is not there" in capsys.readouterr().err


def test_inspect_describes_sources_and_engine_files(tmp_path: Path, capsys: Capture) -> None:
    source = textured_triangle().write_glb(tmp_path / "a.glb")
    assert main(["inspect", str(source), "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["textures"][0]["size"] == [4, 4]
    assert data["meshes"][0]["bounds"] == [[0, 0, 0], [1, 1, 0]]
    main(["convert", str(source), "--out", str(tmp_path / "out")])
    capsys.readouterr()
    for name, word in (
        ("a.lmesh", "vertices 3"),
        ("a.scene.json", "mesh files: a.lmesh"),
        ("a.paint.material.toml", "surface"),
        ("a.paint.base_color.dds", "size 4 4"),
    ):
        assert main(["inspect", str(tmp_path / "out" / name)]) == 0
        assert word in capsys.readouterr().out


def test_inspect_of_nothing(tmp_path: Path, capsys: Capture) -> None:
    (tmp_path / "model.glb").write_bytes(b"x")
    assert main(["inspect", str(tmp_path / "modle.glb")]) == 1
    assert "did you mean 'model.glb'?" in capsys.readouterr().err


@pytest.mark.parametrize("words", [["convert", "--out", "out"], ["check"], ["inspect"], ["export", "--out", "a.obj"]])
def test_a_name_that_no_file_can_have_is_a_missing_file(
    words: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main([*words, "n" * 300 + ".glb"]) == 1
    assert "there is no such file" in capsys.readouterr().err


def test_what_the_system_refuses_is_no_traceback(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["new", str(tmp_path / ("n" * 300))]) == 3
    assert capsys.readouterr().err.startswith("lucarna: error: ")


@pytest.mark.parametrize(("command", "code"), [("inspect", 0), ("convert", 3)])
def test_a_reader_that_is_gone_leaves_work_undone(
    command: str, code: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def gone(words: list[str]) -> int:
        raise BrokenPipeError

    monkeypatch.setattr(cli, "_run", gone)
    monkeypatch.setattr(sys, "stderr", (tmp_path / "stderr").open("w"))
    assert main([command]) == code
