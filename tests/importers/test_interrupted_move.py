"""A process that is killed in the middle of a move leaves nothing half done: who comes next puts everything back."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from engine.core.errors import InputError
from importers.cli.main import main
from importers.project import move_log
from importers.project.moving import plan

CHILD = """
import os, signal, sys
from pathlib import Path
from importers.project import moving
left = [int(sys.argv[3])]
def dying(do):
    def run(*a, **k):
        if left[0] == 0:
            os.kill(os.getpid(), signal.SIGKILL)
        left[0] -= 1
        return do(*a, **k)
    return run
move = moving.plan(Path(sys.argv[1]), Path(sys.argv[2]))
Path.rename, moving.write_bytes = dying(Path.rename), dying(moving.write_bytes)
moving._remove_empty = dying(moving._remove_empty)
move.apply()
"""
NEEDS_KILL = pytest.mark.skipif(sys.platform == "win32", reason="has no SIGKILL")


@pytest.fixture
def project(tmp_path: Path) -> Path:
    root = tmp_path / "game"
    (root / "a").mkdir(parents=True)
    (root / "project.toml").write_text('[project]\nname = "Game"\nstart = "a/fox.gltf"\n')
    (root / "a/fox.gltf").write_text(json.dumps({"asset": {}, "buffers": [{"uri": "fox.bin"}]}))
    (root / "a/fox.bin").write_bytes(b"1")
    return root


def everything(root: Path) -> dict[str, bytes]:
    return {p.relative_to(root).as_posix(): p.read_bytes() for p in root.rglob("*") if p.is_file()}


@NEEDS_KILL
@pytest.mark.parametrize("steps", [0, 1, 2])
def test_a_move_that_was_killed_is_put_back(project: Path, steps: int) -> None:
    """Before the first of two renames, between them, and before the reference to them is rewritten."""
    before = everything(project)
    new = project / "models/animals"
    done = subprocess.run([sys.executable, "-c", CHILD, project / "a", new, str(steps)], check=False, timeout=60)
    assert done.returncode < 0
    assert (project / move_log.FOLDER / move_log.NAME).is_file()
    assert len(move_log.recover_around(project / "a/fox.gltf")) == steps
    assert everything(project) == before
    assert not (project / "models").exists()
    assert move_log.recover(project) == []
    plan(project / "a", new).apply()
    assert "models/animals/fox.gltf" in (project / "project.toml").read_text()
    assert not (project / move_log.FOLDER).exists()


@NEEDS_KILL
def test_the_next_command_says_what_it_put_back(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    new = project / "b"
    for steps, said in ((1, "put back: a/fox"), (0, "moved nothing")):
        done = subprocess.run([sys.executable, "-c", CHILD, project / "a", new, str(steps)], check=False, timeout=60)
        assert done.returncode < 0
        assert main(["mv", "--dry-run", str(project / "a"), str(new)]) == 0
        told = capsys.readouterr()
        assert told.err.startswith("lucarna: an interrupted move")
        assert said in told.err
        assert "would move a to b" in told.out
    assert main(["mv", "--dry-run", str(project / "a"), str(new)]) == 0
    assert not capsys.readouterr().err


@NEEDS_KILL
def test_one_that_was_whole_stays(project: Path) -> None:
    new = project / "b"
    done = subprocess.run([sys.executable, "-c", CHILD, project / "a", new, "3"], check=False, timeout=60)
    assert done.returncode < 0
    assert move_log.recover(project) == []
    assert (new / "fox.bin").is_file()


def test_a_rewritten_reference_goes_back_unless_somebody_changed_it_since(project: Path) -> None:
    before = everything(project)
    move = plan(project / "a", project / "b")
    place = project / "project.toml"
    for edited in (False, True):
        contents = {p: after for p, (_before, after) in move.rewritten.items()}
        move_log.begin(project, move.files, contents, [project / "b"])
        (project / "b").mkdir()
        for old, new in move.files.items():
            old.rename(new)
        place.write_bytes(contents[place] + (b"# mine\n" if edited else b""))
        assert len(move_log.recover(project)) == 2
        assert place.read_bytes() == (contents[place] + b"# mine\n" if edited else before["project.toml"])


def test_the_intent_of_a_living_process_is_left_alone_and_a_broken_one_is_said(project: Path) -> None:
    path = move_log.begin(project, {project / "a/fox.bin": project / "a/wolf.bin"}, {}, [])
    said = json.loads(path.read_text())
    path.write_text(json.dumps({**said, "process": os.getppid()}))
    if sys.platform != "win32":
        assert move_log.recover(project) == []
        assert path.is_file()
    path.write_text("{")
    with pytest.raises(InputError, match="interrupted move"):
        move_log.recover(project)
