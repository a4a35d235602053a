"""TimeScale: seconds to pixels and back, ticks that suit the zoom, and what an edge snaps to."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

#: steps of a ruler, seconds
STEPS = (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 30.0, 60.0, 300.0, 600.0, 3600.0)
ZOOM = (2.0, 200_000.0)


@dataclass(slots=True)
class TimeScale:
    """`start`: the time at the left edge, seconds; `scale`: pixels a second."""

    start: float = 0.0
    scale: float = 100.0

    def x(self, time: float) -> float:
        return (time - self.start) * self.scale

    def time(self, x: float) -> float:
        return self.start + x / self.scale

    def fit(self, duration: float, width: float) -> None:
        """Show all of `duration` with a little room on both sides."""
        length = max(duration, 1e-3)
        self.scale = min(max(0.94 * width / length, ZOOM[0]), ZOOM[1])
        self.start = -0.02 * width / self.scale

    def zoom(self, factor: float, x: float) -> None:
        """`factor` > 1 shows less, larger; the time under `x` stays where it is."""
        here = self.time(x)
        self.scale = min(max(self.scale * factor, ZOOM[0]), ZOOM[1])
        self.start = here - x / self.scale

    def pan(self, pixels: float) -> None:
        self.start -= pixels / self.scale

    def step(self, room: float = 64.0) -> float:
        """The finest step whose ticks are `room` pixels apart."""
        return next((s for s in STEPS if s * self.scale >= room), STEPS[-1])

    def ticks(self, width: float, room: float = 64.0) -> list[float]:
        step = self.step(room)
        first = math.ceil(max(self.start, 0.0) / step - 1e-9)
        last = math.floor(self.time(width) / step + 1e-9)
        return [n * step for n in range(first, min(last, first + 2000) + 1)]

    def snap(self, time: float, places: Iterable[float], frame_rate: float = 0.0, reach: float = 8.0) -> float:
        """The nearest of `places` within `reach` pixels; else the nearest frame, where there is a rate; else `time`."""
        best, distance = time, reach / self.scale
        for place in places:
            if abs(place - time) <= distance:
                best, distance = place, abs(place - time)
        if best == time and frame_rate > 0.0:
            best = round(time * frame_rate) / frame_rate
        return best


def label(time: float, step: float) -> str:
    """A tick's time: `1.25`, `2`, `1:30`."""
    if step >= 60.0 or time >= 600.0:
        return f"{int(time) // 60}:{int(time) % 60:02d}"
    digits = max(0, -math.floor(math.log10(step) + 1e-9)) if step < 1.0 else 0
    return f"{time:.{digits}f}"
