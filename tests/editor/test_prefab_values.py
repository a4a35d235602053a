"""What an instance has of its own, value by value: listed as saving writes it, given back, applied; clips of prefabs in
the editor."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from animated_scene import write_animated_scene
from real_session import opened, real_session
from small_scene import write_small_scene

from editor import journal, prefab_values, prefabs, recovering, saving
from editor.animating import following
from editor.builtin_operations import builtin_operations
from editor.commands import structure
from editor.comparing.moment import before_last_edit
from editor.prefab_values import OwnValues, changes, own_values
from editor.session import Session
from engine.assets.lanim import read_lanim, write_lanim
from engine.assets.prefab import changed_fields
from engine.assets.scene_json import format_scene, read_scene


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("LUCARNA_CACHE", str(tmp_path / "cache"))
    root = tmp_path / "game"
    write_small_scene(root / "scenes")
    (root / "project.toml").write_text('[project]\nname = "Game"\nstart = "scenes/boxes.scene.json"\n')
    return root


@pytest.fixture
def session(tmp_path: Path) -> Iterator[Session]:
    session = real_session(tmp_path / "recovery")
    yield session
    session.sources.stop()
    session.close_all()


def row(document: Any, name: str, nth: int = 0) -> int:
    nodes = document.runtime.scene.nodes
    return [r for r in range(len(nodes.name)) if nodes.alive[r] and nodes.name[r] == name][nth]


def two(session: Session, project: Path) -> tuple[Any, Path]:
    """The stage of the small scene as a prefab, and a second instance of it, selected."""
    document = opened(session, project / "scenes/boxes.scene.json")
    document.select(row(document, "stage"))
    assert prefabs.make(session), session.ui.error_bar
    target = project / "prefabs/stage.scene.json"
    assert prefabs.place(session, target, np.eye(4)), session.ui.error_bar
    return document, target


def change_everything(session: Session, document: Any) -> None:
    """Of the second instance a name, a place, what shows, a light, a material, and a node less."""
    cube, lamp = row(document, "cube", 1), row(document, "lamp", 1)
    session.edit("nodes", "name", (cube,), ("die",))
    session.edit("nodes", "rotation", (cube,), ((0.0, 0.6, 0.0, 0.8),))
    session.edit("nodes", "visible", (cube,), (False,))
    session.edit("lights", "intensity", (1,), (99.0,))
    session.edit("lights", "color", (1,), ((1.0, 0.5, 0.25),))
    session.edit("nodes", "translation", (lamp,), ((0.1, 0.2, 0.3),))
    structure.delete(document, (row(document, "plinth", 1),))
    document.select(row(document, "stage", 1))


def slow(document: Any, root: int) -> Any:
    """The same by the whole scene, as it would be saved."""
    asset = saving.edited_scene(document.runtime, document.overrides)
    prefab = next(iter(document.prefabs.values()))
    return changed_fields(asset, prefabs.index_of(document, root), prefab)


def test_the_list_is_what_saving_writes(session: Session, project: Path) -> None:
    document, _ = two(session, project)
    root = prefab_values.selected_root(session)
    assert own_values(document, root) == []
    change_everything(session, document)
    root = prefab_values.selected_root(session)
    assert changes(document, root) == slow(document, root)
    assert [(v.node, v.field, v.here, v.there) for v in own_values(document, root)] == [
        ("stage/plinth", "removed", "", ""),
        ("stage/cube", "name", "die", "cube"),
        ("stage/cube", "place", "turned 0 0.6 0 0.8", "turned 0 0.3827 0 0.9239"),
        ("stage/cube", "visible", "no", "yes"),
        ("stage/lamp", "place", "0.1 0.2 0.3", "1 2 2"),
        ("stage/lamp", "light", "color 1 0.5 0.25, intensity 99", "color 1 1 1, intensity 8"),
    ]
    document.select(root)
    assert builtin_operations().run("edit.duplicate", session)
    copy = prefab_values.selected_root(session)
    assert copy != root
    assert changes(document, copy) == slow(document, copy)
    assert "place" in changes(document, copy)[0]["stage/cube"]
    session.undo()
    assert session.save()
    again = opened(real_session(), project / "scenes/boxes.scene.json")
    found = prefabs.root_of(again, row(again, "die"))
    assert changes(again, found) == slow(again, found) == changes(document, root)


def test_each_value_is_given_back_as_one_entry_that_is_undone(session: Session, project: Path) -> None:
    document, target = two(session, project)
    change_everything(session, document)
    text, operations = target.read_text(), builtin_operations()
    values = own_values(document, prefab_values.selected_root(session))
    for number, value in enumerate(values):
        before, entries = format_scene(saving.current_scene(document)), len(document.history.entries)
        assert operations.run("prefab.revert-value", session, node=value.node, field=value.field)
        left = own_values(document, prefab_values.selected_root(session))
        assert (value.node, value.field) not in [(v.node, v.field) for v in left]
        assert len(left) == len(values) - number - 1
        assert len(document.history.entries) == entries + 1
        session.undo()
        assert format_scene(saving.current_scene(document)) == before
        session.redo()
    assert target.read_text() == text
    nodes = document.runtime.scene.nodes
    cube = row(document, "cube", 1)
    assert nodes.visible[cube]
    assert np.allclose(nodes.rotation[cube], [0.0, 0.3826834, 0.0, 0.9238795], atol=1e-6)
    assert [document.runtime.scene.lights.asset(i).intensity for i in (0, 1)] == [8.0, 8.0]
    assert row(document, "plinth", 1) >= 0
    assert operations.run("prefab.revert-value", session, node="stage/cube", field="light")
    assert session.ui.notice == "stage/cube has no light of its own"


def test_one_value_is_applied_and_the_others_stay_its_own(session: Session, project: Path) -> None:
    document, target = two(session, project)
    change_everything(session, document)
    text, operations = target.read_text(), builtin_operations()
    assert operations.run("prefab.apply-value", session, node="stage/lamp", field="light")
    first = document.runtime.scene.lights.asset(0)
    assert (first.intensity, first.color) == (99.0, (1.0, 0.5, 0.25))
    assert read_scene(target).nodes[3].translation == (1.0, 2.0, 2.0), "the place is another value"
    document.select(row(document, "stage", 1))
    root = prefab_values.selected_root(session)
    kept = {"stage/cube": ["name", "place", "visible"], "stage/lamp": ["place"]}
    assert changes(document, root) == (kept, ["stage/plinth"])
    assert operations.run("prefab.apply-value", session, node="stage/cube", field="name")
    assert [n.name for n in read_scene(target).nodes] == ["stage", "plinth", "die", "lamp"]
    document.select(row(document, "stage", 1))
    root = prefab_values.selected_root(session)
    assert changes(document, root)[0]["stage/die"] == ["place", "visible"], "kept under the new name"
    assert operations.run("prefab.apply-value", session, node="stage/plinth", field="removed")
    assert [n.name for n in read_scene(target).nodes] == ["stage", "die", "lamp"]
    assert sum(name == "plinth" for name in document.runtime.scene.nodes.name) == 0
    for _ in range(3):
        session.undo()
    assert target.read_text() == text


def test_the_list_waits_for_the_end_of_a_drag(session: Session, project: Path) -> None:
    document, _ = two(session, project)
    root, lists = prefab_values.selected_root(session), OwnValues()
    assert lists.of(document, root) == []
    session.edit("nodes", "translation", (row(document, "cube", 1),), ((1.0, 0.0, 0.0),), gesture="drag")
    assert lists.of(document, root) == []
    session.end_gesture()
    session.edit("nodes", "visible", (row(document, "lamp", 1),), (False,))
    assert [v.field for v in lists.of(document, root)] == ["place", "visible"]


# --- clips ---


def test_a_placed_character_plays_and_nothing_of_it_is_its_own(session: Session, project: Path) -> None:
    figure = write_animated_scene(project / "figure")
    document = opened(session, project / "scenes/boxes.scene.json")
    assert not moves(session)
    operations = builtin_operations()
    assert operations.run("prefab.place", session, path=figure, at=(1.0, 0.0, 0.0))
    root = document.primary
    assert moves(session), "the bar comes with what moves"
    assert [clip.name for clip in document.runtime.clips] == ["figure/walk", "figure/run", "figure/wave"]
    hips, rest = row(document, "hips"), document.runtime.scene.nodes.rotation[row(document, "hips")].copy()
    session.seek(0.3)
    assert not np.allclose(document.runtime.scene.nodes.rotation[hips], rest)
    assert changes(document, root) == ({}, []) == slow(document, root), "a pose is no value of its own"
    session.edit("nodes", "translation", (row(document, "skin"),), ((0.0, 0.5, 0.0),))
    assert changes(document, root)[0] == {"figure/skin": ["place"]}
    assert operations.run("edit.duplicate", session)
    session.seek(0.5)
    poses = document.runtime.scene.nodes.rotation[[row(document, "hips", i) for i in range(2)]]
    assert np.array_equal(poses[0], poses[1]), "a copy of an instance is one, too"
    for _ in range(3):
        session.undo()
    assert not moves(session)
    session.redo()
    assert moves(session)
    session.seek(0.7)
    saved = format_scene(saving.current_scene(document))
    session.seek(0.1)
    assert format_scene(saving.current_scene(document)) == saved, "what is saved does not depend on the time"


def test_placed_characters_play_after_a_crash_and_when_opened_again(
    session: Session, project: Path, tmp_path: Path
) -> None:
    figure = write_animated_scene(project / "figure")
    document = opened(session, project / "scenes/boxes.scene.json")
    for x in (1.0, 2.0):
        assert builtin_operations().run("prefab.place", session, path=figure, at=(x, 0.0, 0.0))
    session.seek(0.3)
    expected = pose(document)
    assert np.array_equal(expected[0], expected[1])
    recovering.leave(session)
    again = real_session()
    (left,) = journal.pending(tmp_path / "recovery")
    assert recovering.recover(again, left), again.ui.error_bar
    again.tick(0.0)
    again.seek(0.3)
    assert np.array_equal(pose(again.document), expected)
    assert again.save()
    again.close_all()
    fresh = real_session()
    found = opened(fresh, project / "scenes/boxes.scene.json")
    fresh.seek(0.3)
    assert np.array_equal(pose(found), expected)
    assert following.drive_of(fresh) == "clips"
    fresh.close_all()


def test_a_clip_of_a_prefab_that_is_written_again_is_taken_up(session: Session, project: Path) -> None:
    figure = write_animated_scene(project / "figure")
    document = opened(session, project / "scenes/boxes.scene.json")
    assert builtin_operations().run("prefab.place", session, path=figure, at=(1.0, 0.0, 0.0))
    assert session.save()
    session.prefabs_at = 0.0
    session.poll()
    assert document.runtime.duration == 1.0
    path = project / "figure/figure.walk.lanim"
    clip = read_lanim(path)
    for channel in clip.channels:
        channel.times = channel.times * np.float32(3.0)
    write_lanim(path, clip)
    os.utime(path, ns=(1, path.stat().st_mtime_ns + 1_000_000))
    session.prefabs_at = 0.0
    session.poll()
    assert "changed" in session.ui.notice
    assert document.runtime.duration == 3.0
    assert not document.dirty
    before = before_last_edit(session)
    assert before is not None
    assert before.label == "Before: Prefab figure.scene.json changed", "it can be compared with"
    session.undo()
    assert document.runtime.duration == 1.0


def moves(session: Session) -> bool:
    return session.playback.available


def pose(document: Any) -> Any:
    nodes = document.runtime.scene.nodes
    return np.array([nodes.rotation[row(document, "hips", i)] for i in range(2)])
