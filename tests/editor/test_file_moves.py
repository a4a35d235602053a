"""Files that move under open documents: references follow, undo brings every byte and every earlier edit back."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from real_session import opened, real_session
from small_scene import write_small_scene

from editor import file_moves, journal, recovering, tabs
from editor.builtin_operations import builtin_operations
from editor.commands import structure
from editor.session import Session
from engine.assets.scene_json import read_scene
from engine.core.errors import InputError
from importers.project import move_log


@pytest.fixture
def project(tmp_path: Path) -> Path:
    root = tmp_path / "game"
    write_small_scene(root / "scenes")
    (root / "project.toml").write_text('[project]\nname = "Game"\nstart = "scenes/boxes.scene.json"\n')
    (root / "notes").mkdir()
    (root / "notes/todo.txt").write_text("paint")
    return root


@pytest.fixture
def session(tmp_path: Path) -> Iterator[Session]:
    session = real_session(tmp_path / "recovery")
    yield session
    session.close_all()


def everything(root: Path) -> dict[str, bytes]:
    return {p.relative_to(root).as_posix(): p.read_bytes() for p in root.rglob("*") if p.is_file()}


def test_a_material_moves_under_an_open_scene_and_undo_brings_all_of_it_back(session: Session, project: Path) -> None:
    document = opened(session, project / "scenes/boxes.scene.json")
    session.edit("nodes", "visible", (1,), (False,), label="Hide plinth")
    assert session.save()
    before = everything(project)
    old, new = project / "scenes/boxes.red.material.toml", project / "materials/red.material.toml"
    assert builtin_operations().run("file.move", session, old=old, new=new)
    assert not session.ui.error_bar
    assert new.is_file()
    mesh = read_scene(project / "scenes/boxes.scene.json").nodes[2].mesh
    assert mesh is not None
    assert mesh.materials == ["../materials/red.material.toml"]
    residency = document.runtime.residency
    assert new in {Path(residency.material(m).path).resolve() for m in range(2)}
    assert not document.dirty, "nothing is left to save"
    session.undo()
    assert everything(project) == before
    assert not document.runtime.scene.nodes.visible[1]
    session.undo()
    assert document.runtime.scene.nodes.visible[1], "edits from before are undone as ever"
    session.redo()
    session.redo()
    assert new.is_file()
    assert not document.runtime.scene.nodes.visible[1]


def test_the_scene_itself_and_files_that_it_does_not_use(session: Session, project: Path) -> None:
    document = opened(session, project / "scenes/boxes.scene.json")
    runtime = document.runtime
    assert file_moves.move(session, project / "notes/todo.txt", project / "notes/done.txt")
    assert document.runtime is runtime, "the scene has nothing to do with it"
    assert file_moves.move(session, project / "scenes", project / "levels")
    assert document.scene_path == project / "levels/boxes.scene.json"
    session.edit("nodes", "visible", (1,), (False,))
    assert session.save()
    assert not read_scene(project / "levels/boxes.scene.json").nodes[1].visible
    for _ in range(3):
        session.undo()
    assert (project / "notes/todo.txt").is_file()
    assert document.scene_path == project / "scenes/boxes.scene.json"


def test_unsaved_changes_and_clashes_are_said_and_nothing_moves(session: Session, project: Path) -> None:
    opened(session, project / "scenes/boxes.scene.json")
    red, grey = (project / f"scenes/boxes.{n}.material.toml" for n in ("red", "grey"))
    assert not file_moves.move(session, red, grey)
    assert "already" in session.ui.error_bar
    session.edit("nodes", "visible", (1,), (False,))
    before = everything(project)
    assert not file_moves.move(session, red, project / "scenes/crimson.material.toml")
    assert "save it first" in session.ui.error_bar
    assert everything(project) == before


def test_a_tab_behind_follows_too(session: Session, project: Path) -> None:
    behind = opened(session, project / "scenes/boxes.scene.json")
    (project / "other").mkdir()
    write_small_scene(project / "other")
    front = opened(session, project / "other/boxes.scene.json")
    red = project / "scenes/boxes.red.material.toml"
    assert file_moves.move(session, red, project / "scenes/crimson.material.toml")
    paths = {Path(r.path).name for r in map(behind.runtime.residency.material, range(2))}
    assert paths == {"crimson.material.toml", "boxes.grey.material.toml"}
    assert session.document is front
    session.undo()
    paths = {Path(r.path).name for r in map(behind.runtime.residency.material, range(2))}
    assert paths == {"boxes.red.material.toml", "boxes.grey.material.toml"}
    assert not behind.dirty
    tabs.step(session, 1)
    assert session.document is behind


def test_each_document_that_it_concerns_can_undo_it_and_the_others_follow(session: Session, project: Path) -> None:
    red, crimson = (project / f"scenes/{n}.material.toml" for n in ("boxes.red", "crimson"))
    write_small_scene(project / "other")
    behind = opened(session, project / "scenes/boxes.scene.json")
    front = opened(session, project / "other/boxes.scene.json")
    before = everything(project)
    assert file_moves.move(session, red, crimson)
    behind.history.undo()
    assert everything(project) == before
    front.history.undo()
    assert everything(project) == before, "it was back already"
    behind.edit("nodes", "visible", (1,), (False,))
    with pytest.raises(InputError, match="unsaved changes"):
        front.history.redo()
    assert everything(project) == before
    behind.history.undo()
    front.history.redo()
    assert crimson.is_file()
    assert crimson in {Path(r.path) for r in map(behind.runtime.residency.material, range(2))}
    front.history.undo()
    assert {Path(r.path) for r in map(behind.runtime.residency.material, range(2))} >= {red}


def test_undo_says_what_is_gone_or_in_the_way_and_works_once_it_is_not(session: Session, project: Path) -> None:
    opened(session, project / "scenes/boxes.scene.json")
    todo, done = project / "notes/todo.txt", project / "notes/done.txt"
    assert file_moves.move(session, todo, done)
    session.edit("nodes", "visible", (1,), (False,))
    session.undo()
    done.rename(project / "elsewhere.txt")
    session.undo()
    assert "cannot be undone: done.txt is gone (put it back there" in session.ui.error_bar
    todo.write_text("other")
    (project / "elsewhere.txt").rename(done)
    session.undo()
    assert "todo.txt is taken" in session.ui.error_bar
    todo.unlink()
    session.undo()
    assert todo.read_text() == "paint"
    done.write_text("other")
    session.redo()
    assert "cannot be done again" in session.ui.error_bar
    assert todo.read_text() == "paint"


def test_undo_and_redo_keep_what_was_written_since(session: Session, project: Path) -> None:
    opened(session, project / "scenes/boxes.scene.json")
    write_small_scene(project / "other")
    red, crimson = (project / f"scenes/{n}.material.toml" for n in ("boxes.red", "crimson"))
    assert file_moves.move(session, red, crimson)
    late = project / "other/late.scene.json"
    late.write_text((project / "other/boxes.scene.json").read_text().replace("boxes.red", "../scenes/crimson"))
    session.undo()
    assert "../scenes/boxes.red.material.toml" in late.read_text(), "what came to refer to it follows"
    todo = project / "project.toml"
    todo.write_text(todo.read_text() + "# mine\n")
    late.write_text(late.read_text().replace('"plinth"', '"foot"'))
    session.redo()
    assert '"foot"' in late.read_text()
    assert "crimson.material.toml" in late.read_text()


@pytest.mark.skipif(sys.platform == "win32", reason="a process of that number may live there")
def test_the_log_says_what_of_an_interrupted_move_was_put_back(session: Session, project: Path) -> None:
    died = subprocess.run([sys.executable, "-c", "import os; print(os.getpid())"], capture_output=True, check=True)
    todo, done = project / "notes/todo.txt", project / "notes/done.txt"
    for door in (lambda: opened(session, project), lambda: file_moves.move(session, todo, project / "todo.txt")):
        intent = move_log.begin(project, {todo: done}, {}, [])
        intent.write_text(json.dumps({**json.loads(intent.read_text()), "process": int(died.stdout)}))
        todo.rename(done)
        session.messages.clear()
        door()
        said = [m.text for m in session.messages.snapshot()]
        assert any("interrupted move was put back: notes/todo.txt" in text for text in said), said
    assert (project / "todo.txt").is_file()


def test_what_was_locked_and_is_gone_is_not_in_the_way(session: Session, project: Path) -> None:
    document = opened(session, project / "scenes/boxes.scene.json")
    structure.add_empty(document, np.eye(4))
    document.locked.update(document.selection)
    session.undo()
    assert file_moves.move(session, project / "scenes/boxes.red.material.toml", project / "red.material.toml")
    assert not document.locked


def test_looking_at_an_earlier_state_moves_no_file(session: Session, project: Path) -> None:
    document = opened(session, project / "scenes/boxes.scene.json")
    assert file_moves.move(session, project / "scenes/boxes.red.material.toml", project / "red.material.toml")
    assert file_moves.move(session, project / "notes/todo.txt", project / "notes/done.txt")
    after = everything(project)
    with document.history.visiting(0):
        assert everything(project) == after
        names = {Path(r.path).name for r in map(document.runtime.residency.material, range(2))}
        assert "boxes.red.material.toml" in names
    assert everything(project) == after


def test_without_a_document_the_log_says_that_there_is_no_undo(session: Session, project: Path) -> None:
    assert file_moves.move(session, project / "notes/todo.txt", project / "notes/done.txt")
    assert "move it back" in session.messages.snapshot()[-1].text


def test_edits_round_a_move_survive_a_crash(session: Session, project: Path, tmp_path: Path) -> None:
    opened(session, project / "scenes/boxes.scene.json")
    session.edit("nodes", "translation", (2,), ((1.0, 2.0, 3.0),))
    assert session.save()
    assert file_moves.move(session, project / "scenes", project / "levels")
    session.edit("nodes", "name", (1,), ("base",))
    session.undo()
    session.undo()
    session.undo()  # the very first edit, from before the move
    assert file_moves.move(session, project / "notes/todo.txt", project / "notes/done.txt")
    session.edit("materials", "roughness", (0,), (0.125,))
    recovering.leave(session)
    again = real_session(tmp_path / "again")
    (left,) = journal.pending(tmp_path / "recovery")
    assert recovering.recover(again, left), again.ui.error_bar
    assert any(m.text.endswith("done to files: Rename todo.txt to done.txt") for m in again.messages.snapshot())
    document = again.document
    assert document is not None
    assert document.scene_path == project / "scenes/boxes.scene.json"
    assert document.runtime.scene.nodes.name[1] == "plinth"
    assert document.runtime.scene.nodes.translation[2].tolist() == [0.0, 0.0, 0.0]
    assert document.runtime.residency.material(0).asset.params["roughness"] == 0.125
    again.close_all()
