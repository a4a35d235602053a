"""How long the window sleeps, by what goes on; the thread that looks at files meanwhile; interrupts. No window."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from fake_engine import FakeHost

from editor import waking
from editor.file_watch import FileWatch
from editor.idling import AWAKE, BAR_FPS, BEHIND_FPS, CARET, LOOK_AGAIN, NEVER, Idling
from editor.interrupts import Interrupts
from editor.opening import Job
from editor.preferences import Preferences
from editor.session import Session

PATIENCE = 10.0


@pytest.fixture
def session() -> Session:
    return Session(FakeHost(), Preferences())


@pytest.fixture
def idling() -> Idling:
    made = Idling()
    made.began(100.0, woken=False)
    return made


@pytest.fixture
def woken() -> Iterator[threading.Event]:
    """Set whenever a thread wakes the window."""
    event = threading.Event()
    waking.connect(event.set)
    yield event
    waking.connect(None)
    waking.take()


def test_nothing_goes_on(session: Session, idling: Idling) -> None:
    assert idling.pause(session, 100.0, moving=False, caret=False) == NEVER


def test_who_moves_something_waits_for_nothing(session: Session, idling: Idling) -> None:
    assert idling.pause(session, 100.0, moving=True, caret=False) == 0.0


def test_a_caret_blinks_and_a_panel_gets_its_frame(session: Session, idling: Idling) -> None:
    assert idling.pause(session, 100.0, moving=False, caret=True) == CARET
    assert idling.pause(session, 100.0, moving=False, caret=True, asked=0.25) == 0.25
    idling.sight = "behind"
    assert idling.pause(session, 100.0, moving=False, caret=True) == NEVER


def test_an_event_keeps_it_awake_for_a_moment(session: Session, idling: Idling) -> None:
    assert idling.pause(session, 100.0, moving=False, caret=False) == NEVER
    idling.began(200.0, woken=False)
    assert idling.pause(session, 200.0, moving=False, caret=False) == 0.0
    assert idling.pause(session, 200.0 + AWAKE, moving=False, caret=False) == NEVER


def test_a_frame_that_came_without_a_sleep_is_no_event(session: Session, idling: Idling) -> None:
    assert idling.pause(session, 100.0, moving=False, caret=False) == NEVER
    idling.began(100.01, woken=False, waited=False)
    assert idling.pause(session, 100.01, moving=False, caret=False) == NEVER


def test_a_timer_that_ran_off_is_no_event(session: Session, idling: Idling) -> None:
    assert idling.pause(session, 100.0, moving=False, caret=False, asked=0.5) == 0.5
    idling.began(100.5, woken=False)
    assert idling.pause(session, 100.5, moving=False, caret=False) == NEVER


def test_a_thread_s_word_brings_some_frames_and_later_looks(session: Session, idling: Idling) -> None:
    idling.began(200.0, woken=True)
    assert idling.pause(session, 200.0, moving=False, caret=False) == 0.0
    for _ in range(3):
        idling.began(200.0, woken=False)
    assert idling.pause(session, 200.0, moving=False, caret=False) == pytest.approx(LOOK_AGAIN[0])
    idling.began(200.0 + LOOK_AGAIN[0], woken=False)
    assert idling.pause(session, 200.0 + LOOK_AGAIN[0], moving=False, caret=False) == pytest.approx(
        LOOK_AGAIN[1] - LOOK_AGAIN[0]
    )


def test_what_plays_goes_by_who_looks(session: Session, idling: Idling) -> None:
    session.tools.turning = True
    assert idling.pause(session, 100.0, moving=False, caret=False) == 0.0
    idling.sight = "behind"
    assert idling.pause(session, 100.0, moving=False, caret=False) == 1.0 / BEHIND_FPS
    session.preferences.in_background = "stop"
    assert not idling.plays(session)
    assert idling.pause(session, 100.0, moving=False, caret=False) == NEVER
    session.preferences.in_background = "full"
    assert idling.pause(session, 100.0, moving=False, caret=False) == 0.0
    idling.sight = "away"
    assert not idling.plays(session)
    assert idling.pause(session, 100.0, moving=False, caret=False) == NEVER


def test_pictures_that_settle_count_only_where_they_are_made(session: Session, idling: Idling) -> None:
    session.image.settling = True
    assert idling.pause(session, 100.0, moving=False, caret=False) == NEVER
    session.image.update(session, 8, 8)
    assert idling.pause(session, 100.0, moving=False, caret=False) == 0.0


def test_a_job_draws_its_bar_and_wakes_the_window_at_its_end(
    session: Session, idling: Idling, woken: threading.Event, tmp_path: Path
) -> None:
    gate = threading.Event()
    session.importing = Job(tmp_path, "waits", lambda progress: gate.wait(PATIENCE))  # type: ignore[assignment]  # any
    assert idling.pause(session, 100.0, moving=False, caret=False) == 1.0 / BAR_FPS
    woken.clear()
    gate.set()
    assert woken.wait(PATIENCE)
    assert session.importing is not None
    assert session.importing.done


def test_a_file_that_is_followed_wakes_the_window(tmp_path: Path, woken: threading.Event) -> None:
    first, second = tmp_path / "a.txt", tmp_path / "b.txt"
    for file in (first, second):
        file.write_text("1")
    watch = FileWatch()
    assert watch.follow([first, second])
    assert not watch.follow([second, first]), "no new ones"
    first.write_text("changed")
    assert woken.wait(PATIENCE)
    assert not watch.follow([second])
    woken.clear()
    first.write_text("changed again")
    assert not woken.wait(0.8), "nobody follows it any more"
    second.unlink()
    assert woken.wait(PATIENCE)
    watch.stop()


@pytest.mark.skipif(sys.platform == "win32", reason="a process cannot send itself Ctrl+C alone there")
def test_an_interrupt_wakes_the_window_and_the_second_one_ends(woken: threading.Event) -> None:
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored in a job of a script's background
    try:
        interrupts = Interrupts()
        with interrupts.listening():
            os.kill(os.getpid(), signal.SIGINT)
            end = time.monotonic() + PATIENCE
            while not interrupts.signal and time.monotonic() < end:
                time.sleep(0.01)
            assert interrupts.signal == signal.SIGINT
            assert woken.wait(PATIENCE)
            assert signal.getsignal(signal.SIGINT) is signal.default_int_handler, "the next one is nobody's to catch"
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGINT, before)


@pytest.mark.skipif(sys.platform == "win32", reason="a process cannot send itself Ctrl+C alone there")
def test_an_interrupt_that_is_ignored_stays_so() -> None:
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        interrupts = Interrupts()
        with interrupts.listening():
            os.kill(os.getpid(), signal.SIGINT)
            assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
        assert interrupts.signal == 0
    finally:
        signal.signal(signal.SIGINT, before)
