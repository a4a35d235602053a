"""State A beside the present one: what it shows, what it costs, that it changes nothing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from fake_engine import FakeHost

from editor.builtin_operations import builtin_operations
from editor.comparing.comparing import DIFFERENCE, OFF, ONLY_A, WIPE
from editor.comparing.numbers import FlipAside
from editor.preferences import Preferences
from editor.session import Session

OPS = builtin_operations()


@pytest.fixture
def session() -> Session:
    made = Session(FakeHost(), Preferences(welcome_seen=True))
    made.save_preferences = False
    made.device = made.host.open_device(attach=False)
    made.comparing.aside = FlipAside(lambda a, b: 0.25)
    made.open(Path("/nowhere/thing.glb"))
    assert made.job is not None
    made.job.wait(20)
    made.poll()
    assert made.document is not None
    made.playback.playing = False
    frame(made)
    return made


def frame(session: Session) -> np.ndarray:
    """What the viewport does in a frame; B's pixels."""
    session.comparing.update(session, 64, 48)
    session.image.update(session, 64, 48)
    session.comparing.after(session)
    return np.array(session.image.pixels())


def roughness(session: Session, value: float) -> None:
    session.edit("materials", "roughness", (0,), (value,))


def test_a_keeps_the_state_and_b_goes_on(session: Session) -> None:
    roughness(session, 0.25)
    before = frame(session)
    OPS.run("compare.take", session)
    roughness(session, 0.75)
    session.settings.exposure = 4.0
    OPS.run("compare.wipe", session)
    after = frame(session)
    a = session.comparing.a
    assert a is not None
    assert (a.pixels == before).all()
    assert (after != before).any()
    difference = session.comparing.difference
    assert difference is not None
    assert difference.largest == np.abs(after.astype(int) - before.astype(int)).max()


def test_looking_at_a_changes_nothing(session: Session) -> None:
    document = session.document
    assert document is not None
    OPS.run("compare.take", session)
    roughness(session, 0.75)
    session.apply_settings({"exposure": 2.0})
    session.settings.exposure = 3.0  # by hand after it, as sliders of the strip do
    document.select(1)
    told: list[str] = []
    document.history.listener = lambda what, edit, gesture: told.append(what)
    entries, overrides = document.history.entries, dict(document.overrides)
    OPS.run("compare.wipe", session)
    frame(session)
    assert session.comparing.a is not None
    assert session.comparing.a.revision == 1
    assert (document.history.entries, document.overrides) == (entries, overrides)
    assert document.selection == (1,)
    assert session.settings.exposure == 3.0
    assert document.runtime.residency.records[0].asset.params["roughness"] == 0.75
    assert told == [], "nothing of it is journalled"


def test_a_is_rendered_once_until_the_camera_moves(session: Session) -> None:
    OPS.run("compare.take", session)
    OPS.run("compare.wipe", session)
    for _ in range(3):
        frame(session)
    a = session.comparing.a
    assert a is not None
    assert a.revision == 1
    session.frame_all()
    frame(session)
    renders = session.image.renders
    frame(session)
    assert a.revision == 2
    assert session.image.renders == renders, "and then both rest"


def test_a_drag_is_not_torn_in_two(session: Session) -> None:
    OPS.run("compare.take", session)
    OPS.run("compare.wipe", session)
    for value in (0.2, 0.3, 0.35):
        session.edit("materials", "roughness", (0,), (value,), gesture="drag")
        session.frame_all()
        session.camera = type(session.camera)(yaw=value)
        frame(session)
    session.end_gesture()
    assert session.document is not None
    assert len(session.document.history.entries) == 1


def test_a_lost_branch_keeps_its_last_picture(session: Session) -> None:
    roughness(session, 0.25)
    OPS.run("compare.take", session)
    OPS.run("compare.wipe", session)
    frame(session)
    a = session.comparing.a
    assert a is not None
    kept = np.array(a.pixels)
    session.undo()
    roughness(session, 0.9)
    session.camera = type(session.camera)(yaw=1.0)
    frame(session)
    assert a.frozen
    assert (a.pixels == kept).all()
    OPS.run("compare.go-back", session)
    assert "cut" in session.ui.notice


def test_going_back_swaps_the_two(session: Session) -> None:
    OPS.run("compare.take", session)
    roughness(session, 0.75)
    session.settings.exposure = 4.0
    b = frame(session)
    OPS.run("compare.go-back", session)
    assert (frame(session) != b).any()
    assert session.settings.exposure == 0.0
    OPS.run("compare.go-back", session)
    assert (frame(session) == b).all()


def test_holding_without_a_shows_the_state_before_the_last_edit(session: Session) -> None:
    OPS.run("compare.hold", session)
    assert not session.comparing.held
    assert "Nothing" in session.ui.notice
    before = frame(session)
    session.apply_settings({"exposure": 5.0})
    frame(session)
    OPS.run("compare.hold", session)
    frame(session)
    shown = session.comparing.shown_moment(session)
    assert session.comparing.showing(session) == ONLY_A
    assert shown is not None
    assert (shown.pixels == before).all()
    session.comparing.release()
    assert session.comparing.showing(session) == OFF


def test_flip_comes_later_and_is_of_these_two(session: Session) -> None:
    OPS.run("compare.difference", session)
    frame(session)
    assert session.comparing.flip == 0.0, "equal ones need no work"
    session.settings.exposure = 6.0
    frame(session)
    for _ in range(200):
        if session.comparing.flip is not None:
            break
        frame(session)
    assert session.comparing.flip == 0.25
    assert session.comparing.showing(session) == DIFFERENCE
    OPS.run("compare.difference", session)
    assert session.comparing.showing(session) == OFF


def test_measuring_renders_both_in_turn(session: Session) -> None:
    OPS.run("compare.take", session)
    OPS.run("compare.measure", session)
    for _ in range(100):
        session.poll()
    assert session.work is None
    assert session.comparing.times() == (3.0, 3.0)


def test_a_failing_render_ends_the_comparison(session: Session) -> None:
    OPS.run("compare.wipe", session)
    assert session.document is not None
    session.document.runtime.broken = True
    session.comparing.update(session, 32, 32)
    assert session.comparing.showing(session) == OFF
    assert "cannot be shown" in session.ui.notice


def test_every_tab_has_its_own_a(session: Session) -> None:
    OPS.run("compare.take", session)
    OPS.run("compare.wipe", session)
    frame(session)
    first, a = session.document, session.comparing.moment(session)
    session.open(Path("/nowhere/other.glb"))
    for _ in range(400):
        session.poll()
        if session.document is not None and session.document is not first:
            break
        session.job.join(0.01) if session.job is not None and hasattr(session.job, "join") else None
    assert session.document is not first
    assert session.comparing.moment(session) is None
    assert session.comparing.showing(session) == OFF
    OPS.run("compare.take", session)
    other = session.comparing.a
    OPS.run("document.next", session)
    assert session.document is first
    assert session.comparing.moment(session) is a
    assert session.comparing.showing(session) == WIPE
    frame(session)
    OPS.run("document.next", session)
    assert session.comparing.moment(session) is other
    assert session.comparing.showing(session) == OFF
    session.close()
    session.close()
    assert not session.comparing._behind, "nothing keeps a closed document"


def test_a_goes_with_its_document(session: Session) -> None:
    OPS.run("compare.wipe", session)
    assert session.comparing.showing(session) == WIPE
    session.close()
    assert session.comparing.a is None
    assert not OPS.run("compare.take", session)
