"""Playback: the animation clock of the viewport."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(slots=True)
class Playback:
    """`time` and `duration` in seconds. Time stays inside [0, duration]."""

    duration: float = 0.0
    time: float = 0.0
    playing: bool = False
    loop: bool = True
    speed: float = 1.0
    frame_rate: float = 30.0

    @property
    def available(self) -> bool:
        return self.duration > 0.0

    def toggle(self) -> None:
        if not self.available:
            return
        if not self.playing and not self.loop and self.time >= self.duration:
            self.time = 0.0
        self.playing = not self.playing

    def tick(self, seconds: float) -> bool:
        """Advance by `seconds` of wall time; True when the time changed."""
        if not (self.playing and self.available):
            return False
        time = self.time + seconds * self.speed
        if time > self.duration:
            if self.loop:
                time %= self.duration
            else:
                time, self.playing = self.duration, False
        changed = time != self.time
        self.time = time
        return changed

    def seek(self, time: float) -> None:
        self.time = min(max(time, 0.0), self.duration)

    def step(self, frames: int) -> None:
        """Pause and go to the next or previous frame of `frame_rate`."""
        self.playing = False
        self.seek((round(self.time * self.frame_rate) + frames) / self.frame_rate)
