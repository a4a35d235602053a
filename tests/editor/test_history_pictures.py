"""Pictures of the history: when one is taken, and how many there are. Drawing them is test_instances_window's."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from fake_engine import FakeHost
from real_session import real_session

from editor import history_operations, history_pictures
from editor.commands.command import Command
from editor.commands.history import History
from editor.history_pictures import LIMIT, HistoryPictures
from engine.core.errors import DeviceError

FRAME = SimpleNamespace(color=object())


class Drawn(HistoryPictures):
    """Draws nothing; `made`: textures made, `alive`: not released."""

    def __init__(self) -> None:
        super().__init__()
        self.made = 0
        self.alive: set[int] = set()

    def _draw(self, device: Any, source: Any) -> Any:
        self.made += 1
        self.alive.add(self.made)
        number = self.made
        desc = SimpleNamespace(width=256, height=128)
        return SimpleNamespace(native=number, desc=desc, release=lambda: self.alive.discard(number))


@pytest.fixture
def session() -> Any:
    document = SimpleNamespace(history=History(lambda edit: None))
    preferences = SimpleNamespace(history_pictures=True)
    notes: list[str] = []
    return SimpleNamespace(
        document=document, preferences=preferences, null_pictures=False, camera="here", device=None,
        device_frame=nullcontext, messages=SimpleNamespace(warn=notes.append), notes=notes,
    )  # fmt: skip


def edit(session: Any, value: int, gesture: str | None = None) -> None:
    session.document.history.do(Command("nodes", "x", (0,), (value - 1,), (value,)), gesture)


def test_each_state_is_taken_once_and_again_when_it_has_come_to_rest(session: Any) -> None:
    pictures = Drawn()
    for _ in range(5):
        pictures.take(session, FRAME, resting=False)
    assert pictures.made == 1
    edit(session, 1)
    pictures.take(session, FRAME, resting=False)
    for _ in range(5):
        pictures.take(session, FRAME, resting=True)
    assert (pictures.made, len(pictures.alive)) == (3, 2), "the first of the two was replaced"
    session.document.history.undo()
    for resting in (False, True, False):
        pictures.take(session, FRAME, resting=resting)
    assert len(pictures) == 2
    history = session.document.history
    assert pictures.native(session.document, history.undone[0])[1] == 0.5
    assert pictures.native(session.document, None)[0]
    other: Any = SimpleNamespace()
    assert pictures.native(other, None) == (0, 0.0)


def test_a_picture_stays_when_the_camera_has_gone_on(session: Any) -> None:
    pictures = Drawn()
    pictures.take(session, FRAME, resting=False)
    session.camera = "there"
    pictures.take(session, FRAME, resting=True)
    assert pictures.made == 1


def test_a_drag_is_taken_at_its_end_and_nothing_without_pictures(session: Any) -> None:
    pictures = Drawn()
    for value in range(1, 9):
        edit(session, value, "drag")
        pictures.take(session, FRAME, resting=False)
    assert pictures.made == 0
    session.document.history.end_gesture()
    pictures.take(session, FRAME, resting=True)
    assert pictures.made == 1
    edit(session, 10)
    for name in ("null_pictures", "document"):
        kept = getattr(session, name)
        setattr(session, name, None if name == "document" else True)
        pictures.take(session, FRAME, resting=True)
        setattr(session, name, kept)
    session.preferences.history_pictures = False
    pictures.take(session, FRAME, resting=True)
    pictures.take(session, None, resting=True)
    assert pictures.made == 1


def test_there_are_no_more_than_the_limit_and_none_of_what_is_forgotten(session: Any) -> None:
    pictures, history = Drawn(), session.document.history
    pictures.take(session, FRAME, resting=True)
    for value in range(1, LIMIT + 20):
        pictures.native(session.document, None)  # it is shown
        edit(session, value)
        pictures.take(session, FRAME, resting=True)
    assert len(pictures) == len(pictures.alive) == LIMIT
    assert pictures.native(session.document, None)[0], "what is shown stays"
    assert pictures.native(session.document, history.entries[0]) == (0, 0.0)
    history.go_to(10)
    edit(session, 500)  # cuts a branch off
    pictures.take(session, FRAME, resting=True)
    assert len(pictures) == len(pictures.alive) <= 12
    pictures.forget(session.document)
    assert not pictures.alive


def test_a_device_that_cannot_draw_them_is_told_of_once(session: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    pictures = HistoryPictures()

    def refuse(device: Any, source: Any) -> Any:
        raise DeviceError("no memory")

    monkeypatch.setattr(pictures, "_draw", refuse)
    for value in range(1, 4):
        edit(session, value)
        pictures.take(session, FRAME, resting=True)
    assert session.notes == ["The history shows no pictures: no memory"]


def test_a_place_in_the_history_is_gone_to_by_number() -> None:
    session = real_session()
    session.host, session.device = FakeHost(), FakeHost().device
    session.open(Path("/nowhere/thing.glb"))
    assert session.job is not None
    session.job.wait(20)
    session.poll()
    for value in range(1, 6):
        session.edit("nodes", "translation", (2,), ((float(value), 0.0, 0.0),), label=f"Move {value}")
    history_operations.go_to(session, 2)
    assert session.document is not None
    assert session.document.runtime.scene.nodes.translation[2].tolist() == [2.0, 0.0, 0.0]
    assert session.ui.notice == "After: Move 2"
    history_operations.go_to(session, 99)
    assert len(session.document.history.entries) == 5
    history_operations.go_to(session, 0)
    assert session.ui.notice == "As it was opened"
    assert history_pictures.WIDTH * history_pictures.HEIGHT * 4 * LIMIT <= 21 << 20
    session.close_all()
