"""Descriptors and the device interface, shaped like WebGPU. Backends: `gl`, `null`.

Nothing above this package knows OpenGL. Clip space: z in [0,1], reversed (near 1, far 0), y up; texture row 0 and
framebuffer row 0 are the TOP row everywhere (the backend flips what its API wants flipped).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

from numpy.typing import NDArray

# --- formats -------------------------------------------------------------------------------------------------------

#: colour and data formats are those of engine.assets.texture.FORMATS plus these targets
TARGET_FORMATS = ("rg11b10f", "rgb10a2", "r32ui", "rg32ui", "d32f", "d32f-s8")


@dataclass(frozen=True, slots=True)
class Caps:
    """What this device can do."""

    backend: str
    device: str
    version: str
    software: bool
    reversed_z: bool
    compute: bool
    bc: bool
    max_texture_size: int
    max_array_layers: int
    max_anisotropy: float
    max_ssbo_bytes: int
    max_workgroup_invocations: int
    timestamps: bool
    extensions: frozenset[str] = frozenset()
    uniform_alignment: int = 256  # offsets of bound uniform and storage ranges are multiples of these
    storage_alignment: int = 256
    max_uniform_bytes: int = 65536
    max_samples: int = 1  # of a multisampled colour and depth texture
    sample_counts: tuple[int, ...] = ()  # that such textures really have, ascending; asked for others they get more
    tessellation: bool = True
    geometry: bool = True
    max_patch_vertices: int = 32

    def samples_for(self, wanted: int) -> int:
        """The least number of samples a pixel that textures have and that is at least `wanted`, else the most."""
        known = [n for n in self.sample_counts or (wanted,) if n <= self.max_samples]
        return next((n for n in known if n >= wanted), known[-1] if known else self.max_samples) if wanted > 1 else 1


# --- resources -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class TextureDesc:
    """`kind`: 2d | 2d-array | cube | 3d. `layers` counts 6 for a cube. `storage`/`target`: image store, attachment."""

    format: str
    width: int
    height: int
    kind: str = "2d"
    layers: int = 1
    depth: int = 1
    mips: int = 1
    samples: int = 1
    label: str = ""


@dataclass(frozen=True, slots=True)
class SamplerDesc:
    """`min_filter` as in engine.assets.material.FILTERS; wraps: repeat | mirror | clamp | border | mirror_once.
    `compare`: '' or a depth function as in DepthState. `border`: rgba beyond the edge, for wrap `border`. Levels of
    detail are counted in mips: `lod_bias` is added, then they are kept in [lod_min, lod_max]."""

    wrap_u: str = "repeat"
    wrap_v: str = "repeat"
    wrap_w: str = "clamp"
    min_filter: str = "linear_mip_linear"
    mag_filter: str = "linear"
    anisotropy: float = 1.0
    compare: str = ""
    border: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    lod_bias: float = 0.0
    lod_min: float = -1000.0
    lod_max: float = 1000.0


class Buffer(Protocol):
    size: int
    label: str

    def write(self, data: bytes | NDArray[Any], offset: int = 0) -> None:
        """Replace bytes from `offset`. Arrays must be C-contiguous."""

    def read(self, offset: int = 0, size: int = -1) -> bytes: ...

    def release(self) -> None: ...


class Texture(Protocol):
    desc: TextureDesc

    def write(self, data: bytes | memoryview | NDArray[Any], *, level: int = 0, layer: int = 0) -> None:
        """Upload one whole image of that level and layer, rows top to bottom, tightly packed; BCn as blocks."""

    def read(self, *, level: int = 0, layer: int = 0) -> NDArray[Any]:
        """Download one image: [height, width, channels] in the format's own number type (u1, f2, f4, u4);
        block-compressed formats come decoded."""

    @property
    def native(self) -> int:
        """The API's own name for it (GL texture id), for the editor's image widget; 0 on the null device."""

    def release(self) -> None: ...


class Sampler(Protocol):
    desc: SamplerDesc

    def release(self) -> None:
        """Nothing happens: samplers are shared and few, and live as long as the device."""


# --- pipelines -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class VertexAttribute:
    """`location` in the shader; `stream`: which vertex buffer (attributes that share one are interleaved, tightly, in
    the order given); `format`: f4x3, snorm16x4, unorm16x4, u2x4, u4x1 …;
    `per_instance`: advances once per instance (from base_instance)."""

    location: int
    stream: str
    format: str
    per_instance: bool = False


@dataclass(frozen=True, slots=True)
class BlendState:
    """Factors: zero one src_alpha one_minus_src_alpha dst_alpha one_minus_dst_alpha src_color one_minus_src_color
    dst_color one_minus_dst_color src_alpha_saturate constant one_minus_constant constant_alpha
    one_minus_constant_alpha (of RenderPipelineDesc.blend_constant); ops: add subtract reverse_subtract min max."""

    src: str = "one"
    dst: str = "zero"
    op: str = "add"
    src_alpha: str = "one"
    dst_alpha: str = "zero"
    op_alpha: str = "add"
    write_mask: str = "rgba"


@dataclass(frozen=True, slots=True)
class DepthState:
    """`compare`: never less equal lequal greater notequal gequal always. Reversed z: `greater`/`gequal` = nearer."""

    test: bool = True
    write: bool = True
    compare: str = "gequal"
    bias: float = 0.0
    bias_slope: float = 0.0


@dataclass(frozen=True, slots=True)
class StencilFace:
    """`compare`: (reference & read mask) against (stored & read mask). `fail`, `depth_fail`, `passed`: what then
    becomes of the stored value: keep zero replace increment decrement invert increment_wrap decrement_wrap."""

    compare: str = "always"
    fail: str = "keep"
    depth_fail: str = "keep"
    passed: str = "keep"


@dataclass(frozen=True, slots=True)
class StencilState:
    """Per face; masks and reference (0 to 255) are those of both."""

    front: StencilFace = StencilFace()
    back: StencilFace = StencilFace()
    reference: int = 0
    read_mask: int = 0xFF
    write_mask: int = 0xFF


@dataclass(frozen=True, slots=True)
class RasterState:
    """`cull`: none | back | front; front faces are counter-clockwise. `fill`: solid | wireframe. `alpha_to_coverage`:
    the alpha of target 0 decides which samples are covered. `sample_mask`: samples that are written at all. `scissor`:
    x, y, width, height as parts of the attachment (0 to 1, from the top left), or None for all of it. `clip_distances`:
    how many of gl_ClipDistance the last stage before the fragments writes."""

    cull: str = "back"
    front_ccw: bool = True
    fill: str = "solid"
    depth_clamp: bool = False
    alpha_to_coverage: bool = False
    sample_mask: int = 0xFFFFFFFF
    scissor: tuple[float, float, float, float] | None = None
    clip_distances: int = 0


@dataclass(frozen=True, slots=True)
class ShaderSource:
    """Flattened GLSL of one stage (no #version, the backend adds it) and the map back to the files.

    `lines[i]` = (file, line) of flattened line i+1, for error messages."""

    stage: str  # vertex | fragment | compute | geometry | tess_control | tess_evaluation
    text: str
    lines: tuple[tuple[str, int], ...] = ()


@dataclass(frozen=True, slots=True)
class RenderPipelineDesc:
    """All state of a draw in one value: two equal descs are the same pipeline.

    With a `tess_evaluation` stage the topology is `patches`: every `patch_vertices` indices are one patch. `stencil`
    needs a depth attachment of format d32f-s8; without one it does nothing."""

    label: str
    vertex: ShaderSource
    fragment: ShaderSource | None
    attributes: tuple[VertexAttribute, ...] = ()
    topology: str = "triangles"  # triangles | triangle_strip | lines | points | patches
    depth: DepthState | None = field(default_factory=DepthState)
    blend: tuple[BlendState | None, ...] = (None,)
    raster: RasterState = RasterState()
    stencil: StencilState | None = None
    tess_control: ShaderSource | None = None
    tess_evaluation: ShaderSource | None = None
    geometry: ShaderSource | None = None
    patch_vertices: int = 3
    blend_constant: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)

    @property
    def stages(self) -> tuple[ShaderSource, ...]:
        """The stages that there are, in the order of the pipeline."""
        stages = (self.vertex, self.tess_control, self.tess_evaluation, self.geometry, self.fragment)
        return tuple([stage for stage in stages if stage is not None])


@dataclass(frozen=True, slots=True)
class ComputePipelineDesc:
    label: str
    compute: ShaderSource

    @property
    def stages(self) -> tuple[ShaderSource, ...]:
        return (self.compute,)


class Pipeline(Protocol):
    """`loaded`: its program was not compiled but taken from the program cache."""

    label: str
    loaded: bool

    def block_size(self, name: str) -> int:
        """Size in bytes that the linked program gives to uniform or storage block `name` (a trailing unsized array
        counts as one element); -1 when it has no such active block, and always on the null device."""

    def release(self) -> None:
        """Equal descs share one pipeline; it goes when everyone who asked for it has released it."""


# --- passes --------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class ColorAttachment:
    """`clear`: rgba to clear to, or None to keep what is there. `layer` -1: all layers, chosen by gl_Layer."""

    texture: Texture
    level: int = 0
    layer: int = 0
    clear: tuple[float, float, float, float] | None = None


@dataclass(frozen=True, slots=True)
class DepthAttachment:
    """`read_only`: tested, never written, whatever the pipelines say. `layer` -1: all layers, chosen by gl_Layer.
    `clear`: also sets the stencil of a format that has one, to 0. `stencil`: the pipelines may write it, read-only
    depth or not."""

    texture: Texture
    clear: float | None = None
    layer: int = 0
    read_only: bool = False
    stencil: bool = True


@dataclass(frozen=True, slots=True)
class Bindings:
    """What shaders see, by explicit binding numbers. `uniforms`/`storage`: binding -> buffer or (buffer, offset, size).
    `textures`: unit -> (texture, sampler). `images`: unit -> (texture, level, access) for image load/store, all layers;
    access: read | write | read_write. The same object may be set again at no cost, so do not change its mappings."""

    uniforms: Mapping[int, Any] = field(default_factory=dict)
    storage: Mapping[int, Any] = field(default_factory=dict)
    textures: Mapping[int, tuple[Texture, Sampler]] = field(default_factory=dict)
    images: Mapping[int, tuple[Texture, int, str]] = field(default_factory=dict)


class RenderPass(Protocol):
    """Commands between begin (its creation) and end(); as a context manager it ends itself. The viewport starts as the
    whole attachment, y counting down from the top row. Index buffers hold u4. One pass is open at a time."""

    def set_pipeline(self, pipeline: Pipeline) -> None: ...
    def set_bindings(self, bindings: Bindings) -> None: ...
    def set_vertex_buffers(self, streams: Mapping[str, Buffer], index: Buffer | None = None) -> None: ...
    def set_viewport(self, x: int, y: int, width: int, height: int) -> None: ...
    def draw(self, vertex_count: int, instance_count: int = 1, first_vertex: int = 0) -> None: ...
    def draw_indexed(
        self,
        index_count: int,
        instance_count: int = 1,
        first_index: int = 0,
        base_vertex: int = 0,
        base_instance: int = 0,
    ) -> None: ...
    def multi_draw_indexed_indirect(self, commands: Buffer, first: int, count: int) -> None:
        """`commands`: u4[?,5] rows index_count, instance_count, first_index, base_vertex, base_instance."""

    def end(self) -> None: ...
    def __enter__(self) -> RenderPass: ...
    def __exit__(self, *args: object) -> None: ...


class ComputePass(Protocol):
    """What a dispatch writes is visible to the next dispatch and to everything after the pass."""

    def set_pipeline(self, pipeline: Pipeline) -> None: ...
    def set_bindings(self, bindings: Bindings) -> None: ...
    def dispatch(self, x: int, y: int = 1, z: int = 1) -> None: ...
    def end(self) -> None: ...
    def __enter__(self) -> ComputePass: ...
    def __exit__(self, *args: object) -> None: ...


@dataclass(slots=True)
class Counters:
    """What a device did since the last reset; deterministic, so tests and CI may gate on them."""

    api_calls: int = 0
    draws: int = 0
    dispatches: int = 0
    passes: int = 0
    pipelines_bound: int = 0
    instances: int = 0
    triangles: int = 0
    bytes_uploaded: int = 0
    bytes_read: int = 0
    programs_compiled: int = 0
    programs_loaded: int = 0  # taken from the program cache instead
    indirect_commands: int = 0

    def reset(self) -> None:
        for name in self.__slots__:
            setattr(self, name, 0)

    def snapshot(self) -> dict[str, int]:
        return {name: getattr(self, name) for name in self.__slots__}


class Device(Protocol):
    """Creates resources and passes. One per process and thread; see gpu.open_device()."""

    caps: Caps
    counters: Counters

    def buffer(self, data_or_size: bytes | int | NDArray[Any], *, label: str = "") -> Buffer: ...
    def texture(self, desc: TextureDesc) -> Texture:
        """Its contents are undefined until written or drawn; a buffer made by size is zeros."""

    def sampler(self, desc: SamplerDesc) -> Sampler:
        """Cached: equal descs give the same sampler."""

    def render_pipeline(self, desc: RenderPipelineDesc) -> Pipeline:
        """Cached by desc. Raises ShaderError with file:line:column when it does not compile."""

    def compute_pipeline(self, desc: ComputePipelineDesc) -> Pipeline: ...
    def begin_pipeline(self, desc: RenderPipelineDesc | ComputePipelineDesc) -> bool:
        """Start compiling, where the driver can do so aside; True when the pipeline can be had without a wait. Ask
        again until it is; mistakes are told by `render_pipeline`."""

    def abandon_pipelines(self) -> None:
        """Let go what was begun and nobody asked for."""

    def render_pass(
        self, label: str, colors: Sequence[ColorAttachment], depth: DepthAttachment | None = None
    ) -> RenderPass: ...
    def compute_pass(self, label: str) -> ComputePass: ...
    def copy_texture(self, source: Texture, target: Texture, layers: int) -> None:
        """Copy all mips of the first `layers` layers between textures of equal format and size."""

    def generate_mips(self, texture: Texture) -> None: ...
    def finish(self) -> None:
        """Wait until everything submitted is done."""

    def timestamp(self) -> int:
        """Queue a timestamp query and return its id; 0 where timestamps are not to be trusted (software, null)."""

    def resolve_timestamps(self, ids: Sequence[int]) -> list[int]:
        """Nanoseconds of finished queries; frees them."""

    def present(self, texture: Texture, width: int, height: int) -> None:
        """Copy a 2d texture to the window's framebuffer, which is width x height pixels, row 0 to the top. Attached
        devices only: on others it does nothing."""

    def begin_frame(self) -> None:
        """Take the API over from whoever used it since end_frame (the window's toolkit): no state is trusted."""

    def end_frame(self) -> None:
        """Free what was released on other threads, check for API errors in debug, and hand the API back in its
        default state."""

    def live_objects(self) -> dict[str, int]:
        """Counts of live GL objects by kind, for leak tests."""

    def release(self) -> None: ...
