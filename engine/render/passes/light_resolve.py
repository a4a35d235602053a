"""The sum of light, made safe and rounded to the HDR target."""

from __future__ import annotations

from typing import ClassVar

from engine.framegraph.builder import Builder
from engine.framegraph.passes import Pass, PassContext
from engine.gpu.types import ColorAttachment
from engine.render.frame import DEPTH_UNIT, INPUT_UNIT, RenderFrame
from engine.render.gbuffer import texture_names
from engine.render.passes.light_volumes import gbuffer_inputs
from engine.render.passes.opaque import GATHERED, HDR_FORMAT, LIGHT_SUM

GATHERED_UNIT = 21


class LightResolvePass(Pass):
    name: ClassVar[str] = "light_resolve"
    reach: ClassVar[int | None] = 0

    def declare(self, b: Builder) -> None:
        b.read(LIGHT_SUM)
        b.read("depth")
        lighting = b.facts.lighting
        for name in (*texture_names(lighting.gbuffer), GATHERED) if lighting.three_pass else ():
            b.read(name)
        b.create("hdr", HDR_FORMAT)

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        target = ColorAttachment(ctx.texture("hdr"), clear=frame.look["background"])
        inputs = {
            INPUT_UNIT: (ctx.texture(LIGHT_SUM), frame.point_sampler),
            DEPTH_UNIT: (ctx.texture("depth"), frame.point_sampler),
        }
        lighting = frame.facts.lighting
        defines = {"THREE_PASS": int(lighting.three_pass)}
        if lighting.three_pass:
            defines |= {"GBUFFER_LAYOUT": lighting.gbuffer, **frame.facts.light_defines()}
            inputs |= {**gbuffer_inputs(ctx), GATHERED_UNIT: (ctx.texture(GATHERED), frame.point_sampler)}
        with ctx.device.render_pass(self.name, [target]) as render_pass:
            render_pass.set_pipeline(
                frame.programs.screen("light_resolve.frag", defines=defines, lights=lighting.three_pass)
            )
            bind = frame.light_bindings if lighting.three_pass else frame.view_bindings
            render_pass.set_bindings(bind(inputs))
            render_pass.draw(3)
