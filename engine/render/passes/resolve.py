"""The mean of the samples in scene-linear float32: what `.exr` output and measurements read."""

from __future__ import annotations

from typing import ClassVar

from engine.framegraph.builder import Builder
from engine.framegraph.passes import Pass, PassContext
from engine.gpu.types import ColorAttachment
from engine.render.facts import SceneFacts
from engine.render.frame import INPUT_UNIT, RenderFrame


class ResolvePass(Pass):
    name: ClassVar[str] = "resolve"
    reach: ClassVar[int | None] = 0

    def needs(self, facts: SceneFacts) -> bool | str:
        return True if facts.hdr_output else "no one asked for linear output"

    def declare(self, b: Builder) -> None:
        b.read("hdr")
        b.create("hdr_resolved", "rgba32f")
        if b.facts.hdr_output:
            b.present("hdr_resolved")

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        pipeline = frame.programs.screen("resolve.frag", defines={"SAMPLES": frame.facts.samples})
        target = ColorAttachment(ctx.texture("hdr_resolved"))
        with ctx.device.render_pass(self.name, [target]) as render_pass:
            render_pass.set_pipeline(pipeline)
            render_pass.set_bindings(frame.view_bindings({INPUT_UNIT: (ctx.texture("hdr"), frame.point_sampler)}))
            render_pass.draw(3)
