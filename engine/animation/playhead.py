"""Playheads: where each character is in what it plays, kept as (turn, phase) so that no digit is lost over the years.

phase in [0, 1) of one run through the clip (ping-pong: [0, 2), there and back), turn = how many are behind it
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.animation.clock import MODES
from engine.core.errors import InputError

F8 = NDArray[np.float64]
I8 = NDArray[np.int64]

LOOP, ONCE, PING_PONG = range(3)
#: Beyond this many turns a step counts no further: the product of speed and time was not meant.
_MOST_TURNS = float(2**52)


Who = ArrayLike | slice


def chosen(who: Who, count: int) -> I8:
    """The numbers i8[k] of the characters `who` (numbers, a bool mask or a slice) of `count`."""
    everyone = np.arange(count)
    picked: I8 = everyone[who] if isinstance(who, slice) else np.atleast_1d(everyone[np.asarray(who)])
    return picked


def mode_number(mode: str) -> int:
    """0 loop, 1 once, 2 ping-pong. Raises InputError."""
    if mode not in MODES:
        raise InputError(f"unknown play mode {mode!r}", hint=f"choose one of {', '.join(MODES)}")
    return MODES.index(mode)


@dataclass(slots=True, eq=False)
class Step:
    """One advance of m playheads: from (turn0, phase0) to (turn1, phase1); a turn is 1, or 2 for ping-pong.
    `fresh`: the place it left was never announced, so a marker right there is still due. `moved`: it went
    forward (1), back (-1), or stood (0)."""

    turn0: I8
    phase0: F8
    turn1: I8
    phase1: F8
    fresh: NDArray[np.bool_]
    moved: I8
    mode: I8

    def part(self, who: ArrayLike) -> Step:
        """The steps of the characters `who`."""
        i = np.asarray(who)
        return Step(
            self.turn0[i], self.phase0[i], self.turn1[i], self.phase1[i], self.fresh[i], self.moved[i], self.mode[i]
        )


class Playheads:
    """m playheads, each in its own `mode` (i8: LOOP, ONCE, PING_PONG)."""

    def __init__(self, count: int, mode: str = "loop") -> None:
        self.mode: I8 = np.full(count, mode_number(mode), np.int64)
        self.turn: I8 = np.zeros(count, np.int64)
        self.phase: F8 = np.zeros(count)
        self.fresh: NDArray[np.bool_] = np.ones(count, np.bool_)

    def __len__(self) -> int:
        return len(self.phase)

    @property
    def fraction(self) -> F8:
        """f8[m] in [0,1]: how far into the clip; on the way back of a ping-pong it falls."""
        return np.where(self.phase > 1.0, 2.0 - self.phase, self.phase)

    def seek(self, phase: ArrayLike, who: Who = slice(None)) -> None:
        """Put playheads at `phase` (turns wrap; `once` holds the ends). What lies between is not passed; a marker
        at the very place is due at the next step. Not a number is 0."""
        at = np.nan_to_num(np.asarray(phase, np.float64), posinf=0.0, neginf=0.0)
        where = chosen(who, len(self))
        turn, rest = _wrap(np.zeros(len(where)), np.broadcast_to(at, where.shape), self.mode[where])
        self.turn[where], self.phase[where], self.fresh[where] = turn, rest, True

    def copy_from(self, other: Playheads, who: ArrayLike) -> None:
        """Take over the state of `other`'s characters `who`."""
        for name in ("mode", "turn", "phase", "fresh"):
            getattr(self, name)[who] = getattr(other, name)[who]

    def advance(self, phases: ArrayLike) -> Step:
        """Go on by `phases` f8[m], negative for back; what is not finite stands still."""
        by = np.broadcast_to(np.asarray(phases, np.float64), self.phase.shape)
        if not (np.abs(by) <= _MOST_TURNS).all():
            by = np.clip(np.nan_to_num(by, posinf=0.0, neginf=0.0), -_MOST_TURNS, _MOST_TURNS)
        turn0, phase0, fresh = self.turn.copy(), self.phase.copy(), self.fresh.copy()
        more, phase = _wrap(phase0, by, self.mode)
        self.turn, self.phase = turn0 + more, phase
        moved = np.sign(by).astype(np.int64)
        # a once-clip at its end stands, but a marker where it never stirred from is due all the same
        self.fresh = fresh & (moved == 0)
        return Step(turn0, phase0, self.turn.copy(), phase.copy(), fresh, moved, self.mode.copy())


def _wrap(phase: F8, by: F8, mode: I8) -> tuple[I8, F8]:
    """(turns, phase in [0, period)) of phase + by; in mode ONCE (0, phase clamped to [0,1])."""
    period = np.where(mode == PING_PONG, 2.0, 1.0)
    # the rest of `by` alone is exact (fmod), where phase + by would round
    rest = np.fmod(by, period)
    turn = np.rint((by - rest) / period)
    inside = phase + rest
    over = np.floor(inside / period)
    turn, inside = turn + over, inside - over * period
    # -1e-30 + period rounds to the period itself
    wrapped = inside >= period
    turn, inside = turn + wrapped, np.where(wrapped, 0.0, np.maximum(inside, 0.0))
    once = mode == ONCE
    return np.where(once, 0.0, turn).astype(np.int64), np.where(once, np.clip(phase + by, 0.0, 1.0), inside)
