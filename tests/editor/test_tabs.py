"""Several documents: each has its own history, camera, settings, clock and journal."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from fake_engine import FakeHost

from editor import dropping, journal, recovering, tabs
from editor.builtin_operations import builtin_operations
from editor.preferences import Preferences
from editor.session import Session


@pytest.fixture
def session(tmp_path: Path) -> Iterator[Session]:
    session = Session(FakeHost(), Preferences())
    session.device = session.host.open_device(attach=False)
    session.save_preferences = False
    session.recovery_folder = tmp_path
    yield session
    session.close_all()


def opened(session: Session, name: str = "thing.glb", folder: Path = Path("/nowhere")) -> Any:
    session.open(folder / name)
    if session.job is not None:
        session.job.wait(10)
    session.poll()
    return session.document


def test_each_has_its_own_history_camera_settings_and_clock(session: Session) -> None:
    first = opened(session)
    session.set_visible((1,), False)
    session.apply_settings({"exposure": 2.0})
    session.camera = type(session.camera)(distance=7.0)
    session.playback.time = 0.5
    second = opened(session, "other.glb")
    assert session.settings.exposure == 2.0, "a new one begins with the look at hand"
    session.apply_settings({"exposure": -1.0})
    session.undo()
    session.undo()
    assert second.runtime.scene.nodes.visible[1]
    assert not first.runtime.scene.nodes.visible[1], "undo stays in its document"
    session.apply_settings({"exposure": -3.0})
    tabs.step(session, 1)
    assert session.document is first
    assert (session.settings.exposure, session.camera.distance, session.playback.time) == (2.0, 7.0, 0.5)
    session.undo()
    session.undo()
    assert first.runtime.scene.nodes.visible[1]
    tabs.step(session, -1)
    assert session.settings.exposure == -3.0


def test_closing_one_shows_its_neighbour_and_ends_its_journal(session: Session, tmp_path: Path) -> None:
    documents = [opened(session, f"{name}.glb") for name in "abc"]
    assert len(list(tmp_path.glob("*.journal"))) == 3
    tabs.show(session, 1)
    session.close()
    assert session.document is documents[2]
    assert documents[1].runtime.closed
    assert len(list(tmp_path.glob("*.journal"))) == 2
    session.close_all()
    assert session.document is None
    assert not session.tabs
    assert not list(tmp_path.glob("*.journal"))


def test_every_document_of_a_dead_session_is_restored(session: Session, tmp_path: Path) -> None:
    for name in ("a.glb", "b.glb"):
        opened(session, name, tmp_path)
        session.edit("nodes", "name", (1,), (f"of {name}",))
    recovering.leave(session)
    again = Session(FakeHost(), Preferences())
    again.device = again.host.open_device(attach=False)
    again.save_preferences = False
    left = journal.pending(tmp_path)
    assert sorted(r.name for r in left) == ["a.glb", "b.glb"]
    for recovery in left:
        assert recovering.recover(again, recovery), again.ui.error_bar
    assert {t.document.name: t.document.runtime.scene.nodes.name[1] for t in again.tabs} == {
        "a.glb": "of a.glb", "b.glb": "of b.glb",
    }  # fmt: skip
    assert all(t.document.dirty for t in again.tabs)


def test_quitting_asks_about_all_of_them(session: Session) -> None:
    for name in ("a.glb", "b.glb"):
        opened(session, name)
        session.set_visible((1,), False)
    assert session.unsaved == ["a.glb", "b.glb"]
    assert not session.request_quit()
    assert session.asked_about == ["a.glb", "b.glb"]
    session.discard()
    assert session.request_quit()


def test_closing_the_others_keeps_what_is_unsaved_until_asked(session: Session) -> None:
    first = opened(session, "a.glb")
    session.set_visible((1,), False)
    opened(session, "b.glb")
    kept = opened(session, "c.glb")
    assert builtin_operations().run("document.close-others", session)
    assert [t.document for t in session.tabs] == [first, kept]
    assert session.document is first, "what is asked about is in front"
    assert session.ui.after_discard is not None
    session.discard()
    session.ui.after_discard()
    assert [t.document for t in session.tabs] == [kept]


def test_dropped_files_open_one_after_the_other_and_a_panorama_lights_the_last(session: Session) -> None:
    dropping.take(session, [Path("/nowhere") / n for n in ("a.glb", "sky.hdr", "b.glb", "notes.txt")])
    for _ in range(4):
        if session.job is not None:
            session.job.wait(10)
        session.poll()
    assert [t.document.name for t in session.tabs] == ["a.glb", "b.glb"]
    assert session.document is not None
    environment = session.document.runtime.scene.environment
    assert (environment.kind, Path(environment.path).name) == ("image", "sky.hdr")
    assert session.document.history.undo_label == "Light with sky.hdr"
    session.undo()
    assert environment.kind != "image"
    dropping.take(session, [Path("/nowhere/notes.txt")])
    assert "notes.txt" in " ".join(m.line() for m in session.messages.snapshot())
