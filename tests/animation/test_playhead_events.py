"""Every marker exactly once: against a count in exact fractions, over random seeks, loops, speeds and pauses."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from engine.animation.animator import Animator
from engine.animation.events import MOST_CROSSINGS, Fired, Marker, crossings
from engine.animation.graph import single
from engine.animation.playhead import LOOP, ONCE, PING_PONG, Playheads, mode_number
from engine.animation.sampler import ClipSampler
from engine.assets.clip import ClipAsset
from engine.core.errors import InputError
from tests.animation.crowd import channel, rig

MARKERS = np.array([0.0, 0.1, 0.25, 0.25, 0.5, 0.999, 1.0])
NUMBERS = np.arange(len(MARKERS))


def position(heads: Playheads, i: int) -> Fraction:
    """Where playhead i is on its endless line, exactly."""
    return int(heads.turn[i]) * (2 if heads.mode[i] == PING_PONG else 1) + Fraction(float(heads.phase[i]))


def occurrences(mode: int, phase: float, low: Fraction, high: Fraction) -> list[Fraction]:
    """Every place in [low, high] on the endless line at which a marker lies."""
    at, period = Fraction(phase), 2 if mode == PING_PONG else 1
    if mode == ONCE:
        return [at] if low <= at <= high else []
    places = {at % period} | ({Fraction(2.0 - phase) % period} if mode == PING_PONG else set())
    first, last = int(low // period) - 1, int(high // period) + 1
    return [k * period + p for k in range(first, last + 1) for p in places if low <= k * period + p <= high]


def expected(mode: int, start: Fraction, end: Fraction, fresh: bool) -> list[tuple[Fraction, int]]:
    """(place, marker) in the order they are passed; the start only counts when fresh."""
    found = []
    for number, phase in enumerate(MARKERS):
        if end > start:
            places = [p for p in occurrences(mode, float(phase), start, end) if p > start]
        else:
            places = [p for p in occurrences(mode, float(phase), end, start) if p < start]
        here = start if mode == ONCE else start % (2 if mode == PING_PONG else 1)
        back = mode == PING_PONG and 0.0 < phase < 1.0 and Fraction(2.0 - float(phase)) == here
        if fresh and (Fraction(float(phase)) == here or back):
            places.append(start)
        found += [(p, number) for p in places]
    return sorted(found, key=lambda item: (abs(item[0] - start), item[1]))


@pytest.mark.parametrize("mode", ["loop", "once", "ping-pong"])
def test_every_marker_exactly_once_over_10_000_seeks_speeds_and_pauses(mode: str) -> None:
    rng = np.random.default_rng(mode_number(mode))
    count = 20
    heads = Playheads(count, mode)
    number, total, seeks = mode_number(mode), 0, 0
    for _ in range(500):
        choice = rng.integers(0, 10, count)
        speed = np.select(
            [choice < 3, choice < 5, choice < 6, choice < 7],
            [rng.uniform(0, 0.05, count), rng.uniform(-0.05, 0, count), rng.uniform(-3, 3, count),
             rng.choice([0.25, 0.5, 1.0, -0.25, -1.0, 2.0], count)], 0.0,
        )  # fmt: skip
        speed = np.where(choice == 9, 100.0 * 0.016 * rng.choice([-1.0, 1.0], count), speed)
        if rng.random() < 0.7:
            who = np.flatnonzero(rng.random(count) < 0.6)
            seeks += len(who)
            heads.seek(rng.choice([0.0, 0.1, 0.25, 0.3, 1.0, 7.25, -0.5], len(who)), who)
        before = [position(heads, i) for i in range(count)]
        fresh = heads.fresh.copy()
        fired = crossings(step := heads.advance(speed), MARKERS, NUMBERS, np.arange(count))
        assert fired.left_out == 0
        for i in range(count):
            after = position(heads, i)
            got = fired.marker[fired.character == i].tolist()
            want = [m for _, m in expected(number, before[i], after, bool(fresh[i]))] if step.moved[i] else []
            assert sorted(got) == sorted(want), (mode, float(before[i]), float(after), bool(fresh[i]))
            total += len(got)
    assert total > 10_000  # the test has tested something
    assert seeks > 3_500


@pytest.mark.parametrize("mode", ["loop", "once", "ping-pong"])
def test_the_event_log_of_a_crowd_over_10_000_seeks(mode: str) -> None:
    """Through the animator, as scripts get them: clip of 1 s, all times in 64ths, so that counting is exact."""
    times = np.array([0.0, 0.125, 0.5, 0.5, 0.984375, 1.0])
    sampler = ClipSampler(ClipAsset("c", [channel(0, "translation", [0, 1], np.eye(3)[:2])]), rig(1))
    graph = single(sampler, mode)
    graph.clips[0].markers.extend(Marker(str(i), float(t)) for i, t in enumerate(times))
    count, rng = 100, np.random.default_rng(mode_number(mode) + 10)
    animator = Animator(graph, count)
    animator.update(0.0)
    heads, period = animator.machine.heads, 2.0 if mode == "ping-pong" else 1.0
    log, seeks = 0, 0
    for _ in range(90):
        who = np.flatnonzero(rng.random(count) < 0.5)
        animator.seek(rng.integers(-64, 128, len(who)) / 64.0, who)
        seeks += len(who)
        animator.speed[:] = rng.choice([1.0, -1.0, 0.25, 100.0, -100.0, 0.0], count)
        for _ in range(2):  # the second goes on where the first has stopped
            start, fresh = heads.turn * period + heads.phase, heads.fresh.copy()
            fired = animator.update(float(rng.integers(0, 24)) / 16.0)
            end = heads.turn * period + heads.phase
            got = np.zeros((count, len(times)), np.int64)
            np.add.at(got, (fired.character, fired.marker), 1)
            moves = animator.speed != 0.0
            moves &= (end != start) | (heads.fresh != fresh)  # a once-clip at its end is asked to move, and stands
            np.testing.assert_array_equal(got, _passed(start, end, fresh & moves, times, mode))
            assert fired.left_out == 0
            log += len(fired)
    assert seeks > 4_000  # of each of three modes
    assert log > 10_000


def _passed(a: np.ndarray, b: np.ndarray, here: np.ndarray, times: np.ndarray, mode: str) -> np.ndarray:
    """How often each marker lies in (a, b], in [b, a) on the way back, and at `a` itself where that is still due."""
    result = np.zeros((len(a), len(times)), np.int64)
    for number, time in enumerate(times.tolist()):
        places = {time} if mode == "once" else {time % 1.0} if mode == "loop" else {time, (2.0 - time) % 2.0}
        for place in places:
            if mode == "once":
                on, back, at = (a < place) & (place <= b), (b <= place) & (place < a), a == place
            else:
                period = 1.0 if mode == "loop" else 2.0
                x, y = (a - place) / period, (b - place) / period
                on, back = np.floor(y) - np.floor(x), np.ceil(x) - np.ceil(y)
                at = (x == np.floor(x)) & (mode != "loop" or time < 1.0)  # the end is not due at the start
            result[:, number] += np.where(b > a, on, np.where(b < a, back, 0)).astype(np.int64) + (at & here)
    return result


def test_order_is_the_order_of_passing() -> None:
    heads = Playheads(2)
    heads.seek(0.3)
    fired = crossings(heads.advance([1.3, -1.3]), MARKERS[[1, 4]], np.array([1, 4]), np.array([7, 8]))
    assert fired.marker[fired.character == 7].tolist() == [4, 1, 4]
    assert fired.marker[fired.character == 8].tolist() == [1, 4, 1]
    assert fired.direction.tolist() == [1, 1, 1, -1, -1, -1]


def test_cutting_a_run_into_steps_changes_nothing() -> None:
    rng = np.random.default_rng(5)
    phases, numbers = rng.uniform(0, 1, 6), np.arange(6)
    for mode in ("loop", "once", "ping-pong"):
        heads, log = Playheads(1, mode), []
        for by in rng.uniform(0, 0.2, 400):
            log += crossings(heads.advance(by), phases, numbers, np.zeros(1, np.int64)).marker.tolist()
        whole = Playheads(1, mode)
        way = float(heads.turn[0] * (2 if mode == "ping-pong" else 1) + heads.phase[0])
        once = crossings(whole.advance(way), phases, numbers, np.zeros(1, np.int64)).marker.tolist()
        assert log == once


def test_turning_back_on_a_marker_does_not_pass_it_again() -> None:
    heads, at, one = Playheads(1), np.array([0.5]), np.zeros(1, np.int64)
    assert len(crossings(heads.advance(0.5), at, one, one)) == 1
    assert len(crossings(heads.advance(0.0), at, one, one)) == 0
    assert len(crossings(heads.advance(-0.25), at, one, one)) == 0
    assert len(crossings(heads.advance(0.25), at, one, one)) == 1


def test_a_once_clip_passes_its_end_once() -> None:
    heads, at, one = Playheads(1, "once"), np.array([1.0]), np.zeros(1, np.int64)
    log = [len(crossings(heads.advance(0.4), at, one, one)) for _ in range(6)]
    assert log == [0, 0, 1, 0, 0, 0]
    assert heads.phase[0] == 1.0


def test_the_row_time_huge_and_not_finite() -> None:
    heads = Playheads(5)
    step = heads.advance([1e12 + 0.25, -1e12 - 0.25, np.nan, np.inf, 1e300])
    assert heads.phase[:2].tolist() == [0.25, 0.75]
    assert heads.turn[:2].tolist() == [10**12, -(10**12) - 1]
    assert step.moved.tolist() == [1, -1, 0, 0, 1]
    assert ((heads.phase >= 0.0) & (heads.phase < 1.0)).all()
    # a year of 60 Hz frames on: a small step still moves by exactly its size
    heads.advance(2.0**-20)
    assert heads.phase[0] == 0.25 + 2.0**-20


def test_too_many_crossings_are_counted_not_stored() -> None:
    heads = Playheads(2)
    fired = crossings(heads.advance([1e9, 3.0]), np.array([0.5]), np.zeros(1, np.int64), np.arange(2))
    assert len(fired) == MOST_CROSSINGS
    assert fired.left_out == 10**9 + 3 - MOST_CROSSINGS


def test_ping_pong_turns_back() -> None:
    heads, seen = Playheads(1, "ping-pong"), []
    for _ in range(9):
        seen.append(float(heads.fraction[0]))
        heads.advance(0.25)
    assert seen == [0.0, 0.25, 0.5, 0.75, 1.0, 0.75, 0.5, 0.25, 0.0]


def test_bad_modes_and_markers_say_so() -> None:
    with pytest.raises(InputError, match="unknown play mode 'bounce'"):
        Playheads(1, "bounce")
    with pytest.raises(InputError, match="marker 'x' at -1"):
        Marker("x", -1.0)
    with pytest.raises(InputError, match="marker 'x' at nan"):
        Marker("x", float("nan"))
    assert len(Fired().joined([Fired(), Fired()])) == 0
    assert LOOP == 0
