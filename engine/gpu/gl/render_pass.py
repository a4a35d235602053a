"""GlRenderPass: draws into one set of attachments. Commands reach the driver at once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from ctypes import byref, c_float, c_uint
from typing import TYPE_CHECKING, Any

from engine.core.errors import UsageError
from engine.gpu import formats, validate
from engine.gpu.gl import enums as e
from engine.gpu.types import Bindings, Buffer, ColorAttachment, DepthAttachment, Pipeline

if TYPE_CHECKING:
    from engine.gpu.gl.device import GlDevice
    from engine.gpu.gl.pipeline import GlPipeline

COMMAND_BYTES = 20
_FLOAT4, _UINT4 = c_float * 4, c_uint * 4
_NO_STREAMS: dict[str, Any] = {}


class GlRenderPass:
    __slots__ = (
        "_attached", "_checked", "_counters", "_depth_writable", "_device", "_gl", "_index", "_open", "_pipeline",
        "_size", "_state", "_stencil_writable", "_streams", "_vertex_array_stale", "_writes", "label",
    )  # fmt: skip

    def __init__(
        self, device: GlDevice, label: str, colors: Sequence[ColorAttachment], depth: DepthAttachment | None
    ) -> None:
        width, height = validate.attachments(label, colors, depth)
        self.label = label
        self._size = (width, height)
        self._stencil_writable = depth is not None and depth.stencil
        self._device = device
        self._gl = device.gl
        self._state = state = device.state
        self._counters = device.counters
        self._pipeline: GlPipeline | None = None
        self._streams: Mapping[str, Any] = _NO_STREAMS
        self._index: Any = None
        self._vertex_array_stale = True
        self._writes = False
        self._depth_writable = depth is not None and not depth.read_only
        self._attached = [c.texture for c in colors]
        if depth is not None and not depth.read_only:
            self._attached.append(depth.texture)
        framebuffer = device.framebuffers.get(label, colors, depth)
        self._open = True
        state.bind_framebuffer(framebuffer)
        state.set_viewport(0, 0, width, height)
        self._clear(framebuffer, colors, depth)
        self._counters.passes += 1

    def _clear(self, framebuffer: int, colors: Sequence[ColorAttachment], depth: DepthAttachment | None) -> None:
        gl = self._gl
        self._state.open_scissor()
        for index, color in enumerate(colors):
            if color.clear is not None:
                self._state.open_color_mask(index)
                if color.texture.desc.format in formats.INTEGER:
                    gl.ClearNamedFramebufferuiv(framebuffer, e.COLOR, index, _UINT4(*(int(v) for v in color.clear)))
                else:
                    gl.ClearNamedFramebufferfv(framebuffer, e.COLOR, index, _FLOAT4(*color.clear))
                self._counters.api_calls += 1
        if depth is not None and depth.clear is not None:
            self._state.write_depth(True)
            if depth.texture.desc.format in formats.STENCIL:
                self._state.write_stencil(0xFF)
                gl.ClearNamedFramebufferfi(framebuffer, e.DEPTH_STENCIL, 0, depth.clear, 0)
            else:
                gl.ClearNamedFramebufferfv(framebuffer, e.DEPTH, 0, byref(c_float(depth.clear)))
            self._counters.api_calls += 1

    def set_pipeline(self, pipeline: Pipeline) -> None:
        if pipeline is self._pipeline:
            return
        if not self._open:
            raise validate.ended(self.label)
        new: GlPipeline = pipeline  # type: ignore[assignment]  # pipelines of this device are GlPipeline
        self._state.apply(
            new, may_write_depth=self._depth_writable, size=self._size, may_write_stencil=self._stencil_writable
        )
        old = self._pipeline
        if old is None or old.attributes is not new.attributes:
            self._vertex_array_stale = True
        self._writes |= new.writes
        self._pipeline = new
        self._counters.pipelines_bound += 1

    def set_bindings(self, bindings: Bindings) -> None:
        if not self._open:
            raise validate.ended(self.label)
        if self._device.debug:
            validate.bindings(self.label, bindings, self._device.caps, self._attached)
        self._state.bind(bindings)

    def set_vertex_buffers(self, streams: Mapping[str, Buffer], index: Buffer | None = None) -> None:
        self._streams = streams
        self._index = index
        self._vertex_array_stale = True

    def set_viewport(self, x: int, y: int, width: int, height: int) -> None:
        self._state.set_viewport(x, y, width, height)

    def draw(self, vertex_count: int, instance_count: int = 1, first_vertex: int = 0) -> None:
        pipeline = self._ready(indexed=False)
        self._gl.DrawArraysInstancedBaseInstance(pipeline.mode, first_vertex, vertex_count, instance_count, 0)
        self._counters.api_calls += 1
        self._counters.draws += 1

    def draw_indexed(
        self,
        index_count: int,
        instance_count: int = 1,
        first_index: int = 0,
        base_vertex: int = 0,
        base_instance: int = 0,
    ) -> None:
        pipeline = self._ready(indexed=True)
        if first_index < 0 or (first_index + index_count) * 4 > self._index.size:
            validate.index_range(self.label, self._index.size, first_index, index_count)
        self._gl.DrawElementsInstancedBaseVertexBaseInstance(
            pipeline.mode, index_count, e.UNSIGNED_INT, first_index * 4, instance_count, base_vertex, base_instance
        )
        self._counters.api_calls += 1
        self._counters.draws += 1

    def multi_draw_indexed_indirect(self, commands: Buffer, first: int, count: int) -> None:
        if first < 0 or count < 0 or (first + count) * COMMAND_BYTES > commands.size:
            validate.buffer_range(commands.label, commands.size, first * COMMAND_BYTES, count * COMMAND_BYTES)
        pipeline = self._ready(indexed=True)
        self._state.bind_indirect(commands.id)  # type: ignore[attr-defined]  # buffers of this device are GlBuffer
        self._gl.MultiDrawElementsIndirect(pipeline.mode, e.UNSIGNED_INT, first * COMMAND_BYTES, count, COMMAND_BYTES)
        counters = self._counters
        counters.api_calls += 1
        counters.draws += 1
        counters.indirect_commands += count

    def _ready(self, *, indexed: bool) -> GlPipeline:
        """The pipeline, with its vertex array bound."""
        pipeline = self._pipeline
        if pipeline is None:
            raise validate.no_pipeline(self.label)
        if not self._open:
            raise validate.ended(self.label)
        if indexed and self._index is None:
            raise validate.no_index(self.label)
        if self._vertex_array_stale:
            try:
                name = self._device.vertex_arrays.get(pipeline, self._streams, self._index)
            except KeyError:
                validate.vertex_buffers(self.label, pipeline.label, pipeline.streams, tuple(self._streams))
                raise
            self._state.bind_vertex_array(name)
            self._vertex_array_stale = False
        return pipeline

    def end(self) -> None:
        if self._open:
            self._open = False
            if self._writes:
                self._gl.MemoryBarrier(e.ALL_BARRIER_BITS)
                self._counters.api_calls += 1
            self._device.end_pass(self)

    def __enter__(self) -> GlRenderPass:
        if not self._open:
            raise UsageError(f"pass {self.label!r} has ended")
        return self

    def __exit__(self, *args: object) -> None:
        self.end()
