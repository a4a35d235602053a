"""The encoders of the null device: check, count, record."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from engine.core.errors import UsageError
from engine.gpu import validate
from engine.gpu.types import Bindings, Buffer, ColorAttachment, DepthAttachment, Pipeline

if TYPE_CHECKING:
    from engine.gpu.null.device import NullDevice
    from engine.gpu.null.resources import NullPipeline


class _NullPass:
    def __init__(self, device: NullDevice, label: str) -> None:
        self.label = label
        self._device = device
        self._open = True
        self._pipeline: NullPipeline | None = None
        self._attached: list[Any] = []
        device.counters.passes += 1

    def set_pipeline(self, pipeline: Pipeline) -> None:
        self._check_open()
        if pipeline is self._pipeline:
            return
        self._pipeline = pipeline  # type: ignore[assignment]  # pipelines of this device are NullPipeline
        self._device.counters.pipelines_bound += 1
        self._device.counters.api_calls += 1
        self._device.calls.add("set_pipeline", self.label, label=pipeline.label)

    def set_bindings(self, bindings: Bindings) -> None:
        self._check_open()
        device = self._device
        count = len(bindings.uniforms) + len(bindings.storage) + len(bindings.images) + 2 * len(bindings.textures)
        device.counters.api_calls += count
        if device.calls.recording:
            validate.bindings(self.label, bindings, device.caps, self._attached)
            device.calls.add("set_bindings", self.label, bindings=bindings)

    def end(self) -> None:
        if self._open:
            self._open = False
            self._device.end_pass(self.label)

    def _check_open(self) -> None:
        if not self._open:
            raise validate.ended(self.label)


class NullRenderPass(_NullPass):
    def __init__(
        self, device: NullDevice, label: str, colors: Sequence[ColorAttachment], depth: DepthAttachment | None
    ) -> None:
        self.width, self.height = validate.attachments(label, colors, depth)
        super().__init__(device, label)
        self._streams: Mapping[str, Any] = {}
        self._index: Any = None
        self._attached = [c.texture for c in colors]
        if depth is not None and not depth.read_only:
            self._attached.append(depth.texture)
        device.calls.add("render_pass", label=label, colors=tuple(colors), depth=depth)

    def set_vertex_buffers(self, streams: Mapping[str, Buffer], index: Buffer | None = None) -> None:
        self._streams = streams
        self._index = index
        self._device.calls.add("set_vertex_buffers", self.label, streams=tuple(streams), indexed=index is not None)

    def set_viewport(self, x: int, y: int, width: int, height: int) -> None:
        self._device.counters.api_calls += 1
        self._device.calls.add("set_viewport", self.label, x=x, y=y, width=width, height=height)

    def draw(self, vertex_count: int, instance_count: int = 1, first_vertex: int = 0) -> None:
        self._ready(indexed=False)
        self._device.calls.add(
            "draw", self.label, vertex_count=vertex_count, instance_count=instance_count, first_vertex=first_vertex
        )

    def draw_indexed(
        self,
        index_count: int,
        instance_count: int = 1,
        first_index: int = 0,
        base_vertex: int = 0,
        base_instance: int = 0,
    ) -> None:
        self._ready(indexed=True)
        validate.index_range(self.label, self._index.size, first_index, index_count)
        if self._device.calls.recording:
            self._check_instances(base_instance + instance_count)
        self._device.calls.add(
            "draw_indexed", self.label, index_count=index_count, instance_count=instance_count, first_index=first_index,
            base_vertex=base_vertex, base_instance=base_instance,
        )  # fmt: skip

    def multi_draw_indexed_indirect(self, commands: Buffer, first: int, count: int) -> None:
        validate.buffer_range(commands.label, commands.size, first * 20, count * 20)
        self._ready(indexed=True)
        self._device.counters.indirect_commands += count
        if self._device.calls.recording:
            rows = np.frombuffer(commands.data, np.uint32).reshape(-1, 5)[first : first + count].copy()  # type: ignore[attr-defined]  # NullBuffer
            if count:
                validate.index_range(
                    self.label, self._index.size, 0, int((rows[:, 2].astype(np.int64) + rows[:, 0]).max())
                )
                self._check_instances(int((rows[:, 4].astype(np.int64) + rows[:, 1]).max()))
            self._device.calls.add("multi_draw_indexed_indirect", self.label, first=first, count=count, commands=rows)

    def _ready(self, *, indexed: bool) -> None:
        self._check_open()
        pipeline = self._pipeline
        if pipeline is None:
            raise validate.no_pipeline(self.label)
        if indexed and self._index is None:
            raise validate.no_index(self.label)
        if not pipeline.strides.keys() <= self._streams.keys():
            validate.vertex_buffers(self.label, pipeline.label, tuple(pipeline.strides), tuple(self._streams))
        self._device.counters.draws += 1
        self._device.counters.api_calls += 1

    def _check_instances(self, end: int) -> None:
        assert self._pipeline is not None
        for stream, (stride, per_instance) in self._pipeline.strides.items():
            buffer = self._streams[stream]
            if per_instance and end * stride > buffer.size:
                raise UsageError(
                    f"pass {self.label!r}: instances up to {end} are drawn, but stream {stream!r} holds "
                    f"{buffer.size // stride}"
                )

    def __enter__(self) -> NullRenderPass:
        return self

    def __exit__(self, *args: object) -> None:
        self.end()


class NullComputePass(_NullPass):
    def __init__(self, device: NullDevice, label: str) -> None:
        super().__init__(device, label)
        device.calls.add("compute_pass", label=label)

    def dispatch(self, x: int, y: int = 1, z: int = 1) -> None:
        self._check_open()
        if self._pipeline is None:
            raise validate.no_pipeline(self.label)
        self._device.counters.dispatches += 1
        self._device.counters.api_calls += 2
        self._device.calls.add("dispatch", self.label, x=x, y=y, z=z)

    def __enter__(self) -> NullComputePass:
        return self

    def __exit__(self, *args: object) -> None:
        self.end()
