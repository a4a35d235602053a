"""How a GPU trial is timed: timestamp pairs where the device has them, else wall time round a finish.

Software rasterisers do the work at the flush, so that their timer queries are wrong; there the wall clock is the truth.
"""

from __future__ import annotations

import time
from collections.abc import Callable

from engine.gpu.types import Device


class GpuClock:
    """`clock(run)` gives the milliseconds that `run` kept the device busy. `kind` is gpu or wall."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self.kind = "gpu" if device.caps.timestamps else "wall"

    def __call__(self, run: Callable[[], object]) -> float:
        device = self._device
        device.finish()
        if self.kind == "gpu":
            first = device.timestamp()
            run()
            last = device.timestamp()
            device.finish()
            start, stop = device.resolve_timestamps([first, last])
            return (stop - start) / 1e6
        start = time.perf_counter_ns()
        run()
        device.finish()
        return (time.perf_counter_ns() - start) / 1e6
