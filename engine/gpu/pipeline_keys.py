"""When two pipeline descriptors are the same pipeline. Shared by the backends' caches."""

from __future__ import annotations

from engine.gpu.types import ComputePipelineDesc, RenderPipelineDesc, ShaderSource


def sources_of(desc: RenderPipelineDesc | ComputePipelineDesc) -> tuple[ShaderSource, ...]:
    if isinstance(desc, ComputePipelineDesc):
        return (desc.compute,)
    return desc.stages


def program_key(desc: RenderPipelineDesc | ComputePipelineDesc) -> tuple[object, ...]:
    """Equal for equal text; a string keeps its hash, so this is cheap for long sources too."""
    return tuple([(source.stage, source.text) for source in sources_of(desc)])


def pipeline_key(desc: RenderPipelineDesc | ComputePipelineDesc) -> tuple[object, ...]:
    """Equal for descriptors that draw alike, whatever their labels and line maps."""
    if isinstance(desc, ComputePipelineDesc):
        return program_key(desc)
    return (
        *program_key(desc), desc.attributes, desc.topology, desc.depth, desc.blend, desc.raster, desc.stencil,
        desc.patch_vertices, desc.blend_constant,
    )  # fmt: skip
