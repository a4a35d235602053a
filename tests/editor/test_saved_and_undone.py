"""What shows is what is saved, also after a saved edit was undone, and undo shows what was there whatever was saved."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest
from real_session import opened, real_session
from small_scene import write_small_scene

from editor import file_moves, journal, recovering
from editor.session import Session
from engine.assets.material_toml import read_material


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    (tmp_path / "project.toml").write_text('[project]\nname = "Game"\nstart = "scenes/boxes.scene.json"\n')
    (tmp_path / "note.txt").write_text("")
    return write_small_scene(tmp_path / "scenes")


@pytest.fixture
def session(tmp_path: Path) -> Iterator[Session]:
    session = real_session(tmp_path / "recovery")
    yield session
    session.close_all()


def grey(scene: Path) -> tuple[float, ...]:
    params = read_material(scene.parent / "boxes.grey.material.toml").params
    return params["roughness"], params.get("specular", 1.0)


def shown(session: Session) -> tuple[float, ...]:
    assert session.document is not None
    values = session.document.tables["materials"]
    return tuple(values.read(name, (0,))[0] for name in ("roughness", "specular"))


def test_undoing_what_was_saved_and_saving_again_writes_what_was_there(session: Session, scene: Path) -> None:
    opened(session, scene)
    session.edit("materials", "roughness", (0,), (0.125,))
    session.edit("materials", "specular", (0,), (0.25,))
    assert session.save()
    assert grey(scene) == (0.125, 0.25)
    session.undo()
    session.undo()
    assert session.save()
    assert shown(session) == (0.5, 1.0)
    assert grey(scene) == (0.5, 1.0)
    session.redo()
    assert session.save()
    assert grey(scene) == (0.125, 1.0)


def test_an_earlier_scene_under_the_document_is_not_what_was_saved_of_a_later_one(
    session: Session, scene: Path, tmp_path: Path
) -> None:
    document = opened(session, scene)
    red = scene.with_name("boxes.red.material.toml")
    assert file_moves.move(session, red, scene.with_name("crimson.material.toml"))
    session.edit("materials", "specular", (0,), (0.25,))
    assert session.save()
    session.undo()
    session.undo()
    assert shown(session) == (0.5, 1.0)
    document.runtime.hot_reload.interval = 0.0
    for _ in range(3):
        session.shaders.reload(session, force=False)
        session.poll()
    assert shown(session) == (0.5, 1.0), "the file that changed is our own"
    recovering.leave(session)
    again = real_session(tmp_path / "again")
    (left,) = journal.pending(tmp_path / "recovery")
    assert recovering.recover(again, left)
    assert shown(again) == (0.5, 1.0), "a crash loses no undo of what was saved"
    assert again.save()
    assert grey(scene) == (0.5, 1.0)
    again.close_all()


def test_what_stood_over_a_new_base_is_recovered_and_undone(session: Session, scene: Path, tmp_path: Path) -> None:
    opened(session, scene)
    session.edit("materials", "roughness", (0,), (0.125,))
    recovering.leave(session)
    (left,) = journal.pending(tmp_path / "recovery")
    lines = [json.loads(line) for line in left.path.read_text("utf-8").splitlines()]
    for line in lines:
        if line.get("c", {}).get("column") == "roughness":  # as a journal writes it that begins anew
            line["over"], line["c"]["before"] = "base", [None]
    left.path.write_text("".join(json.dumps(line) + "\n" for line in lines), "utf-8")
    again = real_session(tmp_path / "again")
    assert recovering.recover(again, left)
    assert shown(again) == (0.125, 1.0)
    assert again.document is not None
    again.document.history.go_to(0)
    assert shown(again) == (0.5, 1.0), "as the base says, which the line did not know"
    again.close_all()
