"""Camera bookmarks: edits of the document that undo takes back, saved with the scene."""

from __future__ import annotations

from pathlib import Path

import pytest
from fake_engine import FakeHost, FakeRuntime

from editor.bookmark_table import BOOKMARKS, of_asset
from editor.builtin_operations import builtin_operations
from editor.camera_controls import OrbitCamera
from editor.document import Document
from editor.host import Resolved
from editor.preferences import Preferences
from editor.saving import edited_scene
from editor.session import Session
from engine.assets.scene import BookmarkAsset
from engine.assets.scene_json import parse_scene, write_scene
from engine.core.errors import FormatError

OPS = builtin_operations()
THERE = OrbitCamera((1.0, 2.0, 3.0), 0.5, -0.25, 0.125, 4.0, 0.75, True)


def a_session() -> Session:
    made = Session(FakeHost(), Preferences(welcome_seen=True))
    made.save_preferences = False
    made.document = Document(Resolved(Path("thing.glb"), Path("thing.scene.json")), FakeRuntime())
    return made


def test_set_recall_undo_and_forget() -> None:
    session = a_session()
    assert not OPS.run("view.bookmark-2", session), "there is none yet"
    session.camera = THERE
    OPS.run("view.set-bookmark-2", session)
    session.camera = OrbitCamera()
    OPS.run("view.bookmark-2", session)
    assert session.camera == THERE
    document = session.document
    assert document is not None
    assert [e.describe() for e in document.history.entries] == ["Set bookmark 2"]
    assert document.dirty, "it belongs to the scene"
    OPS.run("view.forget-bookmark-2", session)
    assert document.bookmarks == {}
    session.undo()
    assert document.bookmarks == {2: THERE}
    session.undo()
    assert document.bookmarks == {}


@pytest.mark.parametrize("restructured", [False, True])
def test_they_are_saved_and_come_back(tmp_path: Path, restructured: bool) -> None:
    session = a_session()
    document = session.document
    assert document is not None
    session.camera = THERE
    for number in (3, 1):
        OPS.run(f"view.set-bookmark-{number}", session)
    if restructured:
        OPS.run("add.empty", session)
    OPS.run("view.forget-bookmark-3", session)
    asset = edited_scene(document.runtime, document.overrides)
    write_scene(tmp_path / "a.scene.json", asset)
    again = parse_scene((tmp_path / "a.scene.json").read_text(encoding="utf-8"), "a")
    assert [mark.number for mark in again.bookmarks] == [1]
    assert of_asset(again) == {1: THERE}
    assert BOOKMARKS in (tmp_path / "a.scene.json").read_text(encoding="utf-8")


def test_one_that_cannot_be_is_refused_with_its_place() -> None:
    text = '{"schema": "lucarna.scene/1", "name": "a", "bookmarks": [{"number": 1, "distance": -1.0}]}'
    with pytest.raises(FormatError, match=r"bookmarks\[0\]"):
        parse_scene(text, "a")


def test_a_scene_without_them_says_nothing_of_them(tmp_path: Path) -> None:
    session = a_session()
    assert session.document is not None
    write_scene(tmp_path / "a.scene.json", edited_scene(session.document.runtime, {}))
    assert "bookmarks" not in (tmp_path / "a.scene.json").read_text(encoding="utf-8")
    assert BookmarkAsset() == BookmarkAsset(number=1)
