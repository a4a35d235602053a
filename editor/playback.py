"""Playback: the animation clock of the viewport: a transport between in and out points, played or stepped."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from engine.animation.clock import MODES
from engine.animation.transport import Transport


class Playback:
    """`duration` seconds; time stays inside [0, duration], and plays between `start` and `stop`. `elapsed`: seconds
    played in all, which only grow (fall at negative speed): the clock of what has no end of its own."""

    def __init__(
        self, duration: float = 0.0, time: float = 0.0, playing: bool = False, loop: bool = True, speed: float = 1.0,
        frame_rate: float = 30.0,
    ) -> None:  # fmt: skip
        self.duration = duration
        self.frame_rate = frame_rate
        self.playing = playing
        self.elapsed = 0.0
        #: markers passed since they were last taken: (name, its time, direction)
        self.passed: list[tuple[str, float, int]] = []
        self._transport = Transport(0.0, duration, "loop" if loop else "once", speed)
        self._sought: float | None = None
        self.seek(time)

    @property
    def available(self) -> bool:
        return self.duration > 0.0

    @property
    def time(self) -> float:
        return self._sought if self._sought is not None else self._transport.time

    @time.setter
    def time(self, time: float) -> None:
        self.seek(time)

    @property
    def start(self) -> float:
        """The in point."""
        return self._transport.start

    @property
    def stop(self) -> float:
        """The out point."""
        return self._transport.stop

    @property
    def mode(self) -> str:
        """loop, once or ping-pong."""
        return self._transport.mode

    @mode.setter
    def mode(self, mode: str) -> None:
        self._transport.mode = mode

    @property
    def loop(self) -> bool:
        return self.mode != "once"

    @loop.setter
    def loop(self, loop: bool) -> None:
        self.mode = "loop" if loop else "once"

    @property
    def speed(self) -> float:
        return self._transport.speed

    @speed.setter
    def speed(self, speed: float) -> None:
        self._transport.speed = speed if math.isfinite(speed) else 1.0

    def next_mode(self) -> None:
        self.mode = MODES[(MODES.index(self.mode) + 1) % len(MODES)]

    def set_duration(self, duration: float) -> None:
        """Of what is played now; in and out points stay where they can, an out point at the end stays at the end."""
        at_end = self.stop >= self.duration
        self.duration = max(duration, 0.0)
        stop = self.duration if at_end else min(self.stop, self.duration)
        self.set_range(min(self.start, self.duration), stop)

    def set_range(self, start: float, stop: float) -> None:
        """Put the in and out points, within the duration; crossed or equal ones make it whole again."""
        low, high = max(start, 0.0), min(stop, self.duration)
        if not high > low:
            low, high = 0.0, self.duration
        time = self.time
        self._transport.set_range(low, high)
        self._sought = min(max(time, low), high) if self._sought is not None else None

    def set_markers(self, times: NDArray[np.float64], names: Sequence[str]) -> None:
        self._transport.set_markers(times, names)

    def toggle(self) -> None:
        if not self.available:
            return
        if not self.playing and self._transport.ended:
            self.seek(self.start if self.speed >= 0.0 else self.stop)
        self.playing = not self.playing

    def tick(self, seconds: float) -> bool:
        """Advance by `seconds` of wall time; True when the time changed."""
        if not (self.playing and self.available):
            return False
        before = self.time
        self._sought = None
        self.passed += self._transport.advance(seconds)
        self.elapsed += seconds * self.speed
        if self._transport.ended:
            self.playing = False
        return self.time != before

    def seek(self, time: float) -> None:
        """Go there; what lies between is not passed. The playing goes on between the points."""
        self._sought = min(max(time, 0.0), self.duration)
        self._transport.seek(self._sought)

    def step(self, frames: int) -> None:
        """Pause and go to the next or previous frame of `frame_rate`."""
        self.playing = False
        self.seek((round(self.time * self.frame_rate) + frames) / self.frame_rate)

    def step_key(self, keys: Sequence[float], direction: int) -> None:
        """Pause and go to the next (1) or previous (-1) of `keys`, rising; beyond them stay."""
        self.playing = False
        if direction > 0:
            at = bisect_right(keys, self.time + 1e-6)
            if at < len(keys):
                self.seek(keys[at])
        else:
            at = bisect_left(keys, self.time - 1e-6) - 1
            if at >= 0:
                self.seek(keys[at])
