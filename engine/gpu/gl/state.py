"""StateCache: what is bound in the context, so that only differences are sent to the driver.

Nothing is trusted after `invalidate` (the window's toolkit used the context). None stands for unknown.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from engine.gpu.gl import enums as e
from engine.gpu.types import Bindings, BlendState, DepthState, RasterState, StencilState

if TYPE_CHECKING:
    from engine.gpu.gl.device import GlDevice
    from engine.gpu.gl.pipeline import GlPipeline

_OFF = BlendState()
_DEPTH_OFF = DepthState(test=False, write=False, compare="always")

_TIGHT_PIXELS = (
    (e.UNPACK_ALIGNMENT, 1), (e.UNPACK_ROW_LENGTH, 0), (e.UNPACK_SKIP_ROWS, 0), (e.UNPACK_SKIP_PIXELS, 0),
    (e.UNPACK_IMAGE_HEIGHT, 0), (e.UNPACK_SKIP_IMAGES, 0), (e.PACK_ALIGNMENT, 1), (e.PACK_ROW_LENGTH, 0),
    (e.PACK_SKIP_ROWS, 0), (e.PACK_SKIP_PIXELS, 0), (e.PACK_IMAGE_HEIGHT, 0), (e.PACK_SKIP_IMAGES, 0),
)  # fmt: skip


class StateCache:
    """All binding calls of the frame loop go through here; each that reaches the driver counts one api call."""

    def __init__(self, device: GlDevice) -> None:
        self._device = device
        self._gl = device.gl
        self.invalidate()

    def invalidate(self) -> None:
        """Trust nothing."""
        self.program = -1
        self.framebuffer = -1
        self.vertex_array = -1
        self.indirect = -1
        self.viewport: tuple[int, int, int, int] | None = None
        self.bindings: Bindings | None = None
        self.uniforms: dict[int, Any] = {}
        self.storage: dict[int, Any] = {}
        self.textures: dict[int, int] = {}
        self.samplers: dict[int, int] = {}
        self.images: dict[int, tuple[int, int, int, int]] = {}
        self.depth: DepthState | None = None
        self.depth_write: bool | None = None
        self.raster: RasterState | None = None
        self.stencil: StencilState | None = None
        self.stencil_write = -1
        self.patch_vertices = -1
        self.blend_constant: tuple[float, float, float, float] | None = None
        self.sample_mask = -1
        self.scissor: tuple[int, int, int, int] | None = None
        self.blend: dict[int, BlendState] = {}
        self._enabled: dict[int, bool] = {}
        self._tight = False

    def forget(self, kind: str, name: int) -> None:
        """An object is deleted: the driver unbinds it and may give its name to the next one."""
        self.bindings = None
        if kind == "buffer":
            for table in (self.uniforms, self.storage):
                for binding in [b for b, (bound, _, _) in table.items() if bound == name]:
                    del table[binding]
            if self.indirect == name:
                self.indirect = -1
        elif kind == "texture":
            for unit in [u for u, bound in self.textures.items() if bound == name]:
                del self.textures[unit]
            for unit in [u for u, image in self.images.items() if image[0] == name]:
                del self.images[unit]
        elif kind == "sampler":
            for unit in [u for u, bound in self.samplers.items() if bound == name]:
                del self.samplers[unit]
        elif kind == "program" and self.program == name:
            self.program = -1
        elif kind == "framebuffer" and self.framebuffer == name:
            self.framebuffer = -1
        elif kind == "vertex_array" and self.vertex_array == name:
            self.vertex_array = -1

    # --- single switches -------------------------------------------------------------------------------------------

    def enable(self, what: int, on: bool) -> None:
        if self._enabled.get(what) is not on:
            (self._gl.Enable if on else self._gl.Disable)(what)
            self._enabled[what] = on
            self._device.counters.api_calls += 1

    def tight_pixels(self) -> None:
        """Uploads and downloads are tightly packed and use memory, not pixel buffers."""
        if not self._tight:  # never so between the frames of an attached device
            for what, value in _TIGHT_PIXELS:
                self._gl.PixelStorei(what, value)
            self._gl.BindBuffer(e.PIXEL_UNPACK_BUFFER, 0)
            self._gl.BindBuffer(e.PIXEL_PACK_BUFFER, 0)
            self._device.counters.api_calls += len(_TIGHT_PIXELS) + 2
            self._tight = True

    def default_pixels(self) -> None:
        """GL's own defaults again: what others who share the context count on."""
        for what, value in _TIGHT_PIXELS:
            self._gl.PixelStorei(what, 4 if value else 0)  # alignment 4, all else 0
        self._device.counters.api_calls += len(_TIGHT_PIXELS)
        self._tight = False

    def bind_framebuffer(self, name: int) -> None:
        if self.framebuffer != name:
            self._gl.BindFramebuffer(e.FRAMEBUFFER, name)
            self.framebuffer = name
            self._device.counters.api_calls += 1

    def bind_vertex_array(self, name: int) -> None:
        if self.vertex_array != name:
            self._gl.BindVertexArray(name)
            self.vertex_array = name
            self._device.counters.api_calls += 1

    def bind_indirect(self, name: int) -> None:
        if self.indirect != name:
            self._gl.BindBuffer(e.DRAW_INDIRECT_BUFFER, name)
            self.indirect = name
            self._device.counters.api_calls += 1

    def use_program(self, name: int) -> None:
        if self.program != name:
            self._gl.UseProgram(name)
            self.program = name
            self._device.counters.api_calls += 1

    def set_viewport(self, x: int, y: int, width: int, height: int) -> None:
        wanted = (x, y, width, height)
        if self.viewport != wanted:
            self._gl.Viewport(x, y, width, height)
            self.viewport = wanted
            self._device.counters.api_calls += 1

    # --- pipelines -------------------------------------------------------------------------------------------------

    def apply(
        self, pipeline: GlPipeline, *, may_write_depth: bool, size: tuple[int, int], may_write_stencil: bool = True
    ) -> None:
        """`size`: width and height of the attachments in pixels."""
        self.use_program(pipeline.id)
        if pipeline.patch_vertices and pipeline.patch_vertices != self.patch_vertices:
            self._gl.PatchParameteri(e.PATCH_VERTICES, pipeline.patch_vertices)
            self.patch_vertices = pipeline.patch_vertices
            self._device.counters.api_calls += 1
        self._apply_stencil(pipeline.stencil, may_write_stencil)
        depth = pipeline.depth or _DEPTH_OFF
        if depth is not self.depth and depth != self.depth:
            self._apply_depth(depth)
        self.write_depth(depth.write and may_write_depth)
        if pipeline.raster is not self.raster and pipeline.raster != self.raster:
            self._apply_raster(pipeline.raster)
        self._apply_scissor(pipeline.raster, size)
        if pipeline.blend_constant is not None and pipeline.blend_constant != self.blend_constant:
            self._gl.BlendColor(*pipeline.blend_constant)
            self.blend_constant = pipeline.blend_constant
            self._device.counters.api_calls += 1
        applied = self.blend
        for index, wanted in enumerate(pipeline.blend):
            blend = wanted or _OFF
            now = applied.get(index)
            if blend is not now and blend != now:
                self._apply_blend(index, blend)

    def _apply_depth(self, depth: DepthState) -> None:
        gl = self._gl
        # the test must be on for depth to be written at all
        self.enable(e.DEPTH_TEST, depth.test or depth.write)
        gl.DepthFunc(e.COMPARE[depth.compare] if depth.test else e.COMPARE["always"])
        biased = depth.bias != 0.0 or depth.bias_slope != 0.0
        self.enable(e.POLYGON_OFFSET_FILL, biased)
        self.enable(e.POLYGON_OFFSET_LINE, biased)
        gl.PolygonOffset(depth.bias_slope, depth.bias)
        self._device.counters.api_calls += 2
        self.depth = depth

    def write_depth(self, on: bool) -> None:
        if self.depth_write is not on:
            self._gl.DepthMask(on)
            self.depth_write = on
            self._device.counters.api_calls += 1

    def _apply_stencil(self, stencil: StencilState | None, may_write: bool) -> None:
        self.enable(e.STENCIL_TEST, stencil is not None)
        if stencil is None:
            return
        gl = self._gl
        if stencil != self.stencil:
            for side, face in ((e.FRONT, stencil.front), (e.BACK, stencil.back)):
                gl.StencilFuncSeparate(side, e.COMPARE[face.compare], stencil.reference, stencil.read_mask)
                op = e.STENCIL_OP
                gl.StencilOpSeparate(side, op[face.fail], op[face.depth_fail], op[face.passed])
            self._device.counters.api_calls += 4
            self.stencil = stencil
        self.write_stencil(stencil.write_mask if may_write else 0)

    def write_stencil(self, mask: int) -> None:
        if self.stencil_write != mask:
            self._gl.StencilMask(mask)
            self.stencil_write = mask
            self._device.counters.api_calls += 1

    def _apply_scissor(self, raster: RasterState, size: tuple[int, int]) -> None:
        self.enable(e.SCISSOR_TEST, raster.scissor is not None)
        if raster.scissor is None:
            return
        x, y, width, height = raster.scissor
        left, top = round(x * size[0]), round(y * size[1])
        wanted = (left, top, round((x + width) * size[0]) - left, round((y + height) * size[1]) - top)
        if self.scissor != wanted:
            self._gl.Scissor(*wanted)
            self.scissor = wanted
            self._device.counters.api_calls += 1

    def open_scissor(self) -> None:
        """Clears obey the scissor: let all pixels through."""
        self.enable(e.SCISSOR_TEST, False)

    def _apply_raster(self, raster: RasterState) -> None:
        gl = self._gl
        self.enable(e.CULL_FACE, raster.cull != "none")
        if raster.cull != "none":
            gl.CullFace(e.BACK if raster.cull == "back" else e.FRONT)
        gl.FrontFace(e.CCW if raster.front_ccw else e.CW)
        gl.PolygonMode(e.FRONT_AND_BACK, e.LINE if raster.fill == "wireframe" else e.FILL)
        self.enable(e.DEPTH_CLAMP, raster.depth_clamp)
        self.enable(e.CLIP_DISTANCE0, raster.clip_distances > 0)
        self.enable(e.SAMPLE_ALPHA_TO_COVERAGE, raster.alpha_to_coverage)
        self.enable(e.SAMPLE_MASK, raster.sample_mask != 0xFFFFFFFF)
        if raster.sample_mask not in (0xFFFFFFFF, self.sample_mask):
            gl.SampleMaski(0, raster.sample_mask)
            self.sample_mask = raster.sample_mask
            self._device.counters.api_calls += 1
        self._device.counters.api_calls += 3
        self.raster = raster

    def _apply_blend(self, index: int, blend: BlendState) -> None:
        gl = self._gl
        passes_through = (blend.src, blend.dst, blend.op, blend.src_alpha, blend.dst_alpha, blend.op_alpha) == (
            "one", "zero", "add", "one", "zero", "add",
        )  # fmt: skip
        if passes_through:
            gl.Disablei(e.BLEND, index)
        else:
            factor = e.BLEND_FACTOR
            gl.Enablei(e.BLEND, index)
            gl.BlendFuncSeparatei(
                index, factor[blend.src], factor[blend.dst], factor[blend.src_alpha], factor[blend.dst_alpha]
            )
            gl.BlendEquationSeparatei(index, e.BLEND_OP[blend.op], e.BLEND_OP[blend.op_alpha])
        mask = blend.write_mask
        gl.ColorMaski(index, "r" in mask, "g" in mask, "b" in mask, "a" in mask)
        self._device.counters.api_calls += 2 if passes_through else 4
        self.blend[index] = blend

    def open_color_mask(self, index: int) -> None:
        """Clears obey the colour mask: let all channels through."""
        now = self.blend.get(index)
        if now is None or now.write_mask != "rgba":
            self._apply_blend(index, _OFF)

    # --- bindings --------------------------------------------------------------------------------------------------

    def bind(self, bindings: Bindings) -> None:
        if bindings is self.bindings:
            return
        if bindings.uniforms:
            self._bind_buffers(e.UNIFORM_BUFFER, bindings.uniforms, self.uniforms)
        if bindings.storage:
            self._bind_buffers(e.SHADER_STORAGE_BUFFER, bindings.storage, self.storage)
        gl = self._gl
        calls = 0
        textures, samplers = self.textures, self.samplers
        for unit, (texture, sampler) in bindings.textures.items():
            name = texture.id  # type: ignore[attr-defined]  # only this backend's own textures get here
            if textures.get(unit) != name:
                gl.BindTextureUnit(unit, name)
                textures[unit] = name
                calls += 1
            name = sampler.id  # type: ignore[attr-defined]  # likewise
            if samplers.get(unit) != name:
                gl.BindSampler(unit, name)
                samplers[unit] = name
                calls += 1
        for unit, (image, level, access) in bindings.images.items():
            wanted = (image.id, level, e.ACCESS[access], image.internal)  # type: ignore[attr-defined]  # likewise
            if self.images.get(unit) != wanted:
                gl.BindImageTexture(unit, wanted[0], level, e.TRUE, 0, wanted[2], wanted[3])
                self.images[unit] = wanted
                calls += 1
        self._device.counters.api_calls += calls
        self.bindings = bindings

    def _bind_buffers(self, target: int, wanted: Any, bound: dict[int, Any]) -> None:
        for binding, entry in wanted.items():
            if type(entry) is tuple:
                key = (entry[0].id, entry[1], entry[2])
                if bound.get(binding) != key:
                    self._gl.BindBufferRange(target, binding, *key)
                    bound[binding] = key
                    self._device.counters.api_calls += 1
            else:
                key = (entry.id, 0, -1)
                if bound.get(binding) != key:
                    self._gl.BindBufferBase(target, binding, key[0])
                    bound[binding] = key
                    self._device.counters.api_calls += 1

    # --- taking over and handing back ------------------------------------------------------------------------------

    def take_over(self) -> None:
        """Set what this backend keeps constant, whatever was there before."""
        self.invalidate()
        gl = self._gl
        gl.ClipControl(e.UPPER_LEFT, e.ZERO_TO_ONE)
        gl.DepthRangef(0.0, 1.0)
        for what in (
            e.SCISSOR_TEST, e.STENCIL_TEST, e.FRAMEBUFFER_SRGB, e.PRIMITIVE_RESTART, e.RASTERIZER_DISCARD,
            e.SAMPLE_ALPHA_TO_COVERAGE, e.SAMPLE_MASK, e.COLOR_LOGIC_OP, e.DITHER,
        ):  # fmt: skip
            self.enable(what, False)
        for what in (e.TEXTURE_CUBE_MAP_SEAMLESS, e.PROGRAM_POINT_SIZE, e.MULTISAMPLE):
            self.enable(what, True)
        self._device.counters.api_calls += 2

    def hand_back(self) -> None:
        """Set GL's own defaults again, which toolkits count on."""
        gl = self._gl
        for unit in self.textures:
            gl.BindTextureUnit(unit, 0)
        for unit in self.samplers:
            gl.BindSampler(unit, 0)
        for unit in self.images:
            gl.BindImageTexture(unit, 0, 0, e.FALSE, 0, e.READ_ONLY, 0x8058)  # the format must be a valid one: RGBA8
        calls = len(self.textures) + len(self.samplers) + len(self.images)
        self.invalidate()
        gl.UseProgram(0)
        gl.BindFramebuffer(e.FRAMEBUFFER, 0)
        gl.BindVertexArray(0)
        for target in (e.DRAW_INDIRECT_BUFFER, e.PIXEL_PACK_BUFFER, e.PIXEL_UNPACK_BUFFER):
            gl.BindBuffer(target, 0)
        gl.ClipControl(e.LOWER_LEFT, e.NEGATIVE_ONE_TO_ONE)
        for what in (
            e.BLEND, e.CULL_FACE, e.DEPTH_TEST, e.SCISSOR_TEST, e.DEPTH_CLAMP, e.CLIP_DISTANCE0, e.POLYGON_OFFSET_FILL,
            e.POLYGON_OFFSET_LINE, e.TEXTURE_CUBE_MAP_SEAMLESS, e.PROGRAM_POINT_SIZE, e.STENCIL_TEST, e.SAMPLE_MASK,
            e.SAMPLE_ALPHA_TO_COVERAGE,
        ):  # fmt: skip
            gl.Disable(what)
        gl.Enable(e.DITHER)
        gl.BlendFunc(1, 0)
        gl.BlendEquation(e.BLEND_OP["add"])
        gl.ColorMask(1, 1, 1, 1)
        gl.DepthMask(1)
        gl.DepthFunc(e.COMPARE["less"])
        gl.CullFace(e.BACK)
        gl.FrontFace(e.CCW)
        gl.PolygonMode(e.FRONT_AND_BACK, e.FILL)
        gl.PolygonOffset(0.0, 0.0)
        gl.StencilMask(0xFFFFFFFF)
        gl.BlendColor(0.0, 0.0, 0.0, 0.0)
        self.default_pixels()
        gl.ActiveTexture(e.TEXTURE0)
        self._device.counters.api_calls += calls + 32
