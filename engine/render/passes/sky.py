"""The environment behind the scene, where nothing nearer is."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from engine.framegraph.builder import Builder
from engine.framegraph.passes import Pass, PassContext
from engine.gpu.glsl_layout import Field, layout
from engine.gpu.types import ColorAttachment, DepthAttachment, DepthState
from engine.render.facts import SceneFacts
from engine.render.frame import PASS_BINDING, RenderFrame

BLOCK = layout([Field("blur", "float")], rule="std140")


class SkyPass(Pass):
    name: ClassVar[str] = "sky"
    reach: ClassVar[int | None] = 0

    def needs(self, facts: SceneFacts) -> bool | str:
        return True if facts.background else "the background is a plain colour"

    def declare(self, b: Builder) -> None:
        b.read("depth")
        b.write("hdr")

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        if not frame.facts.background:  # only with force_all: drawn, but it must not cover the plain colour
            return
        row = np.zeros((), BLOCK.dtype)
        row["blur"] = frame.look["background_blur"]
        block = frame.pass_block(self.name, row)
        pipeline = frame.programs.screen(
            "sky.frag", block=BLOCK, block_name="sky", depth=DepthState(test=True, write=False, compare="equal")
        )
        depth = DepthAttachment(ctx.texture("depth"), read_only=True)
        with ctx.device.render_pass(self.name, [ColorAttachment(ctx.texture("hdr"))], depth) as render_pass:
            render_pass.set_pipeline(pipeline)
            render_pass.set_bindings(frame.view_bindings(uniforms={PASS_BINDING: block}))
            render_pass.draw(3)
