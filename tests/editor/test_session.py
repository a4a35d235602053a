"""The session without a window: opening, failing, editing, looking, saving, idling."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fake_engine import FakeHost

from editor.builtin_operations import builtin_operations
from editor.preferences import Preferences
from editor.session import Session
from engine.core.findings import Severity


@pytest.fixture
def session() -> Session:
    session = Session(FakeHost(), Preferences())
    session.device = session.host.open_device(attach=False)
    session.save_preferences = False
    return session


def opened(session: Session, name: str = "thing.glb") -> Any:
    session.open(Path("/nowhere") / name)
    if session.job is not None:
        session.job.wait(10)
    session.poll()
    return session.document


def test_opening_takes_over_findings_camera_clock_and_recent_files(session: Session) -> None:
    document = opened(session)
    assert document.name == "thing.glb"
    assert session.messages.counts()[Severity.WARNING] == 1
    assert session.playback.playing
    assert session.camera.eye() == pytest.approx([0, 0.5, 4])
    assert session.preferences.recent == ["/nowhere/thing.glb"]
    assert not document.dirty


@pytest.mark.parametrize("name", ["bad.glb", "broken.glb"])
def test_what_cannot_be_opened_leaves_the_document(session: Session, name: str) -> None:
    document = opened(session)
    opened(session, name)
    assert session.document is document
    assert not document.runtime.closed
    assert session.ui.error_bar
    assert session.failure is not None
    assert session.messages.counts()[Severity.ERROR] == 1


def test_a_cancelled_job_ends_without_a_word_of_error(session: Session) -> None:
    session.open(Path("/nowhere/slow.glb"))
    assert session.job is not None
    session.job.cancel()
    session.job.wait(10)
    session.poll()
    assert session.job is None
    assert session.document is None
    assert not session.ui.error_bar


def test_a_defect_in_an_importer_is_an_error_of_that_file(session: Session, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(path: Path, progress: Any) -> Any:
        raise ZeroDivisionError("a defect")

    monkeypatch.setattr(session.host, "resolve", broken)
    opened(session)
    assert session.document is None
    assert "ZeroDivisionError" in session.ui.error_bar


def test_a_file_that_is_open_comes_to_the_front_and_is_read_anew_when_asked(session: Session) -> None:
    first = opened(session)
    second = opened(session, "other.glb")
    assert not first.runtime.closed
    opened(session)
    assert session.document is first
    session.open(first.source, again=True)
    assert session.job is not None
    session.job.wait(10)
    session.poll()
    assert first.runtime.closed
    assert [tab.document for tab in session.tabs] == [session.document, second]


def test_unsaved_changes_are_asked_about_first(session: Session) -> None:
    document = opened(session)
    session.set_visible((1,), False)
    opened(session, "other.glb")
    assert session.ui.after_discard is None
    session.open(document.source, again=True)
    assert session.job is None
    assert session.ui.after_discard is not None
    assert session.document is document
    assert session.asked_about == ["thing.glb"]
    assert not session.request_quit()


def test_a_picture_is_made_once_per_change(session: Session) -> None:
    opened(session)
    session.playback.playing = False
    image = session.image
    for _ in range(5):
        image.update(session, 320, 180)
    assert image.renders == 1
    changes = (
        lambda: session.edit("materials", "roughness", (0,), (0.9,)),
        lambda: session.set_visible((1,), False),
        session.undo,
        lambda: setattr(session.settings, "exposure", 2.0),
        lambda: session.seek(1.0),
        lambda: builtin_operations().run("view.top", session),
        lambda: session.edit("look", "exposure", (0,), (1.0,)),
    )
    for i, change in enumerate(changes):
        change()
        for _ in range(3):
            image.update(session, 320, 180)
        assert image.renders == 2 + i, f"change {i}"
    image.update(session, 321, 180)
    assert image.renders == 2 + len(changes)


def test_a_failing_render_is_said_once_and_keeps_the_picture(session: Session) -> None:
    document = opened(session)
    frame = session.image.update(session, 64, 64)
    document.runtime.broken = True
    session.settings.exposure = 1.0
    for _ in range(5):
        assert session.image.update(session, 64, 64) is frame
    assert session.messages.counts()[Severity.ERROR] == 1
    assert "cannot draw" in session.image.error
    document.runtime.broken = False
    session.settings.exposure = 0.0
    assert session.image.update(session, 64, 64) is not frame
    assert session.image.error == ""


def test_the_device_frame_is_closed_after_a_failing_render(session: Session) -> None:
    document = opened(session)
    document.runtime.broken = True
    session.image.update(session, 64, 64)
    assert not session.device.open_frame


def test_a_bad_value_is_logged_and_changes_nothing(session: Session) -> None:
    from engine.core.errors import InputError

    document = opened(session)

    def refuse(*_: Any) -> None:
        raise InputError("not finite")

    document.runtime.scene.nodes.set_translation = refuse
    session.edit("nodes", "translation", (1,), ((np.nan, 0, 0),))
    assert not document.dirty
    assert session.messages.counts()[Severity.ERROR] == 1


def test_frame_selection_looks_at_the_selected_subtree(session: Session) -> None:
    document = opened(session)
    document.select(1)  # the body, with the lid above it
    session.frame_selection()
    assert session.camera.target == pytest.approx((0, 0.5, 0))
    document.select(2)
    session.frame_selection()
    assert session.camera.target == pytest.approx((0, 1, 0))
    document.select(-1)
    session.frame_selection()
    assert session.camera.target == pytest.approx((0, 0.5, 0))


def test_frame_a_node_without_a_mesh(session: Session) -> None:
    opened(session).select(3)
    session.frame_selection()
    assert np.isfinite(session.camera.world_from_camera()).all()
    assert session.camera.distance < 10


def test_pick_selects_and_empty_space_deselects(session: Session) -> None:
    document = opened(session)
    session.image.update(session, 64, 64)
    document.runtime.picked = 2
    assert session.pick(0.5, 0.5) == 2
    assert document.selection == (2,)
    document.runtime.picked = 1
    session.pick(0.5, 0.5, toggle=True)
    assert document.selection == (2, 1)
    document.runtime.picked = -1
    session.pick(0.1, 0.1)
    assert document.selection == ()


def test_time_runs_only_while_it_plays(session: Session) -> None:
    document = opened(session)
    session.tick(0.5)
    assert document.runtime.time == pytest.approx(0.5)
    session.playback.toggle()
    session.tick(0.5)
    assert document.runtime.time == pytest.approx(0.5)


def test_coarse_pictures_only_while_moving_and_slow(session: Session) -> None:
    opened(session)
    image = session.image
    image.update(session, 64, 64)
    image.frame.stats.total_ms = 200.0
    assert image.resolution(session) == 1.0
    session.interacting = True
    assert image.resolution(session) == 0.5
    image.frame.stats.total_ms = 1000.0
    assert image.resolution(session) == 0.5, "no flicker within one movement"
    session.interacting = False
    assert image.resolution(session) == 1.0
    session.interacting = True
    assert image.resolution(session) == 0.25
    session.interacting = False
    image.resolution(session)
    image.frame.stats.total_ms = 10.0
    session.interacting = True
    assert image.resolution(session) == 1.0, "fast enough"
    session.preferences.adaptive_resolution = False
    image.frame.stats.total_ms = 200.0
    assert image.resolution(session) == 1.0


def test_every_operation_can_be_asked_and_run_without_a_document(session: Session) -> None:
    for operation in builtin_operations():
        if operation.enabled(session) and not operation.asks:
            operation.run(session)


def test_every_operation_runs_with_a_document(session: Session) -> None:
    document = opened(session)
    operations = builtin_operations()
    for operation in operations:
        if operation.id in {"file.quit", "file.close", "file.reload", "file.save", "file.screenshot"}:
            continue
        if operation.asks:  # scripts and the palette tell it
            continue
        document.select(2)
        operations.run(operation.id, session)
    assert session.document is document


def test_hide_shows_again_and_show_all(session: Session) -> None:
    document = opened(session)
    operations, visible = builtin_operations(), document.runtime.scene.nodes.visible
    document.selection = (1, 2)
    operations.run("edit.hide", session)
    assert visible.tolist() == [True, False, False, True, True]
    operations.run("edit.hide", session)
    assert visible.all()
    session.set_visible((0,), False)
    operations.run("edit.show-all", session)
    assert visible.all()
    session.undo()
    assert not visible[0]
