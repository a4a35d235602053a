"""CPU clocks: time one block, or the passes of a frame."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator
from types import TracebackType
from typing import Self

from engine.report.stats import FrameStats, PassStat


class CpuTimer:
    """`with CpuTimer() as timer: ...` then `timer.ms`; while it runs, `ms` is the time so far."""

    __slots__ = ("_start", "_stop")

    def __init__(self) -> None:
        self._start = self._stop = 0

    def __enter__(self) -> Self:
        self._stop = 0
        self._start = time.perf_counter_ns()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stop = time.perf_counter_ns()

    @property
    def ms(self) -> float:
        """Milliseconds from entry to exit, or to now; 0 if it never ran."""
        return ((self._stop or time.perf_counter_ns()) - self._start) / 1e6 if self._start else 0.0


class PassTimes:
    """Collects one frame's pass times, in order; a pass measured twice is summed into one row."""

    def __init__(self) -> None:
        self._times: dict[tuple[str, str], float] = {}

    def add(self, name: str, ms: float, kind: str = "cpu") -> None:
        """Add `ms` milliseconds, of a kind in stats.KINDS, to pass `name`."""
        self._times[name, kind] = self._times.get((name, kind), 0.0) + ms

    @contextlib.contextmanager
    def measure(self, name: str, kind: str = "cpu") -> Iterator[None]:
        """Time the block by the CPU's clock; also when it raises."""
        start = time.perf_counter_ns()
        try:
            yield
        finally:
            self.add(name, (time.perf_counter_ns() - start) / 1e6, kind)

    def passes(self) -> list[PassStat]:
        return [PassStat(name, ms, kind) for (name, kind), ms in self._times.items()]

    def total_ms(self, kind: str = "cpu") -> float:
        """The sum over passes of one kind: times of different kinds overlap and are never added."""
        return sum(ms for (_, k), ms in self._times.items() if k == kind)

    def clear(self) -> None:
        self._times.clear()

    def frame(self, total_ms: float, **counters: int | float) -> FrameStats:
        """Return the frame's statistics and start the next frame."""
        stats = FrameStats(self.passes(), total_ms, counters)
        self.clear()
        return stats
