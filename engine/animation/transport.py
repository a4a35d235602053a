"""Transport: a playhead over a stretch of seconds, with in and out points, and the markers that it passes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from engine.animation.clock import MODES
from engine.animation.events import crossings
from engine.animation.playhead import Playheads, mode_number
from engine.core.errors import InputError

F8 = NDArray[np.float64]


class Transport:
    """`time` runs between `start` and `stop` (seconds) in `mode` at `speed`; markers beyond them are never passed.

    Each marker passed is told exactly once, however fast, in whichever direction, round loops and back again."""

    def __init__(self, start: float = 0.0, stop: float = 0.0, mode: str = "loop", speed: float = 1.0) -> None:
        self.start, self.stop = float(start), float(stop)
        self.speed = float(speed)
        self._heads = Playheads(1, mode)
        self._times: F8 = np.zeros(0)
        self._names: list[str] = []

    @property
    def mode(self) -> str:
        return MODES[int(self._heads.mode[0])]

    @mode.setter
    def mode(self, mode: str) -> None:
        here = self.time
        self._heads.mode[:] = mode_number(mode)
        fresh = self._heads.fresh.copy()
        self.seek(here)
        self._heads.fresh[:] = fresh

    @property
    def time(self) -> float:
        return self.start + float(self._heads.fraction[0]) * self._span

    @property
    def backward(self) -> bool:
        """Whether a ping-pong is on its way back."""
        return float(self._heads.phase[0]) > 1.0

    def set_range(self, start: float, stop: float) -> None:
        """Move the in and out points; the time stays where it can. Raises InputError for what is not finite."""
        if not (np.isfinite(start) and np.isfinite(stop)):
            raise InputError(f"in and out points at {start} and {stop} s")
        here, fresh = self.time, self._heads.fresh.copy()
        self.start, self.stop = float(min(start, stop)), float(max(start, stop))
        self._heads.seek(self._phase(here))
        self._heads.fresh[:] = fresh

    def set_markers(self, times: F8, names: Sequence[str]) -> None:
        """What there is to pass: seconds f8[e] and their names."""
        self._times, self._names = np.asarray(times, np.float64), list(names)

    def seek(self, time: float) -> None:
        """Go to `time`, held between the points. Nothing on the way is passed; a marker there is due at the next
        step."""
        self._heads.seek(self._phase(time))

    def advance(self, seconds: float) -> list[tuple[str, float, int]]:
        """Go on by wall time; (name, its time, direction) of the markers passed, in order."""
        if self._span <= 0.0:
            return []
        step = self._heads.advance(np.array([seconds * self.speed / self._span]))
        inside = np.flatnonzero((self._times >= self.start) & (self._times <= self.stop))
        phases = (self._times[inside] - self.start) / self._span
        fired = crossings(step, phases, inside, np.zeros(1, np.int64))
        found = zip(fired.marker.tolist(), fired.direction.tolist(), strict=True)
        return [(self._names[i], float(self._times[i]), d) for i, d in found]

    @property
    def ended(self) -> bool:
        """Whether a `once` has come to its end (its start, when it runs back)."""
        if self.mode != "once":
            return False
        return float(self._heads.phase[0]) >= 1.0 if self.speed >= 0.0 else float(self._heads.phase[0]) <= 0.0

    @property
    def _span(self) -> float:
        return self.stop - self.start

    def _phase(self, time: float) -> float:
        if self._span <= 0.0:
            return 0.0
        share = min(max((float(np.nan_to_num(time)) - self.start) / self._span, 0.0), 1.0)
        # the end of a loop is its start: stay just before it
        return min(share, float(np.nextafter(1.0, 0.0))) if self.mode == "loop" else share
