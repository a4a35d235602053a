"""GlBuffer: bytes on the device."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from engine.gpu import validate
from engine.gpu.gl import enums as e
from engine.gpu.gl.memory import address_of
from engine.gpu.gl.objects import GlObject

if TYPE_CHECKING:
    from engine.gpu.gl.device import GlDevice

MINIMUM_BYTES = 16  # GL cannot bind a range of no bytes


class GlBuffer(GlObject):
    KIND = "buffer"
    __slots__ = ("_device", "label", "size")

    def __init__(self, device: GlDevice, data_or_size: bytes | int | NDArray[Any], label: str) -> None:
        super().__init__(device.objects, device.objects.create("buffer"))
        self._device = device
        self.label = label
        if isinstance(data_or_size, (int, np.integer)):
            self.size = int(data_or_size)
            validate.buffer_range(label, self.size, 0, self.size)
            device.before_allocation(self.size)
            device.gl.NamedBufferData(self.id, max(self.size, MINIMUM_BYTES), None, e.DYNAMIC_DRAW)
            # fresh memory may hold another program's bytes
            device.gl.ClearNamedBufferData(self.id, e.R8UI, e.RED_INTEGER, e.UNSIGNED_BYTE, None)
        else:
            address, self.size, keep = address_of(data_or_size)
            allocated = max(self.size, MINIMUM_BYTES)
            device.before_allocation(self.size)
            device.gl.NamedBufferData(self.id, allocated, address if self.size == allocated else None, e.DYNAMIC_DRAW)
            if 0 < self.size < allocated:
                device.gl.NamedBufferSubData(self.id, 0, self.size, address)
            del keep
            device.counters.bytes_uploaded += self.size
        device.counters.api_calls += 2
        device.check_allocation(validate.named("buffer", label), self.size)
        device.label(self.KIND, self.id, label)

    def write(self, data: bytes | NDArray[Any], offset: int = 0) -> None:
        address, size, keep = address_of(data)
        if offset < 0 or offset + size > self.size:
            validate.buffer_range(self.label, self.size, offset, size)
        if size:
            device = self._device
            device.ensure_current()
            device.gl.NamedBufferSubData(self.id, offset, size, address)
            counters = device.counters
            counters.api_calls += 1
            counters.bytes_uploaded += size
        del keep

    def read(self, offset: int = 0, size: int = -1) -> bytes:
        if size < 0:
            size = self.size - offset
        validate.buffer_range(self.label, self.size, offset, size)
        if not size:
            return b""
        device = self._device
        device.ensure_current()
        target = ctypes.create_string_buffer(size)
        device.gl.GetNamedBufferSubData(self.id, offset, size, target)
        device.counters.api_calls += 1
        device.counters.bytes_read += size
        return target.raw
