"""Undo brings back exactly what was there, also what nobody had said; what cannot be saved is not taken."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from animated_scene import animated_session

from editor.commands import structure
from editor.document import Document
from editor.saving import edited_scene
from editor.session import Session
from engine.assets.scene import CameraAsset, LightAsset
from engine.assets.scene_json import format_scene
from engine.core.errors import InputError, LucarnaError


@pytest.fixture
def session(tmp_path: Path) -> Iterator[Session]:
    made = animated_session(tmp_path)
    yield made
    made.close()


@pytest.fixture
def document(session: Session) -> Document:
    assert session.document is not None
    return session.document


def saved(document: Document) -> str:
    return format_scene(edited_scene(document.runtime, document.overrides))


def test_undo_after_a_clip_moved_a_node_leaves_no_pose_behind(session: Session, document: Document) -> None:
    before = saved(document)
    session.seek(0.25)
    document.edit("nodes", "translation", [1], [(5.0, 5.0, 5.0)])
    assert saved(document) != before
    session.undo()
    assert saved(document) == before


def test_undo_brings_back_what_the_user_had_said_and_not_the_pose(session: Session, document: Document) -> None:
    document.edit("nodes", "rotation", [3], [(1.0, 0.0, 0.0, 0.0)])
    before = saved(document)
    session.seek(0.25)
    document.edit("nodes", "rotation", [3], [(0.0, 1.0, 0.0, 0.0)])
    session.undo()
    assert saved(document) == before


def test_a_part_said_before_the_whole_stays_before_it(document: Document) -> None:
    document.edit("nodes", "scale", [5], [(2.0, 2.0, 2.0)])
    whole = ((1.0, 2.0, 3.0), (0.0, 0.0, 0.0, 1.0), (4.0, 4.0, 4.0), None)
    document.edit("nodes", "local", [5], [whole])
    before = saved(document)
    document.edit("nodes", "scale", [5], [(9.0, 9.0, 9.0)])
    document.history.undo()
    assert saved(document) == before


@pytest.mark.parametrize(
    ("table", "column", "value"),
    [
        ("environment", "kind", "jungle"), ("environment", "intensity", -1.0), ("look", "exposure", float("nan")),
        ("nodes", "scale", (1.0, float("inf"), 1.0)), ("nodes", "rotation", (0.0, 0.0, 0.0, 0.0)),
        ("nodes", "name", 7), ("nodes", "colour", 1.0), ("materials", ":queue", "later"),
        ("materials", ":features", 3.0),
        ("materials", "texture:base_color_map", ("a", "b")),
    ],
)  # fmt: skip
def test_what_a_scene_file_could_not_say_is_refused(document: Document, table: str, column: str, value: Any) -> None:
    before = saved(document)
    with pytest.raises(LucarnaError):
        document.edit(table, column, [0], [value])
    assert not document.history.entries
    assert saved(document) == before


def test_values_that_exclude_each_other_are_refused_for_all_rows(document: Document) -> None:
    import numpy as np

    for zfar in (0.0, 1.0):
        structure.add_camera(document, np.eye(4), CameraAsset(yfov=0.5, znear=0.1, zfar=zfar))
    entries = len(document.history.entries)
    with pytest.raises(InputError, match="does not go with zfar"):
        document.edit("cameras", "znear", [0, 1], [2.0, 2.0])
    assert document.tables["cameras"].read("znear", [0, 1]) == (0.1, 0.1), "the first did not keep it either"
    assert len(document.history.entries) == entries


def test_an_edit_of_the_animation_does_not_start_it(session: Session, document: Document) -> None:
    from editor.animating.editing import AnimationEditor

    AnimationEditor(session).create()
    document.edit("animation", "drive", [0], ["clips"])
    AnimationEditor(session).add_marker("m", 0.5)
    assert document.runtime.drive == "clips"
    session.undo()
    assert document.runtime.drive == "clips"


def test_a_light_that_is_clamped_saves_what_shows(document: Document) -> None:
    import numpy as np

    structure.add_light(document, np.eye(4), LightAsset("point"))
    document.edit("lights", "intensity", [0], [0.1])
    assert '"intensity": 0.1,' in saved(document), "and not the float32 next to it"


def test_a_drag_that_ends_where_it_began_has_said_nothing(session: Session, document: Document) -> None:
    before = saved(document)
    session.seek(0.25)
    (pose,) = document.tables["nodes"].read("rotation", [1])
    for value in ((0.0, 1.0, 0.0, 0.0), pose):
        document.edit("nodes", "rotation", [1], [value], gesture="drag")
    session.end_gesture()
    assert not document.history.entries
    assert saved(document) == before
