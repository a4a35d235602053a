"""GlComputePass: dispatches, with a memory barrier after each."""

from __future__ import annotations

from typing import TYPE_CHECKING

from engine.gpu import validate
from engine.gpu.gl import enums as e
from engine.gpu.types import Bindings, Pipeline

if TYPE_CHECKING:
    from engine.gpu.gl.device import GlDevice
    from engine.gpu.gl.pipeline import GlPipeline


class GlComputePass:
    __slots__ = ("_device", "_open", "_pipeline", "label")

    def __init__(self, device: GlDevice, label: str) -> None:
        self.label = label
        self._device = device
        self._pipeline: GlPipeline | None = None
        self._open = True
        device.counters.passes += 1

    def set_pipeline(self, pipeline: Pipeline) -> None:
        if pipeline is self._pipeline:
            return
        if not self._open:
            raise validate.ended(self.label)
        self._pipeline = pipeline  # type: ignore[assignment]  # pipelines of this device are GlPipeline
        self._device.state.use_program(pipeline.id)  # type: ignore[attr-defined]  # likewise
        self._device.counters.pipelines_bound += 1

    def set_bindings(self, bindings: Bindings) -> None:
        if not self._open:
            raise validate.ended(self.label)
        if self._device.debug:
            validate.bindings(self.label, bindings, self._device.caps)
        self._device.state.bind(bindings)

    def dispatch(self, x: int, y: int = 1, z: int = 1) -> None:
        if self._pipeline is None:
            raise validate.no_pipeline(self.label)
        if not self._open:
            raise validate.ended(self.label)
        gl = self._device.gl
        gl.DispatchCompute(x, y, z)
        gl.MemoryBarrier(e.ALL_BARRIER_BITS)
        self._device.counters.api_calls += 2
        self._device.counters.dispatches += 1

    def end(self) -> None:
        if self._open:
            self._open = False
            self._device.end_pass(self)

    def __enter__(self) -> GlComputePass:
        return self

    def __exit__(self, *args: object) -> None:
        self.end()
