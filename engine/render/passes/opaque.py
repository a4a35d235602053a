"""Opaque and alpha-tested surfaces: emission, environment and suns; local lights too where the path is a forward one,
else what these will need to know is written beside (the G-buffer)."""

from __future__ import annotations

from typing import Any, ClassVar

from engine.framegraph.builder import Builder
from engine.framegraph.passes import Pass, PassContext
from engine.gpu.types import ColorAttachment, DepthAttachment
from engine.render.facts import SceneFacts
from engine.render.frame import RenderFrame
from engine.render.gbuffer import LAYOUTS, NO_REFLECTION, texture_names
from engine.render.passes.ambient_occlusion import FILTERED, ambient_inputs
from engine.render.passes.indirect import INDIRECT, indirect_inputs
from engine.render.passes.light_culling import LIGHT_TILES, light_list_inputs
from engine.render.passes.local_shadows import local_shadow_inputs, read_local_shadows
from engine.render.passes.planar_reflections import PLANAR, PLANAR_REACH, planar_inputs
from engine.render.passes.reflections import REFLECTIONS, reflection_inputs
from engine.render.passes.shadow_cascades import SUN_MOMENTS, SUN_SHADOW, SUN_TINT, shadow_inputs

HDR_FORMAT = "rgba16f"

#: rgba32f: the sum of all light before it is rounded to the target, in deferred paths
LIGHT_SUM = "light_sum"

#: rgba16f: light apart from surfaces, in the three-pass form: diffuse light, luminance of the specular one
GATHERED = "light_gathered"


def surface_inputs(ctx: PassContext) -> dict[int, Any]:
    """What surface shaders look up besides their own textures, by texture unit."""
    return {
        **shadow_inputs(ctx), **local_shadow_inputs(ctx), **ambient_inputs(ctx), **indirect_inputs(ctx),
        **reflection_inputs(ctx), **planar_inputs(ctx),
    }  # fmt: skip


class OpaquePass(Pass):
    """Always there: it also clears the target to the background colour, so an empty scene is exactly that."""

    name: ClassVar[str] = "opaque"
    reach: ClassVar[int | None] = 0

    def declare(self, b: Builder) -> None:
        b.read(SUN_SHADOW, optional=True)
        b.read(SUN_MOMENTS, optional=True)
        b.read(SUN_TINT, optional=True)
        read_local_shadows(b)
        samples, lighting = b.facts.samples, b.facts.lighting
        if lighting.deferred:
            b.create(LIGHT_SUM, "rgba32f")
            if lighting.three_pass:
                b.create(GATHERED, "rgba16f")
            for name, format in zip(texture_names(lighting.gbuffer), LAYOUTS[lighting.gbuffer], strict=True):
                b.create(name, format)
        else:
            b.create("hdr", HDR_FORMAT, samples=samples)
        b.read(FILTERED, optional=True)
        b.read(INDIRECT, optional=True)
        b.read(REFLECTIONS, optional=True)
        b.read(PLANAR, optional=True)
        b.read(PLANAR_REACH, optional=True)
        if lighting.path == "forward-plus":
            b.read(LIGHT_TILES)
        if b.facts.depth_first:
            b.write("depth")
        else:
            b.create("depth", b.facts.depth_format, samples=samples)

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        lighting = frame.facts.lighting
        background: Any = frame.look["background"]
        batches = frame.draws.opaque
        inputs = surface_inputs(ctx)
        if lighting.deferred:
            colors = [ColorAttachment(ctx.texture(LIGHT_SUM), clear=background)]
            nothing = (float(NO_REFLECTION), 0.0, 0.0, 0.0)
            colors += [ColorAttachment(ctx.texture(n), clear=nothing) for n in texture_names(lighting.gbuffer)]
            batches = [batch for batch in batches if frame.programs.has_role(batch.state, "gbuffer")]
            if lighting.three_pass:
                clear_gathered = ColorAttachment(ctx.texture(GATHERED), clear=(0.0, 0.0, 0.0, 0.0))
                ctx.device.render_pass(f"{self.name} gathered", [clear_gathered]).end()
        else:
            colors = [ColorAttachment(ctx.texture("hdr"), clear=background)]
        clear = None
        if lighting.path == "forward-plus":
            inputs = {**inputs, **light_list_inputs(ctx)}
        if not frame.facts.depth_first:
            clear = 0.0
        with ctx.device.render_pass(self.name, colors, DepthAttachment(ctx.texture("depth"), clear)) as render_pass:
            frame.draw_batches(render_pass, batches, frame.facts.samples, inputs)


class OpaqueForwardPass(Pass):
    """What cannot be deferred: solid surfaces of effects without a technique for the G-buffer. Behind the lighting."""

    name: ClassVar[str] = "opaque_forward"
    reach: ClassVar[int | None] = 0

    def needs(self, facts: SceneFacts) -> bool | str:
        return True if facts.lighting.forward_only else "every solid surface has a G-buffer technique"

    def declare(self, b: Builder) -> None:
        b.read(SUN_SHADOW, optional=True)
        b.read(SUN_MOMENTS, optional=True)
        b.read(SUN_TINT, optional=True)
        read_local_shadows(b)
        b.read(FILTERED, optional=True)
        b.read(INDIRECT, optional=True)
        b.read(REFLECTIONS, optional=True)
        b.read(PLANAR, optional=True)
        b.read(PLANAR_REACH, optional=True)
        b.write("hdr")
        b.write("depth")

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        batches = [batch for batch in frame.draws.opaque if not frame.programs.has_role(batch.state, "gbuffer")]
        depth = DepthAttachment(ctx.texture("depth"))
        inputs = surface_inputs(ctx)
        with ctx.device.render_pass(self.name, [ColorAttachment(ctx.texture("hdr"))], depth) as render_pass:
            frame.draw_batches(render_pass, batches, frame.facts.samples, inputs)
