"""Buffers, textures, samplers and pipelines of the null device."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from engine.gpu import formats, validate
from engine.gpu.types import ComputePipelineDesc, RenderPipelineDesc, SamplerDesc, TextureDesc

if TYPE_CHECKING:
    from engine.gpu.null.device import NullDevice


class _Counted:
    """Counts live objects as the real backend does."""

    KIND = ""

    def __init__(self, device: NullDevice) -> None:
        self._device = device
        self._live = True
        device.live[self.KIND] += 1

    def release(self) -> None:
        if self._live:
            self._live = False
            self._device.live[self.KIND] -= 1

    def __del__(self) -> None:
        if getattr(self, "_live", False):
            self.release()


class NullBuffer(_Counted):
    """Keeps its bytes, so that a write costs a copy as it does on a device."""

    KIND = "buffer"

    def __init__(self, device: NullDevice, data_or_size: bytes | int | NDArray[Any], label: str) -> None:
        self.label = label
        if isinstance(data_or_size, (int, np.integer)):
            self.size = int(data_or_size)
            validate.buffer_range(label, self.size, 0, self.size)
            self.data = np.zeros(self.size, np.uint8)
        else:
            self.data = validate.as_bytes(data_or_size).copy()
            self.size = self.data.nbytes
            device.counters.bytes_uploaded += self.size
        super().__init__(device)

    def write(self, data: bytes | NDArray[Any], offset: int = 0) -> None:
        source = validate.as_bytes(data)
        size = source.nbytes
        validate.buffer_range(self.label, self.size, offset, size)
        self.data[offset : offset + size] = source
        counters = self._device.counters
        counters.api_calls += 1
        counters.bytes_uploaded += size
        self._device.calls.add("write_buffer", label=self.label, offset=offset, size=size)

    def read(self, offset: int = 0, size: int = -1) -> bytes:
        if size < 0:
            size = self.size - offset
        validate.buffer_range(self.label, self.size, offset, size)
        self._device.counters.bytes_read += size
        return self.data[offset : offset + size].tobytes()


class NullTexture(_Counted):
    """Remembers its descriptor and which images were written; reads as zeros."""

    KIND = "texture"
    native = 0

    def __init__(self, device: NullDevice, desc: TextureDesc) -> None:
        validate.texture_desc(desc, device.caps)
        self.desc = desc
        self.written: set[tuple[int, int]] = set()
        super().__init__(device)

    def write(self, data: bytes | memoryview | NDArray[Any], *, level: int = 0, layer: int = 0) -> None:
        size = validate.as_bytes(data).nbytes
        validate.texture_write(self.desc, level, layer, size)
        self.written.add((level, layer))
        counters = self._device.counters
        counters.api_calls += 1
        counters.bytes_uploaded += size
        self._device.calls.add("write_texture", label=self.desc.label, level=level, layer=layer, size=size)

    def read(self, *, level: int = 0, layer: int = 0) -> NDArray[Any]:
        validate.texture_read(self.desc, level, layer)
        dtype, shape = formats.read_shape(self.desc, level)
        image = np.zeros(shape, dtype)
        self._device.counters.bytes_read += image.nbytes
        return image


class NullSampler:
    def __init__(self, desc: SamplerDesc) -> None:
        validate.sampler_desc(desc)
        self.desc = desc

    def release(self) -> None: ...


class NullPipeline:
    """Nothing is compiled: shader errors only show on a real device."""

    def __init__(self, device: NullDevice, key: object, desc: RenderPipelineDesc | ComputePipelineDesc) -> None:
        self._device = device
        self.key = key
        self.desc = desc
        self.label = desc.label
        self.loaded = False
        self.references = 0
        self.attributes = desc.attributes if isinstance(desc, RenderPipelineDesc) else ()
        self.strides = validate.stream_strides(self.attributes)

    def block_size(self, name: str) -> int:
        return -1

    def release(self) -> None:
        self.references -= 1
        if self.references == 0:
            self._device.drop_pipeline(self)
