"""Vertex arrays: one GL object per (attributes, vertex buffers, index buffer), made at the first draw that needs it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from engine.gpu import formats, validate
from engine.gpu.gl import enums as e

if TYPE_CHECKING:
    from engine.gpu.gl.buffer import GlBuffer
    from engine.gpu.gl.device import GlDevice
    from engine.gpu.gl.pipeline import GlPipeline


class VertexArrays:
    """The cache. Entries go when a buffer in them goes."""

    def __init__(self, device: GlDevice) -> None:
        self._device = device
        self._cache: dict[tuple[Any, ...], int] = {}

    def get(self, pipeline: GlPipeline, streams: Mapping[str, GlBuffer], index: GlBuffer | None) -> int:
        """The vertex array; all streams that the pipeline names must be there."""
        key = (pipeline.attributes, tuple([streams[s].id for s in pipeline.streams]), index.id if index else 0)
        name = self._cache.get(key)
        if name is None:
            name = self._cache[key] = self._create(*key)
        return name

    def _create(self, attributes: Any, buffers: tuple[int, ...], index: int) -> int:
        gl = self._device.gl
        name = self._device.objects.create("vertex_array")
        strides = validate.stream_strides(attributes)
        slots = {stream: slot for slot, stream in enumerate(strides)}
        for (stream, (stride, per_instance)), buffer in zip(strides.items(), buffers, strict=True):
            gl.VertexArrayVertexBuffer(name, slots[stream], buffer, 0, stride)
            gl.VertexArrayBindingDivisor(name, slots[stream], 1 if per_instance else 0)
        offsets = dict.fromkeys(strides, 0)
        for attribute in attributes:
            form = formats.vertex_format(attribute.format)
            offset = offsets[attribute.stream]
            offsets[attribute.stream] += form.size
            gl.EnableVertexArrayAttrib(name, attribute.location)
            number = e.NUMBERS[form.base]
            if form.integer:
                gl.VertexArrayAttribIFormat(name, attribute.location, form.components, number, offset)
            else:
                gl.VertexArrayAttribFormat(name, attribute.location, form.components, number, form.normalized, offset)
            gl.VertexArrayAttribBinding(name, attribute.location, slots[attribute.stream])
        if index:
            gl.VertexArrayElementBuffer(name, index)
        self._device.counters.api_calls += 2 + 2 * len(strides) + 3 * len(attributes)
        return name

    def forget_buffer(self, buffer: int) -> None:
        """A buffer is deleted: drop the vertex arrays that hold it."""
        for key in [k for k in self._cache if buffer == k[2] or buffer in k[1]]:
            self._device.objects.let_go("vertex_array", self._cache.pop(key))

    def clear(self) -> None:
        while self._cache:
            self._device.objects.let_go("vertex_array", self._cache.popitem()[1])
