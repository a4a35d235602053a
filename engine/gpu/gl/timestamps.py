"""GPU timestamps: glQueryCounter with a pool of query objects."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import TYPE_CHECKING

from engine.core.errors import UsageError
from engine.gpu.gl import enums as e

if TYPE_CHECKING:
    from engine.gpu.gl.device import GlDevice


class Timestamps:
    def __init__(self, device: GlDevice) -> None:
        self._device = device
        self._free: list[int] = []
        self._pending: set[int] = set()

    def queue(self) -> int:
        """Ask for the time at which the device gets here; the query's id."""
        name = self._free.pop() if self._free else self._device.objects.create("query", e.TIMESTAMP)
        self._device.gl.QueryCounter(name, e.TIMESTAMP)
        self._device.counters.api_calls += 1
        self._pending.add(name)
        return name

    def resolve(self, ids: Sequence[int]) -> list[int]:
        """Nanoseconds, waiting where the device is not there yet: ask some frames later. Id 0 gives 0."""
        times = []
        value = ctypes.c_uint64()
        for name in ids:
            if name == 0:
                times.append(0)
                continue
            if name not in self._pending:
                raise UsageError(f"timestamp {name} was resolved before or never queued")
            self._device.gl.GetQueryObjectui64v(name, e.QUERY_RESULT, ctypes.byref(value))
            self._device.counters.api_calls += 1
            self._pending.remove(name)
            self._free.append(name)
            times.append(value.value)
        return times

    def clear(self) -> None:
        for name in [*self._free, *self._pending]:
            self._device.objects.let_go("query", name)
        self._free.clear()
        self._pending.clear()
