"""Smooth edges in the finished picture, where a pixel has one sample only."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from engine.framegraph.builder import Builder
from engine.framegraph.passes import Pass, PassContext
from engine.gpu.glsl_layout import Field, layout
from engine.gpu.types import ColorAttachment
from engine.render.facts import SceneFacts
from engine.render.frame import INPUT_UNIT, PASS_BINDING, RenderFrame
from engine.render.one_sample import reason

#: pixels that an edge is followed to each side
STEPS = 16
#: the picture with its steps
STEPPED = "color_stepped"

BLOCK = layout([Field("wanted", "float")], rule="std140")


class FxaaPass(Pass):
    name: ClassVar[str] = "fxaa"
    reach: ClassVar[int | None] = STEPS + 1

    def needs(self, facts: SceneFacts) -> bool | str:
        return True if facts.fxaa else reason(facts.samples, "antialias is not fxaa, or the view shows values")

    def declare(self, b: Builder) -> None:
        b.read("color")
        b.create(STEPPED, "rgba8")
        b.write("color")

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        row = np.zeros((), BLOCK.dtype)
        row["wanted"] = frame.facts.fxaa
        block = frame.pass_block(self.name, row)
        copy = frame.programs.screen("copy_picture.frag")
        smooth = frame.programs.screen("fxaa.frag", block=BLOCK, block_name="fxaa", defines={"STEPS": STEPS})
        for pipeline, source, target in ((copy, "color", STEPPED), (smooth, STEPPED, "color")):
            with ctx.device.render_pass(self.name, [ColorAttachment(ctx.texture(target))]) as render_pass:
                render_pass.set_pipeline(pipeline)
                render_pass.set_bindings(
                    frame.view_bindings({INPUT_UNIT: (ctx.texture(source), frame.point_sampler)}, {PASS_BINDING: block})
                )
                render_pass.draw(3)
