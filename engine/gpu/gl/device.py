"""GlDevice: creates resources and passes on one OpenGL context."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from numpy.typing import NDArray

from engine.core.errors import UsageError
from engine.gpu import validate
from engine.gpu.gl import enums as e
from engine.gpu.gl.buffer import GlBuffer
from engine.gpu.gl.capabilities import probe, reversed_z_works
from engine.gpu.gl.compute_pass import GlComputePass
from engine.gpu.gl.context import open_context
from engine.gpu.gl.debug import DebugOutput
from engine.gpu.gl.framebuffer import Framebuffers
from engine.gpu.gl.objects import Objects
from engine.gpu.gl.pipeline import GlPipeline
from engine.gpu.gl.program_store import ProgramStore
from engine.gpu.gl.render_pass import GlRenderPass
from engine.gpu.gl.sampler import GlSampler
from engine.gpu.gl.shader import version_prelude
from engine.gpu.gl.state import StateCache
from engine.gpu.gl.texture import GlTexture
from engine.gpu.gl.timestamps import Timestamps
from engine.gpu.gl.vertex_array import VertexArrays
from engine.gpu.pipeline_keys import pipeline_key
from engine.gpu.types import (
    ColorAttachment,
    ComputePipelineDesc,
    Counters,
    DepthAttachment,
    RenderPipelineDesc,
    SamplerDesc,
    Texture,
    TextureDesc,
)

LARGE_BYTES = 1 << 24


class GlDevice:
    """See engine.gpu.types.Device. All calls must come from the thread that made it; `release` of resources may not."""

    _current: GlDevice | None = None  # whose context is current, as far as this class made it so

    def __init__(self, *, attach: bool = False, debug: bool = False) -> None:
        self.context = open_context(attach=attach)
        GlDevice._current = self
        self.gl = self.context.gl
        self.debug = debug
        self.attached = attach
        self.counters = Counters()
        self.caps = probe(self.context)
        self.shader_prelude = version_prelude(self.context.version, self.context.extensions)
        self.objects = Objects(self)
        self.state = StateCache(self)
        self.framebuffers = Framebuffers(self)
        self.vertex_arrays = VertexArrays(self)
        self._timestamps = Timestamps(self)
        self._errors = DebugOutput(self)
        self._samplers: dict[SamplerDesc, GlSampler] = {}
        self.programs = ProgramStore(self)
        self._pipelines: dict[object, GlPipeline] = {}
        self._pass: GlRenderPass | GlComputePass | None = None
        self._in_frame = False
        self._errors.discard()
        if debug:
            self._errors.listen()
        self.begin_frame()
        self.caps = replace(self.caps, reversed_z=reversed_z_works(self))
        self.end_frame()
        self.counters = Counters()

    # --- resources -------------------------------------------------------------------------------------------------

    def buffer(self, data_or_size: bytes | int | NDArray[Any], *, label: str = "") -> GlBuffer:
        self.ensure_current()
        return GlBuffer(self, data_or_size, label)

    def texture(self, desc: TextureDesc) -> GlTexture:
        self.ensure_current()
        return GlTexture(self, desc)

    def sampler(self, desc: SamplerDesc) -> GlSampler:
        sampler = self._samplers.get(desc)
        if sampler is None:
            self.ensure_current()
            sampler = self._samplers[desc] = GlSampler(self, desc)
        return sampler

    def render_pipeline(self, desc: RenderPipelineDesc) -> GlPipeline:
        return self._pipeline(desc)

    def compute_pipeline(self, desc: ComputePipelineDesc) -> GlPipeline:
        return self._pipeline(desc)

    def begin_pipeline(self, desc: RenderPipelineDesc | ComputePipelineDesc) -> bool:
        return pipeline_key(desc) in self._pipelines or self.programs.begin(desc)

    def abandon_pipelines(self) -> None:
        self.ensure_current()
        self.programs.abandon()

    def _pipeline(self, desc: RenderPipelineDesc | ComputePipelineDesc) -> GlPipeline:
        key = pipeline_key(desc)
        pipeline = self._pipelines.get(key)
        if pipeline is None:
            if isinstance(desc, RenderPipelineDesc):
                validate.render_pipeline_desc(desc)
            program = self.programs.get(desc)
            pipeline = self._pipelines[key] = GlPipeline(self, key, desc, program)
        pipeline.references += 1
        return pipeline

    def drop_pipeline(self, pipeline: GlPipeline) -> None:
        """Its last user let it go."""
        self._pipelines.pop(pipeline.key, None)
        self.programs.drop(pipeline.program)

    # --- passes ----------------------------------------------------------------------------------------------------

    def render_pass(
        self, label: str, colors: Sequence[ColorAttachment], depth: DepthAttachment | None = None
    ) -> GlRenderPass:
        self._begin_pass(label)
        try:
            encoder = GlRenderPass(self, label, colors, depth)
        except BaseException:  # an interrupt, too, ends the debug group
            self._close_group()
            raise
        self._pass = encoder
        return encoder

    def compute_pass(self, label: str) -> GlComputePass:
        self._begin_pass(label)
        encoder = GlComputePass(self, label)
        self._pass = encoder
        return encoder

    def _begin_pass(self, label: str) -> None:
        if self._pass is not None:
            raise validate.nested(label, self._pass.label)
        if not self._in_frame:
            self.begin_frame()
        elif GlDevice._current is not self:
            self.make_current()
        if self.debug:
            self.gl.PushDebugGroup(e.DEBUG_SOURCE_APPLICATION, 0, -1, label.encode())

    def end_pass(self, encoder: GlRenderPass | GlComputePass) -> None:
        self._pass = None
        self._close_group()
        if self.debug:
            self._errors.check(f"pass {encoder.label!r}")

    def _close_group(self) -> None:
        if self.debug:
            self.gl.PopDebugGroup()

    # --- copies ----------------------------------------------------------------------------------------------------

    def copy_texture(self, source: Texture, target: Texture, layers: int) -> None:
        assert isinstance(source, GlTexture)
        assert isinstance(target, GlTexture)
        self.ensure_current()
        source.copy_to(target, layers)

    def generate_mips(self, texture: Texture) -> None:
        validate.generate_mips(texture.desc)
        self.ensure_current()
        self.gl.GenerateTextureMipmap(texture.native)
        self.counters.api_calls += 1

    def present(self, texture: Texture, width: int, height: int) -> None:
        if not self.attached:
            return
        if texture.desc.kind != "2d" or texture.desc.samples > 1:
            raise UsageError(f"present takes a 2d texture, got {texture.desc}")
        source = self.framebuffers.get("present", [ColorAttachment(texture)], None)
        self.state.open_scissor()
        # the window's row 0 is its bottom row
        self.gl.BlitNamedFramebuffer(
            source, 0, 0, 0, texture.desc.width, texture.desc.height, 0, height, width, 0, e.COLOR_BUFFER_BIT,
            e.NEAREST if (texture.desc.width, texture.desc.height) == (width, height) else e.LINEAR,
        )  # fmt: skip
        self.counters.api_calls += 1

    # --- time ------------------------------------------------------------------------------------------------------

    def finish(self) -> None:
        self.ensure_current()
        self.gl.Finish()
        self.counters.api_calls += 1

    def timestamp(self) -> int:
        return self._timestamps.queue() if self.caps.timestamps else 0

    def resolve_timestamps(self, ids: Sequence[int]) -> list[int]:
        return self._timestamps.resolve(ids)

    def begin_frame(self) -> None:
        self.make_current()
        if self.attached and self.debug:
            self._errors.discard()  # what the window's toolkit did is not ours
        if self.attached or not self._in_frame:
            self.state.take_over()
        self._in_frame = True

    def end_frame(self) -> None:
        self.make_current()
        if self._pass is not None:
            left_open = self._pass.label
            self._pass.end()
            raise UsageError(f"end_frame before pass {left_open!r} has ended")
        self.objects.drain()
        if self.debug:
            self._errors.check("the frame")
        if self.attached:
            self.state.hand_back()
            self._in_frame = False

    def transfer_done(self) -> None:
        """After an upload or download: between frames the window's toolkit must not find its pixel store changed."""
        if not self._in_frame:
            self.state.default_pixels()

    def check_errors(self, where: str) -> None:
        """Raise DeviceError if the driver noted an error since the last check."""
        self.ensure_current()
        self._errors.check(where)

    # --- the context -----------------------------------------------------------------------------------------------

    def make_current(self) -> None:
        self.context.make_current()
        GlDevice._current = self

    def ensure_current(self) -> None:
        """Cheap: believes what this class did last. begin_frame and end_frame do not."""
        if GlDevice._current is not self:
            self.make_current()

    def before_allocation(self, size: int) -> None:
        """What the window's toolkit left undone is not to be taken for a failure of ours."""
        if self.attached and size >= LARGE_BYTES:
            self._errors.discard()

    def check_allocation(self, what: str, size: int) -> None:
        """Raise DeviceError where a large allocation failed; small ones are not worth the question."""
        if size >= LARGE_BYTES:
            self._errors.check(f"allocating {size >> 20} MiB for {what}")

    # --- objects ---------------------------------------------------------------------------------------------------

    def label(self, kind: str, name: int, text: str) -> None:
        """Name an object for frame debuggers and error messages."""
        if self.debug and text:
            self.gl.ObjectLabel(e.OBJECT_KINDS[kind], name, -1, text.encode()[:200])

    def forget(self, kind: str, name: int) -> None:
        """An object is about to be deleted: nothing may refer to its name any more."""
        if kind == "texture":
            self.framebuffers.forget_texture(name)
        elif kind == "buffer":
            self.vertex_arrays.forget_buffer(name)
        self.state.forget(kind, name)

    def live_objects(self) -> dict[str, int]:
        return dict(self.objects.live)

    def release(self) -> None:
        if not self.objects.open:
            return
        self.make_current()
        self.objects.drain()
        for pipeline in list(self._pipelines.values()):
            self.drop_pipeline(pipeline)
        self.programs.abandon()
        for sampler in self._samplers.values():
            sampler.destroy()
        self._samplers.clear()
        self._timestamps.clear()
        self.framebuffers.clear()
        self.vertex_arrays.clear()
        self._errors.stop()
        if self.attached:
            self.state.hand_back()
        self.objects.open = False
        if GlDevice._current is self:
            GlDevice._current = None
        self.context.release()
