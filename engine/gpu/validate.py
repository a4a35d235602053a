"""Checks of calls, shared by all backends so that a mistake found without a GPU reads as it does with one.

All raise UsageError (the call is wrong) or DeviceError (this device cannot), and say what was given and expected.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.assets.texture import mip_extent
from engine.core.errors import DeviceError, UsageError
from engine.gpu import formats
from engine.gpu.types import (
    Bindings,
    Caps,
    ColorAttachment,
    DepthAttachment,
    RenderPipelineDesc,
    SamplerDesc,
    Texture,
    TextureDesc,
    VertexAttribute,
)

KINDS = ("2d", "2d-array", "cube", "3d")
COMPARES = ("never", "less", "equal", "lequal", "greater", "notequal", "gequal", "always")
TOPOLOGIES = ("triangles", "triangle_strip", "lines", "points", "patches")
WRAPS = ("repeat", "mirror", "clamp", "border", "mirror_once")
STENCIL_OPS = (
    "keep", "zero", "replace", "increment", "decrement", "invert", "increment_wrap", "decrement_wrap",
)  # fmt: skip
STAGE_FIELDS = ("vertex", "tess_control", "tess_evaluation", "geometry", "fragment")
MIN_FILTERS = (
    "nearest",
    "linear",
    "nearest_mip_nearest",
    "linear_mip_nearest",
    "nearest_mip_linear",
    "linear_mip_linear",
)
ACCESSES = ("read", "write", "read_write")
#: what OpenGL 4.0 has at least, and all have
MAX_PATCH_VERTICES = 32


def named(kind: str, label: str) -> str:
    return f"{kind} {label!r}" if label else kind


def choice(what: str, value: str, allowed: Sequence[str]) -> None:
    if value not in allowed:
        raise UsageError(f"{what}: {value!r} is not one of {', '.join(allowed)}")


def as_bytes(data: Any) -> NDArray[np.uint8]:
    """A flat view of the bytes of an object with the buffer interface, without a copy. Arrays must be C-contiguous."""
    if isinstance(data, np.ndarray):
        if not data.flags.c_contiguous:
            raise UsageError(
                f"an array of shape {data.shape} and strides {data.strides} is not C-contiguous",
                hint="pass numpy.ascontiguousarray(...)",
            )
        return data.reshape(-1).view(np.uint8)
    return np.frombuffer(data, np.uint8)


def buffer_range(label: str, size: int, offset: int, count: int) -> None:
    if offset < 0 or count < 0 or offset + count > size:
        raise UsageError(f"{named('buffer', label)}: bytes [{offset}, {offset + count}) lie outside its {size} bytes")


def texture_desc(desc: TextureDesc, caps: Caps) -> None:
    name = named("texture", desc.label)
    choice(f"{name}: format", desc.format, tuple(formats.BLOCKS))
    choice(f"{name}: kind", desc.kind, KINDS)
    if min(desc.width, desc.height, desc.layers, desc.depth, desc.mips, desc.samples) < 1:
        raise UsageError(f"{name}: sizes and counts must be at least 1, got {desc}")
    if desc.samples > caps.max_samples:
        raise DeviceError(f"{name}: this device has at most {caps.max_samples} samples, got {desc.samples}")
    largest = max(desc.width, desc.height, desc.depth)
    if desc.mips > largest.bit_length():
        raise UsageError(f"{name}: {desc.mips} mips, but {largest} texels have at most {largest.bit_length()}")
    if desc.kind == "2d" and desc.layers != 1:
        raise UsageError(f"{name}: a 2d texture has 1 layer, got {desc.layers}", hint="use kind '2d-array'")
    if desc.kind == "cube" and (desc.layers % 6 or desc.width != desc.height):
        raise UsageError(f"{name}: a cube is square and has 6 layers, got {desc.width}x{desc.height}x{desc.layers}")
    if (desc.kind == "3d") != (desc.depth > 1) and desc.depth > 1:
        raise UsageError(f"{name}: only 3d textures have a depth, got kind {desc.kind!r} and depth {desc.depth}")
    if desc.kind == "3d" and desc.format in formats.DEPTH:
        raise UsageError(f"{name}: there are no 3d depth textures", hint="use kind '2d-array'")
    if desc.samples > 1 and (desc.kind != "2d" or desc.mips != 1 or desc.format in formats.COMPRESSED):
        raise UsageError(f"{name}: multisampled textures are 2d, uncompressed and have 1 mip")
    if largest > caps.max_texture_size or desc.layers > caps.max_array_layers:
        raise DeviceError(
            f"{name}: {desc.width}x{desc.height}x{max(desc.layers, desc.depth)} is more than this device's "
            f"{caps.max_texture_size} texels or {caps.max_array_layers} layers",
            hint="convert the texture with a smaller maximum size",
        )
    if desc.format in formats.COMPRESSED and not caps.bc:
        raise DeviceError(f"{name}: this device has no block compression", hint="convert with uncompressed textures")


def texture_image(desc: TextureDesc, level: int, layer: int) -> None:
    """`level` and `layer` (or slice) exist."""
    count = mip_extent(desc.depth, level) if desc.kind == "3d" else desc.layers
    if not (0 <= level < desc.mips and 0 <= layer < count):
        raise UsageError(
            f"{named('texture', desc.label)}: level {level}, layer {layer} does not exist "
            f"({desc.mips} mips, {count} layers)"
        )


def texture_write(desc: TextureDesc, level: int, layer: int, size: int) -> None:
    texture_image(desc, level, layer)
    if desc.samples > 1:
        raise UsageError(f"{named('texture', desc.label)}: multisampled textures can only be drawn into")
    if desc.format in formats.STENCIL:
        raise UsageError(f"{named('texture', desc.label)}: {desc.format} can only be drawn into")
    expected = formats.image_bytes(desc, level)
    if size != expected:
        width, height = formats.image_size(desc, level)
        raise UsageError(
            f"{named('texture', desc.label)}: level {level} is {width}x{height} {desc.format} = {expected} bytes, "
            f"got {size}"
        )


def texture_read(desc: TextureDesc, level: int, layer: int) -> None:
    texture_image(desc, level, layer)
    if desc.samples > 1:
        raise UsageError(f"{named('texture', desc.label)}: multisampled textures cannot be read back")


def texture_copy(source: TextureDesc, target: TextureDesc, layers: int) -> None:
    same = (source.format, source.width, source.height, source.depth, source.mips, source.kind) == (
        target.format, target.width, target.height, target.depth, target.mips, target.kind,
    )  # fmt: skip
    if not same:
        raise UsageError(f"copy_texture needs equal format, kind, size and mips: {source} to {target}")
    if not 0 < layers <= min(source.layers, target.layers):
        raise UsageError(f"copy_texture: {layers} layers of {source.layers} into {target.layers}")


def generate_mips(desc: TextureDesc) -> None:
    if desc.format in formats.COMPRESSED | formats.INTEGER | formats.DEPTH or desc.samples > 1:
        raise UsageError(f"{named('texture', desc.label)}: mips of {desc.format} cannot be generated by the device")


def sampler_desc(desc: SamplerDesc) -> None:
    for wrap in (desc.wrap_u, desc.wrap_v, desc.wrap_w):
        choice("sampler wrap", wrap, WRAPS)
    choice("sampler min_filter", desc.min_filter, MIN_FILTERS)
    choice("sampler mag_filter", desc.mag_filter, MIN_FILTERS[:2])
    if desc.compare:
        choice("sampler compare", desc.compare, COMPARES)


def render_pipeline_desc(desc: RenderPipelineDesc) -> None:
    choice(f"pipeline {desc.label!r}: topology", desc.topology, TOPOLOGIES)
    if desc.depth is not None:
        choice(f"pipeline {desc.label!r}: depth compare", desc.depth.compare, COMPARES)
    choice(f"pipeline {desc.label!r}: cull", desc.raster.cull, ("none", "back", "front"))
    choice(f"pipeline {desc.label!r}: fill", desc.raster.fill, ("solid", "wireframe"))
    locations = [a.location for a in desc.attributes]
    if len(set(locations)) != len(locations):
        raise UsageError(f"pipeline {desc.label!r}: a vertex attribute location is used twice: {sorted(locations)}")
    for name in STAGE_FIELDS:
        source = getattr(desc, name)
        if source is not None and source.stage != name:
            raise UsageError(f"pipeline {desc.label!r}: the source given for {name} is one of stage {source.stage}")
    _stages(desc)
    _stencil(desc)
    _scissor(desc)
    stream_strides(desc.attributes)


def _stages(desc: RenderPipelineDesc) -> None:
    patches = desc.topology == "patches"
    if patches != (desc.tess_evaluation is not None):
        raise UsageError(
            f"pipeline {desc.label!r}: topology {desc.topology!r} {'without' if patches else 'with'} a tess_evaluation "
            "stage; patches and that stage go together"
        )
    if desc.tess_control is not None and desc.tess_evaluation is None:
        raise UsageError(f"pipeline {desc.label!r}: a tess_control stage needs a tess_evaluation stage")
    if patches and not 1 <= desc.patch_vertices <= MAX_PATCH_VERTICES:
        raise UsageError(
            f"pipeline {desc.label!r}: a patch has 1 to {MAX_PATCH_VERTICES} vertices, got {desc.patch_vertices}"
        )


def _stencil(desc: RenderPipelineDesc) -> None:
    stencil = desc.stencil
    if stencil is None:
        return
    for side in ("front", "back"):
        face = getattr(stencil, side)
        choice(f"pipeline {desc.label!r}: stencil {side} compare", face.compare, COMPARES)
        for when in ("fail", "depth_fail", "passed"):
            choice(f"pipeline {desc.label!r}: stencil {side} {when}", getattr(face, when), STENCIL_OPS)
    for name in ("reference", "read_mask", "write_mask"):
        value = getattr(stencil, name)
        if not 0 <= value <= 255:
            raise UsageError(f"pipeline {desc.label!r}: stencil {name} is 0 to 255, got {value}")


def _scissor(desc: RenderPipelineDesc) -> None:
    if desc.raster.scissor is not None:
        x, y, width, height = desc.raster.scissor
        if min(x, y, width, height) < 0.0 or max(x + width, y + height) > 1.0 + 1e-6:
            raise UsageError(
                f"pipeline {desc.label!r}: the scissor {desc.raster.scissor} leaves the attachment (parts, 0 to 1)"
            )


def stream_strides(attributes: tuple[VertexAttribute, ...]) -> dict[str, tuple[int, bool]]:
    """stream -> (stride in bytes, per instance). Attributes of one stream are interleaved in the order given."""
    strides: dict[str, tuple[int, bool]] = {}
    for attribute in attributes:
        size = formats.vertex_format(attribute.format).size
        stride, per_instance = strides.get(attribute.stream, (0, attribute.per_instance))
        if per_instance != attribute.per_instance:
            raise UsageError(f"vertex stream {attribute.stream!r} is both per vertex and per instance")
        strides[attribute.stream] = (stride + size, per_instance)
    return strides


def attachments(label: str, colors: Sequence[ColorAttachment], depth: DepthAttachment | None) -> tuple[int, int]:
    """The attachments fit together; returns width and height in pixels."""
    if not colors and depth is None:
        raise UsageError(f"render pass {label!r} has no attachment")
    size: tuple[int, int] | None = None
    for attachment in (*colors, *(() if depth is None else (depth,))):
        desc = attachment.texture.desc
        is_depth = isinstance(attachment, DepthAttachment)
        if desc.format not in (formats.DEPTH if is_depth else formats.RENDERABLE):
            raise UsageError(
                f"render pass {label!r}: {named('texture', desc.label)} of format {desc.format} cannot be a "
                f"{'depth' if is_depth else 'colour'} attachment"
            )
        level = 0 if isinstance(attachment, DepthAttachment) else attachment.level
        if attachment.layer != -1:
            texture_image(desc, level, attachment.layer)
        extent = formats.image_size(desc, level)
        if size is not None and extent != size:
            raise UsageError(
                f"render pass {label!r}: attachments differ in size, {size[0]}x{size[1]} and {extent[0]}x{extent[1]} "
                f"({named('texture', desc.label)})"
            )
        size = extent
    assert size is not None
    return size


def bindings(label: str, value: Bindings, caps: Caps, attached: Sequence[Texture] = ()) -> None:
    """Ranges are aligned and inside, images storable, and nothing is drawn into while it is sampled."""
    for kind, blocks, alignment in (
        ("uniform", value.uniforms, caps.uniform_alignment),
        ("storage", value.storage, caps.storage_alignment),
    ):
        for binding, entry in blocks.items():
            if isinstance(entry, tuple):
                buffer, offset, size = entry
                buffer_range(buffer.label, buffer.size, offset, size)
                if offset % alignment:
                    raise UsageError(
                        f"pass {label!r}: {kind} binding {binding}: offset {offset} is not a multiple of {alignment}"
                    )
    for unit, (texture, sampler) in value.textures.items():
        if sampler is None:
            raise UsageError(f"pass {label!r}: texture unit {unit} has no sampler")
        if any(texture is other for other in attached):
            raise UsageError(
                f"pass {label!r}: {named('texture', texture.desc.label)} is sampled (unit {unit}) "
                "while it is drawn into"
            )
    for unit, (texture, level, access) in value.images.items():
        choice(f"pass {label!r}: image {unit} access", access, ACCESSES)
        texture_image(texture.desc, level, 0)
        if texture.desc.format not in formats.STORABLE:
            raise UsageError(f"pass {label!r}: image {unit}: {texture.desc.format} cannot be an image")


def vertex_buffers(label: str, pipeline_label: str, needed: Sequence[str], given: Sequence[str]) -> None:
    missing = [name for name in needed if name not in given]
    if missing:
        raise UsageError(
            f"pass {label!r}: pipeline {pipeline_label!r} needs vertex stream(s) {', '.join(missing)}, "
            f"given: {', '.join(given) or 'none'}"
        )


def index_range(label: str, index_bytes: int, first: int, count: int) -> None:
    if first < 0 or count < 0 or (first + count) * 4 > index_bytes:
        raise UsageError(
            f"pass {label!r}: indices [{first}, {first + count}) lie outside the index buffer of {index_bytes // 4}"
        )


def no_pipeline(label: str) -> UsageError:
    return UsageError(f"pass {label!r}: set_pipeline comes before draw and dispatch")


def no_index(label: str) -> UsageError:
    return UsageError(f"pass {label!r}: an indexed draw needs an index buffer (u4) in set_vertex_buffers")


def ended(label: str) -> UsageError:
    return UsageError(f"pass {label!r} has ended")


def nested(label: str, open_label: str) -> UsageError:
    return UsageError(f"pass {label!r} begins before pass {open_label!r} has ended")
