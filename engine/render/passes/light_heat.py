"""The lights-per-tile view: the length of each tile's list as a colour over the dimmed picture."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from engine.framegraph.builder import Builder
from engine.framegraph.passes import Pass, PassContext
from engine.gpu.glsl_layout import Field, layout
from engine.gpu.types import BlendState, ColorAttachment
from engine.render.facts import SceneFacts
from engine.render.frame import PASS_BINDING, RenderFrame
from engine.render.passes.light_culling import LIGHT_TILES, light_list_inputs

BLOCK = layout([Field("covers", "float")], rule="std140")
OVER = BlendState("src_alpha", "one_minus_src_alpha", "add", "one", "one_minus_src_alpha", "add")


class LightHeatPass(Pass):
    name: ClassVar[str] = "light_heat"
    #: a tile colours all of its pixels
    reach: ClassVar[int | None] = 32

    def needs(self, facts: SceneFacts) -> bool | str:
        return True if facts.debug_view == "light_tiles" else "the view is not that of lights per tile"

    def declare(self, b: Builder) -> None:
        b.read(LIGHT_TILES, optional=True)
        b.write("hdr")

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        lighting = frame.facts.lighting
        # where everything is forced, it is drawn, but it covers nothing; where nothing has lists, every tile has none
        row = np.zeros((), BLOCK.dtype)
        row["covers"] = frame.facts.debug_view == "light_tiles"
        lists = light_list_inputs(ctx) if frame.light_lists.columns else {}
        defines = {"LISTS": lighting.lists if lists and lighting.clustered else int(bool(lists))}
        pipeline = frame.programs.screen(
            "light_heat.frag", block=BLOCK, block_name="heat_block", defines=defines, blend=OVER
        )
        block = frame.pass_block(self.name, row)
        with ctx.device.render_pass(self.name, [ColorAttachment(ctx.texture("hdr"))]) as render_pass:
            render_pass.set_pipeline(pipeline)
            render_pass.set_bindings(frame.view_bindings(lists, {PASS_BINDING: block}))
            render_pass.draw(3)
