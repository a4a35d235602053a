"""NullDevice: the Device protocol without a GPU."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from numpy.typing import NDArray

from engine.core.errors import UsageError
from engine.gpu import validate
from engine.gpu.null.passes import NullComputePass, NullRenderPass
from engine.gpu.null.record import CallStream
from engine.gpu.null.resources import NullBuffer, NullPipeline, NullSampler, NullTexture
from engine.gpu.pipeline_keys import pipeline_key
from engine.gpu.types import (
    Caps,
    ColorAttachment,
    ComputePipelineDesc,
    Counters,
    DepthAttachment,
    RenderPipelineDesc,
    SamplerDesc,
    Texture,
    TextureDesc,
)

CAPS = Caps(
    backend="null", device="null", version="0", software=True, reversed_z=True, compute=True, bc=True,
    max_texture_size=16384, max_array_layers=2048, max_anisotropy=16.0, max_ssbo_bytes=1 << 27,
    max_workgroup_invocations=1024, timestamps=False, max_samples=8,
)  # fmt: skip


class NullDevice:
    """`calls` is the recorded stream. `record=False` for benchmarks: only bytes are copied and calls counted, and the
    checks that look into bindings and indirect commands are left out."""

    def __init__(self, *, record: bool = True) -> None:
        self.caps = CAPS
        self.counters = Counters()
        self.calls = CallStream(record)
        self.live = {"buffer": 0, "texture": 0}
        self._samplers: dict[SamplerDesc, NullSampler] = {}
        self._pipelines: dict[object, NullPipeline] = {}
        self._open_pass: str | None = None

    def buffer(self, data_or_size: bytes | int | NDArray[Any], *, label: str = "") -> NullBuffer:
        return NullBuffer(self, data_or_size, label)

    def texture(self, desc: TextureDesc) -> NullTexture:
        return NullTexture(self, desc)

    def sampler(self, desc: SamplerDesc) -> NullSampler:
        sampler = self._samplers.get(desc)
        if sampler is None:
            sampler = self._samplers[desc] = NullSampler(desc)
        return sampler

    def render_pipeline(self, desc: RenderPipelineDesc) -> NullPipeline:
        return self._pipeline(desc)

    def compute_pipeline(self, desc: ComputePipelineDesc) -> NullPipeline:
        return self._pipeline(desc)

    def begin_pipeline(self, desc: RenderPipelineDesc | ComputePipelineDesc) -> bool:
        return True

    def abandon_pipelines(self) -> None:
        pass

    def _pipeline(self, desc: RenderPipelineDesc | ComputePipelineDesc) -> NullPipeline:
        key = pipeline_key(desc)
        pipeline = self._pipelines.get(key)
        if pipeline is None:
            if isinstance(desc, RenderPipelineDesc):
                validate.render_pipeline_desc(desc)
            pipeline = self._pipelines[key] = NullPipeline(self, key, desc)
            self.counters.programs_compiled += 1
        pipeline.references += 1
        return pipeline

    def drop_pipeline(self, pipeline: NullPipeline) -> None:
        """Its last user let it go."""
        self._pipelines.pop(pipeline.key, None)

    def render_pass(
        self, label: str, colors: Sequence[ColorAttachment], depth: DepthAttachment | None = None
    ) -> NullRenderPass:
        self._check_no_pass(label)
        encoder = NullRenderPass(self, label, colors, depth)
        self._open_pass = label
        return encoder

    def compute_pass(self, label: str) -> NullComputePass:
        self._check_no_pass(label)
        self._open_pass = label
        return NullComputePass(self, label)

    def _check_no_pass(self, label: str) -> None:
        if self._open_pass is not None:
            raise validate.nested(label, self._open_pass)

    def end_pass(self, label: str) -> None:
        self._open_pass = None
        self.calls.add("end_pass", label=label)

    def copy_texture(self, source: Texture, target: Texture, layers: int) -> None:
        validate.texture_copy(source.desc, target.desc, layers)
        self.counters.api_calls += source.desc.mips
        self.calls.add("copy_texture", source=source.desc.label, target=target.desc.label, layers=layers)

    def generate_mips(self, texture: Texture) -> None:
        validate.generate_mips(texture.desc)
        self.counters.api_calls += 1
        self.calls.add("generate_mips", label=texture.desc.label)

    def present(self, texture: Texture, width: int, height: int) -> None:
        self.calls.add("present", label=texture.desc.label, width=width, height=height)

    def finish(self) -> None:
        self.calls.add("finish")

    def timestamp(self) -> int:
        return 0

    def resolve_timestamps(self, ids: Sequence[int]) -> list[int]:
        return [0] * len(ids)

    def begin_frame(self) -> None:
        self.calls.add("begin_frame")

    def end_frame(self) -> None:
        if self._open_pass is not None:
            left_open, self._open_pass = self._open_pass, None
            raise UsageError(f"end_frame before pass {left_open!r} has ended")
        self.calls.add("end_frame")

    def live_objects(self) -> dict[str, int]:
        return dict(self.live)

    def release(self) -> None:
        self._pipelines.clear()
        self._samplers.clear()
