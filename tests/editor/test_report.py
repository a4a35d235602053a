"""What the Report panel says and plots, without a window: answers in words, settings to apply, the diagram."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fake_engine import FakeHost, FakeRuntime

from editor import report, work
from editor.builtin_operations import builtin_operations
from editor.document import Document
from editor.host import Resolved
from editor.preferences import Preferences
from editor.session import Session
from editor.work_precision import diagram, nearest, ticks
from engine.core.errors import LucarnaError
from engine.report.records import Point, Result, Timing


def point(setting: str, value: Any, ms: float, error: float, front: bool = False, spread: float = 0.01) -> Point:
    samples = [ms * (1.0 + spread * (i - 2)) for i in range(5)]
    timing = Timing(ms, ms * spread, 5, "wall", samples[1], samples[3])
    return Point({"scene": "s", "setting": setting, "value": value}, setting, {"flip": error}, timing, front=front,
                 samples=samples)  # fmt: skip


def result(*points: Point, **more: Any) -> Result:
    default = {"setting": "as it is", "value": ""}
    return Result("picture", "t", "m", "truth", "flip", "FLIP", default, None, list(points), 1, "wall", **more)


NOW = point("as it is", "", 10.0, 0.02, front=True)


def session() -> Session:
    made = Session(FakeHost(), Preferences(welcome_seen=True))
    made.save_preferences = False
    made.device = made.host.open_device(False)
    made.adopt(Document(Resolved(Path("/nowhere/a.glb"), Path("/nowhere/a.scene.json")), FakeRuntime()))
    return made


def texts(*points: Point) -> list[str]:
    return [a.text for a in report.answers(result(*points))]


def test_the_best_rate_wins() -> None:
    most, _, gain = report.answers(
        result(
            NOW, point("samples", 2, 12.0, 0.01), point("samples", 8, 30.0, 0.002), point("force_all", True, 15.0, 0.02)
        )
    )
    assert most.text == "Pass opaque: samples 2 removes 0.01 FLIP for 2 ms more, 0.005 FLIP per ms"
    assert most.knobs["value"] == 2
    assert gain.text.startswith("Nothing")
    assert gain.good


def test_what_is_better_in_both_is_the_gain() -> None:
    found = result(NOW, point("shadow_size", 1024, 6.0, 0.01, front=True))
    found.default_on_front, found.beaten_by = False, {"setting": "shadow_size", "value": 1024}
    most, dominated, gain = report.answers(found)
    assert most.text.startswith("Pass shadow_cascades: shadow size 1024 removes 0.01 FLIP and saves 4 ms")
    found.points[0] = point("as it is", "", 10.0, 0.02)
    assert dominated.text.startswith("The present one is: shadow size 1024 is no worse in anything")
    listed = report.answers(found)[1].text
    assert listed.endswith("1 of 2 are: as it is")
    assert gain.text.startswith("shadow size 1024: worth taking: 4 ms saved")
    assert gain.knobs["value"] == 1024


def test_only_trades_are_called_trades() -> None:
    assert texts(NOW, point("samples", 1, 4.0, 0.05))[2].startswith("Only by a trade. samples 1: a trade for speed")


def test_without_times_it_says_so() -> None:
    bare = result(Point({"setting": "as it is", "value": ""}, "a", {"flip": 0.1}))
    assert [a.question for a in report.answers(bare)] == ["What does it say?"]


def test_the_diagram_marks_front_and_present_setting_and_shows_errors_of_0() -> None:
    points = [NOW, point("samples", 2, 20.0, 0.0, front=True), point("samples", 1, 30.0, 0.1)]
    shown = diagram(points, "flip", lambda p: p is NOW, [5e-4, 1e-9])
    assert [s.name for s in shown.series] == ["as it is", "samples"]
    assert shown.current == (10.0, 0.02)
    assert shown.zero == pytest.approx(0.002)
    np.testing.assert_allclose(shown.front, [[10.0, 20.0], [0.02, 0.002]])
    assert shown.series[1].points[0].knobs["value"] == 2, "by time"
    low, high, bottom, top = shown.limits
    assert low < 10.0 < 30.0 < high
    assert 1e-5 < bottom < 5e-4, "the floor that is near is in, the one far below is not"
    assert top > 0.1
    assert nearest(shown, lambda x, y: (x, y * 100.0), (20.5, 0.2), 2.0) is points[1]
    assert nearest(shown, lambda x, y: (x, y * 100.0), (500.0, 0.2), 2.0) is None
    assert diagram([Point({}, "a", {"flip": 1.0})], "flip", lambda p: False).empty


def test_ticks_are_round_and_never_too_many() -> None:
    assert ticks(3.0, 30.0) == [5.0, 10.0, 20.0]
    assert ticks(0.9, 1.4) == [1.0, 1.2]
    assert ticks(0.01, 1e4) == [0.01, 0.1, 1.0, 10.0, 100.0, 1000.0, 10000.0]
    for decades in np.linspace(0.1, 12.0, 40):
        assert len(ticks(1.0, 10.0**decades)) <= 13


def test_applying_is_one_undo_that_leaves_the_document_clean() -> None:
    s = session()
    s.report_settings["picture"] = dict(s.settings.values())
    knobs = {"scene": "open scene", "setting": "exposure", "value": 2.0}
    assert report.settable(s, "picture", knobs) == {"exposure": 2.0}
    report.apply(s, "picture", knobs)
    assert s.document is not None
    assert s.settings.exposure == 2.0
    assert report.is_current(s, "picture", Point(knobs, "a", {}))
    assert not report.settable(s, "picture", knobs)
    assert s.document.history.undo_label == "Apply exposure 2"
    assert not s.document.dirty
    assert not s.document.overrides
    s.undo()
    assert s.settings.exposure == 0.0
    assert not s.document.dirty
    s.redo()
    s.set_visible((1,), False)
    assert s.document.dirty
    s.undo()
    assert not s.document.dirty
    s.undo()
    s.document.history.mark_saved()
    s.redo()
    assert not s.document.dirty


def test_the_advice_of_the_report_is_an_operation() -> None:
    s, operations = session(), builtin_operations()
    assert not operations.run("report.apply", s)
    s.report_settings["picture"] = dict(s.settings.values())
    s.reports["picture"] = result(NOW, point("exposure", 2.0, 4.0, 0.01, front=True))
    assert operations.run("report.apply", s)
    assert s.settings.exposure == 2.0
    operations.run("report.apply", s)
    assert "Nothing to gain" in s.ui.notice
    assert len(s.document.history.entries) == 1  # type: ignore[union-attr]  # it is open
    s.undo()
    assert s.settings.exposure == 0.0


def test_knobs_that_are_no_settings_cannot_be_applied() -> None:
    s = session()
    s.report_settings["x"] = dict(s.settings.values())
    assert report.settable(s, "x", {"bits": 8}) == {}
    assert report.settable(s, "not measured", {"exposure": 1.0}) == {}
    assert report.settings_of(s, "x", {"scene": "s", "exposure": 1.0}) == {**s.settings.values(), "exposure": 1.0}
    s.apply_settings({"exposure": 99.0})
    assert s.settings.exposure == 0.0, "a value out of range changes nothing"


class Counting:
    title, progress, text = "Counting", 0.0, ""

    def __init__(self, steps: int, fails: bool = False) -> None:
        self.left, self.fails, self.closed = steps, fails, 0

    def step(self, session: Session) -> bool:
        if self.fails:
            raise LucarnaError("cannot count")
        self.left -= 1
        return self.left > 0

    def close(self) -> None:
        self.closed += 1


def test_work_is_done_one_at_a_time_in_steps() -> None:
    s = session()
    first, second = Counting(3), Counting(1)
    assert work.start(s, first)
    assert not work.start(s, second)
    assert "Counting is not done" in s.ui.notice
    for _ in range(3):
        assert s.work is first
        s.poll()
    assert s.work is None
    assert first.closed == 1
    failing = Counting(1, fails=True)
    work.start(s, failing)
    s.poll()
    assert s.work is None
    assert failing.closed == 1
    assert "cannot count" in s.ui.error_bar
    work.start(s, second)
    s.close()
    assert s.work is None
    assert second.closed == 1
