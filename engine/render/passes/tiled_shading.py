"""Tiled deferred lighting: one compute dispatch over the pixels, each with the light list of its tile."""

from __future__ import annotations

from typing import ClassVar

from engine.framegraph.builder import Builder
from engine.framegraph.passes import Pass, PassContext
from engine.gpu.types import ColorAttachment
from engine.render.facts import SceneFacts
from engine.render.frame import INPUT_UNIT, RenderFrame
from engine.render.gbuffer import texture_names
from engine.render.passes.light_culling import LIGHT_TILES, light_list_inputs
from engine.render.passes.light_volumes import gbuffer_inputs
from engine.render.passes.local_shadows import local_shadow_inputs, read_local_shadows
from engine.render.passes.opaque import HDR_FORMAT, LIGHT_SUM


class TiledShadingPass(Pass):
    name: ClassVar[str] = "tiled_shading"
    reach: ClassVar[int | None] = 0

    def needs(self, facts: SceneFacts) -> bool | str:
        return True

    def declare(self, b: Builder) -> None:
        for name in (*texture_names(b.facts.lighting.gbuffer), "depth", LIGHT_SUM, LIGHT_TILES):
            b.read(name)
        read_local_shadows(b)
        b.create("hdr", HDR_FORMAT)

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        hdr = ctx.texture("hdr")
        ctx.device.render_pass(f"{self.name} background", [ColorAttachment(hdr, clear=frame.look["background"])]).end()
        lighting = frame.facts.lighting
        defines = {"GBUFFER_LAYOUT": lighting.gbuffer, "LOCAL_LIGHTS": 2, "LOOP_STEPS": lighting.steps}
        defines |= frame.facts.light_defines()
        pipeline = frame.programs.compute("tiled_shading.comp", lights=True, defines=defines)
        textures = {
            **gbuffer_inputs(ctx), **light_list_inputs(ctx), **local_shadow_inputs(ctx),
            INPUT_UNIT: (ctx.texture(LIGHT_SUM), frame.point_sampler),
        }  # fmt: skip
        width, height = ctx.size
        with ctx.device.compute_pass(self.name) as compute_pass:
            compute_pass.set_pipeline(pipeline)
            compute_pass.set_bindings(frame.light_bindings(textures, images={1: (hdr, 0, "write")}))
            compute_pass.dispatch(-(-width // 8), -(-height // 8))
