"""PassTimer: the time of each pass. GPU timestamp pairs; on a software rasteriser, whose timer queries are wrong, wall
time around a finish.

GPU results are read when they are there, some frames later: `finish` returns the newest complete frame, all its numbers
from the same frame.
"""

from __future__ import annotations

import contextlib
import time
from collections import deque
from collections.abc import Iterator

from engine.gpu.types import Device
from engine.report.stats import FrameStats, PassStat

#: frames before a timestamp is read back: by then it is there and the read does not wait
LATENCY = 3


class PassTimer:
    def __init__(self, device: Device) -> None:
        self._device = device
        self._pending: deque[tuple[list[tuple[str, int, int]], list[PassStat], float]] = deque()
        self._stages: list[PassStat] = []
        self._gpu: list[tuple[str, int, int]] = []
        self._last: FrameStats | None = None
        self._enabled = False
        self._start = 0.0

    def begin(self, enabled: bool) -> None:
        self._enabled = enabled
        self._stages, self._gpu = [], []
        self._start = time.perf_counter()

    @contextlib.contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """CPU work before the passes."""
        start = time.perf_counter()
        yield
        self._stages.append(PassStat(name, (time.perf_counter() - start) * 1e3, "cpu"))

    @contextlib.contextmanager
    def gpu_pass(self, name: str) -> Iterator[None]:
        if not self._enabled:
            yield
            return
        if self._device.caps.timestamps:
            first = self._device.timestamp()
            try:
                yield
            finally:
                self._gpu.append((name, first, self._device.timestamp()))
            return
        start = time.perf_counter()
        yield
        self._device.finish()
        self._stages.append(PassStat(name, (time.perf_counter() - start) * 1e3, "wall"))

    def drop(self) -> None:
        """The frame was given up: its times mean nothing."""
        self._device.resolve_timestamps([i for _, first, last in self._gpu for i in (first, last)])
        self._gpu = []

    def finish(self) -> FrameStats:
        total = (time.perf_counter() - self._start) * 1e3
        if not self._gpu:
            return FrameStats(self._stages, total, {})
        self._pending.append((self._gpu, self._stages, total))
        if len(self._pending) > LATENCY or self._last is None:
            gpu, stages, total = self._pending.popleft()
            ids = [i for _, first, last in gpu for i in (first, last)]
            times = self._device.resolve_timestamps(ids)
            passes = [
                PassStat(name, (times[2 * i + 1] - times[2 * i]) * 1e-6, "gpu") for i, (name, _, _) in enumerate(gpu)
            ]
            self._last = FrameStats([*stages, *passes], total, {})
        return FrameStats(list(self._last.passes), self._last.total_ms, {})
