"""`lucarna run`: scripts with the editor's operations, without window and GPU; the history as a script."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from animated_scene import NullHost
from small_scene import write_small_scene

from editor.builtin_operations import builtin_operations
from editor.document import Document
from editor.editing_operations import reparent
from editor.host import Resolved
from editor.preferences import Preferences
from editor.scripting import history_script
from editor.session import Session
from engine.assets.scene_json import read_scene
from importers.cli.main import main

EXAMPLE = Path(__file__).resolve().parents[2] / "docs" / "examples" / "arrange.py"


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    return write_small_scene(tmp_path)


def run(folder: Path, text: str) -> int:
    script = folder / "script.py"
    script.write_text(text, encoding="utf-8")
    return main(["run", str(script)])


def test_the_example(scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out" / "row.scene.json"
    assert main(["run", str(EXAMPLE), str(scene), "lamp", str(out)]) == 0
    names = [n.name for n in read_scene(out).nodes]
    assert "row" in names
    assert sum(n.light is not None for n in read_scene(out).nodes) == 6
    assert capsys.readouterr().out == f"{len(names)} nodes in {out}\n"


@pytest.mark.parametrize(
    ("text", "place", "message"),
    [
        ("x = 1\n1 / 0\n", "script.py:2", "division by zero"),
        ("def f():\n    return open_file('/nowhere.glb')\n\nf()\n", "script.py:2", "no such file"),
        ("run('edit.duplicat')\n", "script.py:1", "did you mean 'edit.duplicate'"),
        ("run('file.open')\n", "script.py:1", "file.open-path"),
        ("run('edit.delete')\n", "script.py:1", "no document is open"),
        ("run('play.seek', tim=1)\n", "script.py:1", "cannot be done now"),
        ("x = (\n", "script.py:1", "never closed"),
    ],
)
def test_what_goes_wrong_is_said_with_its_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str, place: str, message: str
) -> None:
    assert run(tmp_path, text) == 1
    error = capsys.readouterr().err
    assert place in error
    assert message in error
    assert "Traceback" not in error


def test_a_refused_edit_is_an_error_of_the_script(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = "select('cube')\nrun('edit.reparent', parent='cube')\n"
    (tmp_path / "script.py").write_text(text, encoding="utf-8")
    assert main(["run", "--open", str(scene), str(tmp_path / "script.py")]) == 1
    assert "script.py:2" in capsys.readouterr().err


def test_exit_codes(tmp_path: Path) -> None:
    assert run(tmp_path, "import sys; sys.exit(5)\n") == 5
    assert run(tmp_path, "import sys; sys.exit(); 1 / 0\n") == 0
    assert main(["run", str(tmp_path / "nowhere.py")]) == 2


def test_json_says_what_was_done(scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    script = tmp_path / "script.py"
    script.write_text(
        "print('not for machines')\nselect('lamp')\nrun('edit.move-by', offset=(1, 0, 0))\nselect('no')\n"
    )
    assert main(["run", "--open", str(scene), "--json", str(script)]) == 1
    told = json.loads(capsys.readouterr().out)
    assert told["operations"][1:] == [
        "run('select.nodes', nodes=['lamp'])", "select('lamp'); run('edit.move-by', offset=(1, 0, 0))",
    ]  # fmt: skip
    assert (told["exit_code"], told["edits"], told["unsaved"]) == (1, 1, True)
    assert told["error"]["where"] == f"{script}:4"


def test_the_history_as_a_script_makes_the_same_file(scene: Path, tmp_path: Path) -> None:
    host = NullHost.__new__(NullHost)
    session = Session(host, Preferences())
    session.save_preferences = False
    session.device = host.open_device(False)
    document = Document(Resolved(scene, scene), host.open_runtime(session.device, scene))
    session.adopt(document)
    operations = builtin_operations()
    document.selection = (2, 3)
    operations.run("edit.duplicate", session)
    session.edit("nodes", "translation", document.selection, [(1, 2, 3), (0.1, 0.2, 0.3)])
    operations.run("edit.delete", session)
    session.undo()
    operations.run("edit.group", session)
    reparent(session, [1], 2)
    document.selection = (3,)
    operations.run("add.spot-light", session)
    session.edit("lights", "intensity", [1], [7.5])
    session.edit("environment", "kind", [0], ["sky"])
    operations.run("view.set", session, name="exposure", value=1.0)
    text = history_script(document)
    assert text.count("\n") > 8
    assert "delete" not in text, "what was undone is not in it"
    one, other = tmp_path / "a" / "x.scene.json", tmp_path / "b" / "x.scene.json"
    operations.run("file.save-to", session, path=one)
    assert session.failure is None
    session.close()
    assert run(tmp_path, f"{text}\nsave({str(other)!r})\n") == 0
    assert other.read_bytes() == one.read_bytes()


def test_project_plugins_need_a_word(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_small_scene(tmp_path)
    (tmp_path / "project.toml").write_text('[project]\nname = "p"\nstart = "boxes.scene.json"\n')
    (tmp_path / "plugins").mkdir()
    (tmp_path / "plugins" / "own.py").write_text(
        "def register(plugin):\n    plugin.operation('own.say', 'Say', lambda session: print('said'))\n"
    )
    script = tmp_path / "script.py"
    script.write_text(f"open_file({str(tmp_path)!r})\nrun('own.say')\n")
    assert main(["run", str(script)]) == 1
    assert "--trust-plugins" in capsys.readouterr().err
    assert main(["run", "--no-plugins", "--trust-plugins", str(script)]) == 1
    capsys.readouterr()
    assert main(["run", "--trust-plugins", str(script)]) == 0
    assert capsys.readouterr().out == "said\n"
