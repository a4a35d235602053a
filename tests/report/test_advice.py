"""Advice on settings whose times and errors are known."""

from __future__ import annotations

from typing import Any

import pytest

from engine.report.advice import KINDS, Advice, advise, dominated, totals
from engine.report.records import Point, Result, Timing


def point(setting: str, error: float, ms: float, scene: str = "s") -> Point:
    samples = [ms * (1.0 + 0.01 * (i % 3 - 1)) for i in range(11)]
    return Point({"scene": scene, "setting": setting}, setting, {"flip": error}, Timing(ms, 0.01, 11), samples=samples)


def result(*points: Point) -> Result:
    return Result("picture", "t", "m", "t", "flip", "FLIP", {"setting": "now"}, None, list(points), 1, "here")


@pytest.mark.parametrize(
    ("error", "ms", "kind"),
    [
        (0.10, 5.0, "take"),  # as wrong, faster
        (0.05, 10.0, "take"),  # less wrong, no slower
        (0.20, 5.0, "cheaper"),
        (0.05, 20.0, "better"),
        (0.10, 20.0, "dominated"),
        (0.20, 10.0, "dominated"),
        (0.10, 10.0, "same"),
    ],
)
def test_kinds(error: float, ms: float, kind: str) -> None:
    (found,) = advise(result(point("now", 0.1, 10.0), point("other", error, ms)))
    assert (found.kind, found.knobs["setting"]) == (kind, "other")
    assert found.ms_saved == pytest.approx(10.0 - ms)
    assert found.error_removed == pytest.approx(0.1 - error)
    assert found.kind in KINDS
    assert found.sure == (ms != 10.0)
    assert ("below noise" in found.text) == (ms == 10.0)


def test_what_to_take_comes_first_then_the_best_trade() -> None:
    found = advise(
        result(point("now", 0.1, 10.0), point("slow", 0.05, 30.0), point("dear", 0.05, 20.0), point("take", 0.1, 5.0),
               point("bad", 0.3, 12.0))
    )  # fmt: skip
    assert [a.knobs["setting"] for a in found] == ["take", "dear", "slow", "bad"]
    assert found[1].per_ms == pytest.approx(0.05 / 10.0)
    assert totals(found) == (pytest.approx(5.0), pytest.approx(0.0))


def test_scenes_are_not_compared_with_each_other() -> None:
    found: list[Advice] = advise(
        result(point("now", 0.1, 10.0), point("x", 0.1, 5.0), point("now", 0.1, 1.0, "t"), point("x", 0.1, 2.0, "t"))
    )
    assert {(a.knobs["scene"], a.kind) for a in found} == {("s", "take"), ("t", "dominated")}


def test_no_default_no_advice() -> None:
    assert advise(result(point("x", 0.1, 1.0))) == []
    made: Any = result(point("now", 0.1, 1.0), point("x", 0.2, 2.0))
    made.points[0].front = True
    assert [k["setting"] for k in dominated(made)] == ["x"]
