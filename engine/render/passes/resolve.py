"""The mean of the samples in scene-linear float32, with what the lens scattered: what `.exr` output and measurements
read."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from engine.framegraph.builder import Builder
from engine.framegraph.passes import Pass, PassContext
from engine.gpu.glsl_layout import Field, layout
from engine.gpu.types import ColorAttachment
from engine.render.facts import SceneFacts
from engine.render.frame import INPUT_UNIT, PASS_BINDING, RenderFrame
from engine.render.passes.bloom import HALO, bloom_inputs, bloom_parts

BLOCK = layout([Field(name, "float") for name in ("bloom_kept", "bloom_scattered")], rule="std140")


class ResolvePass(Pass):
    name: ClassVar[str] = "resolve"
    reach: ClassVar[int | None] = 0

    def needs(self, facts: SceneFacts) -> bool | str:
        return True if facts.hdr_output else "no one asked for linear output"

    def declare(self, b: Builder) -> None:
        b.read("hdr")
        b.read(HALO, optional=True)
        b.create("hdr_resolved", "rgba32f")
        if b.facts.hdr_output:
            b.present("hdr_resolved")

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        row, scattered = np.zeros((), BLOCK.dtype), bloom_inputs(ctx)
        row["bloom_kept"], row["bloom_scattered"] = bloom_parts(frame)
        block = frame.pass_block(self.name, row)
        defines = {"SAMPLES": frame.facts.samples, "BLOOM": int(bool(scattered))}
        pipeline = frame.programs.screen("resolve.frag", block=BLOCK, block_name="resolve", defines=defines)
        target = ColorAttachment(ctx.texture("hdr_resolved"))
        with ctx.device.render_pass(self.name, [target]) as render_pass:
            render_pass.set_pipeline(pipeline)
            render_pass.set_bindings(
                frame.view_bindings(
                    {INPUT_UNIT: (ctx.texture("hdr"), frame.point_sampler), **scattered}, {PASS_BINDING: block}
                )
            )
            render_pass.draw(3)
