"""The transport: in and out points, modes, and each marker exactly once whatever happens."""

from __future__ import annotations

import numpy as np
import pytest

from engine.animation.transport import Transport
from engine.core.errors import InputError


def test_time_runs_between_the_points_in_each_mode() -> None:
    for mode, expected in (("loop", 1.5), ("once", 3.0), ("ping-pong", 2.5)):
        transport = Transport(1.0, 3.0, mode)
        transport.advance(2.5)
        assert transport.time == pytest.approx(expected), mode
    transport = Transport(1.0, 3.0, "ping-pong")
    transport.advance(2.5)
    assert transport.backward
    assert Transport(2.0, 2.0).time == 2.0
    with pytest.raises(InputError, match="points"):
        Transport().set_range(0.0, float("inf"))


def test_moving_the_points_or_changing_the_mode_keeps_the_time() -> None:
    transport = Transport(0.0, 4.0)
    transport.seek(1.5)
    transport.set_range(1.0, 2.0)
    assert transport.time == pytest.approx(1.5)
    transport.mode = "ping-pong"
    assert transport.time == pytest.approx(1.5)
    transport.set_range(3.0, 4.0)
    assert transport.time == 3.0


def test_only_markers_between_the_points_are_passed() -> None:
    transport = Transport(1.0, 2.0)
    transport.set_markers(np.array([0.5, 1.0, 1.5, 2.0, 2.5]), list("abcde"))
    names = [name for name, _, _ in transport.advance(1.0)]
    assert sorted(names) == ["b", "b", "c", "d"]  # fresh at its start, and round to it again with its twin, the end


def test_each_marker_once_over_10000_random_seeks_loops_speeds_and_pauses() -> None:
    """Against a count in exact arithmetic of how often the unwrapped place passes each marker."""
    rng = np.random.default_rng(7)
    marks = np.array([0.0, 0.125, 0.7, 1.3, 1.999])
    names = [str(i) for i in range(len(marks))]
    for mode in ("loop", "ping-pong", "once"):
        transport = Transport(0.0, 2.0, mode)
        transport.set_markers(marks, names)
        place, fresh, direction = 0.0, True, 1  # of the unfolded way
        for _ in range(3400):
            action = rng.integers(0, 6)
            if action == 0:
                place = float(rng.choice([*marks, rng.uniform(0.0, 2.0)]))
                place = min(place, 2.0 if mode != "loop" else np.nextafter(2.0, 0.0))
                transport.seek(place)
                fresh = True
                continue
            if action == 1:
                transport.speed = float(rng.choice([1.0, -1.0, 100.0, -100.0, 0.01, 0.0]))
                continue
            seconds = float(rng.choice([0.0, 1.0 / 60.0, 0.3, 2.0, 5.0]))
            told = transport.advance(seconds)
            by = seconds * transport.speed
            end = min(max(place + by, 0.0), 2.0) if mode == "once" else place + by
            period = {"loop": 2.0, "ping-pong": 4.0, "once": np.inf}[mode]
            expected = {
                name: _passed(mark, place, end, period, mode, fresh) for name, mark in zip(names, marks, strict=True)
            }
            counted = {name: sum(1 for n, _, _ in told if n == name) for name in names}
            close = any(_near(mark, place, end, period, mode) for mark in marks)
            if not close:  # where rounding alone decides which step has it, the sums below must still agree
                assert counted == expected, (mode, place, end)
            if by != 0.0:
                fresh, direction = False, np.sign(by)
            assert all(d == direction for _, _, d in told)
            # go on from where the transport says it is: the same fold
            folded = transport.time
            place = 4.0 - folded if mode == "ping-pong" and transport.backward else folded


def test_steps_that_join_up_pass_what_one_long_step_passes() -> None:
    rng = np.random.default_rng(3)
    marks = np.sort(rng.uniform(0.0, 2.0, 20))
    for mode in ("loop", "ping-pong", "once"):
        whole, parts = Transport(0.0, 2.0, mode), Transport(0.0, 2.0, mode)
        for transport in (whole, parts):
            transport.set_markers(marks, [str(i) for i in range(20)])
        steps = rng.uniform(0.0, 0.2, 400)
        one_by_one = [told[0] for s in steps for told in parts.advance(float(s))]
        at_once = [told[0] for told in whole.advance(float(steps.sum()))]
        assert one_by_one == at_once, mode


def _places(mark: float, low: float, high: float, period: float, mode: str) -> np.ndarray:
    """Where on the unfolded way the marker stands, from below low to above high."""
    if mode == "once":
        return np.array([mark])
    turns = np.arange(np.floor(low / period) - 1, np.ceil(high / period) + 2) * period
    places = turns + mark
    if mode == "ping-pong" and 0.0 < mark < 2.0:
        places = np.concatenate([places, turns + 4.0 - mark])
    return np.sort(places)


def _passed(mark: float, start: float, end: float, period: float, mode: str, fresh: bool) -> int:
    if start == end:
        return 0
    places = _places(mark, min(start, end), max(start, end), period, mode)
    if end > start:
        return int(((places > start) & (places <= end)).sum() + (fresh and (places == start).any()))
    return int(((places < start) & (places >= end)).sum() + (fresh and (places == start).any()))


def _near(mark: float, start: float, end: float, period: float, mode: str) -> bool:
    places = _places(mark, min(start, end), max(start, end), period, mode)
    return bool((np.abs(places[:, None] - np.array([start, end])[None, :]) < 1e-9).any())
