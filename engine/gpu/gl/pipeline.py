"""GlPipeline: a program and the state it is drawn with, shared by equal descriptors."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from engine.gpu import validate
from engine.gpu.gl import enums as e
from engine.gpu.gl.shader import GlProgram
from engine.gpu.pipeline_keys import sources_of
from engine.gpu.types import BlendState, ComputePipelineDesc, RenderPipelineDesc

if TYPE_CHECKING:
    from engine.gpu.gl.device import GlDevice

_IMAGE = re.compile(r"\bimage(?:Store|Atomic\w+)\s*\(")
_STORAGE = re.compile(r"layout\s*\([^)]*\)\s*((?:\w+\s+)*?)buffer\b")


def writes_memory(text: str) -> bool:
    """Whether a stage may write a storage buffer or an image, so that what follows must wait. May say yes too often
    (the text may be switched off by macros), never no too often."""
    return bool(_IMAGE.search(text)) or any("readonly" not in found for found in _STORAGE.findall(text))


def _uses_constant(blend: BlendState | None) -> bool:
    factors = () if blend is None else (blend.src, blend.dst, blend.src_alpha, blend.dst_alpha)
    return any("constant" in factor for factor in factors)


class GlPipeline:
    """`references` counts the callers that asked for it; the last release frees it."""

    __slots__ = (
        "_device", "attributes", "blend", "blend_constant", "depth", "id", "key", "label", "loaded", "mode",
        "patch_vertices", "program", "raster", "references", "stencil", "streams", "writes",
    )  # fmt: skip

    def __init__(
        self, device: GlDevice, key: object, desc: RenderPipelineDesc | ComputePipelineDesc, program: GlProgram
    ) -> None:
        self._device = device
        self.key = key
        self.label = desc.label
        self.program = program
        self.id = program.id
        self.loaded = program.loaded
        program.references += 1
        self.references = 0
        if isinstance(desc, RenderPipelineDesc):
            self.attributes = desc.attributes
            self.streams = tuple(validate.stream_strides(desc.attributes))
            self.mode = e.TOPOLOGY[desc.topology]
            self.depth = desc.depth
            self.blend = desc.blend
            self.raster = desc.raster
            self.stencil = desc.stencil
            self.patch_vertices = desc.patch_vertices if desc.topology == "patches" else 0
            self.blend_constant = desc.blend_constant if any(map(_uses_constant, desc.blend)) else None
        self.writes = any(writes_memory(source.text) for source in sources_of(desc))

    def block_size(self, name: str) -> int:
        self._device.ensure_current()
        return self.program.block_size(self._device, name)

    def release(self) -> None:
        self.references -= 1
        if self.references == 0:
            self._device.drop_pipeline(self)
