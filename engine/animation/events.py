"""Markers on clips, and who passed them: each crossing is reported exactly once, whatever the speed and direction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from engine.animation.playhead import LOOP, PING_PONG, Step
from engine.core.errors import InputError

F8 = NDArray[np.float64]
I8 = NDArray[np.int64]

#: One step reports no more crossings one by one than this; `Fired.left_out` counts the rest.
MOST_CROSSINGS = 100_000


@dataclass(frozen=True, slots=True)
class Marker:
    """`name` at `time` seconds of its clip. Raises InputError for a time that is negative or not finite."""

    name: str
    time: float

    def __post_init__(self) -> None:
        if not 0.0 <= self.time < float("inf"):
            raise InputError(f"marker {self.name!r} at {self.time} s", hint="a marker stands at 0 s or later")


@dataclass(slots=True)
class Fired:
    """Crossings in the order they happened in for each character: `character`, `marker` (number in `names`) and
    `direction` (1 forward, -1 back), i8[e]. `left_out`: how many more there were than one step reports."""

    character: I8 = field(default_factory=lambda: np.zeros(0, np.int64))
    marker: I8 = field(default_factory=lambda: np.zeros(0, np.int64))
    direction: I8 = field(default_factory=lambda: np.zeros(0, np.int64))
    left_out: int = 0

    def __len__(self) -> int:
        return len(self.character)

    def joined(self, others: Sequence[Fired]) -> Fired:
        """These and the others', each in its order."""
        parts = [self, *others]
        return Fired(
            np.concatenate([p.character for p in parts]), np.concatenate([p.marker for p in parts]),
            np.concatenate([p.direction for p in parts]), sum(p.left_out for p in parts),
        )  # fmt: skip


def crossings(step: Step, phases: F8, numbers: I8, characters: I8) -> Fired:
    """What `step` (of m playheads) crossed of the markers `numbers` i8[e] at `phases` f8[e] in [0,1].

    A step forward from a to b crosses what lies in (a, b], a step back what lies in [b, a); from a fresh place also
    what lies at a itself. So steps that join up cross each marker once, and turning back on a marker does not cross it
    again. The end of a loop is its start: a marker at phase 1 is crossed together with one at 0, on the way round.
    """
    if len(phases) == 0 or not step.moved.any():
        return Fired()
    # a ping-pong passes a marker on both ways, but for those at the turning points
    inner = (phases > 0.0) & (phases < 1.0)
    places = np.concatenate([phases, 2.0 - phases[inner]])
    which = np.concatenate([numbers, numbers[inner]])
    back_way = np.arange(len(places)) >= len(phases)
    mode = step.mode[:, None]
    at = np.where((mode == LOOP) & (places >= 1.0) & ~back_way, 0.0, places)  # [m,e]
    exists = ~back_way | (mode == PING_PONG)
    a, b = step.phase0[:, None], step.phase1[:, None]
    turns = (step.turn1 - step.turn0)[:, None]
    forward = turns + (at <= b) - (at <= a)
    back = -turns + (at < a) - (at < b)
    moved = step.moved[:, None]
    count = np.where(moved > 0, forward, np.where(moved < 0, back, 0))
    here = step.fresh[:, None] & (moved != 0) & (places == a)
    count = np.where(exists, count + here, 0)
    return _listed(step, at, count, here & exists, which, characters)


def _listed(step: Step, at: F8, count: I8, here: NDArray[np.bool_], which: I8, characters: I8) -> Fired:
    """The crossings one by one, in time order."""
    who, place = np.nonzero(count)
    times = count[who, place]
    total = int(times.sum())
    if total > MOST_CROSSINGS:
        upto = np.cumsum(times)
        times = np.where(upto <= MOST_CROSSINGS, times, np.maximum(times - (upto - MOST_CROSSINGS), 0))
    row, col = np.repeat(who, times), np.repeat(place, times)
    nth = np.arange(len(row)) - np.repeat(np.cumsum(times) - times, times)
    # distance from the start to the first crossing; each further one is a period away
    period = np.where(step.mode == PING_PONG, 2.0, 1.0)[row]
    direction = step.moved[row]
    first = direction * (at[row, col] - step.phase0[row])
    at_once = here[row, col]
    first = np.where(at_once, 0.0, np.where(first <= 0.0, first + period, first))
    order = np.lexsort((which[col], first + nth * period, row))
    return Fired(characters[row[order]], which[col[order]], direction[order], total - len(row))
