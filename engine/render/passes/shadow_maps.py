"""The view of all shadow maps: the sun's cascades and the map of local lights, over the picture."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from engine.framegraph.builder import Builder
from engine.framegraph.passes import WHOLE_PICTURE, Pass, PassContext
from engine.gpu.glsl_layout import Field, layout
from engine.gpu.types import ColorAttachment
from engine.render.facts import SceneFacts
from engine.render.frame import LOCAL_DEPTH_UNIT, PASS_BINDING, SHADOW_UNIT, RenderFrame
from engine.render.passes.light_heat import OVER
from engine.render.passes.local_shadows import LOCAL_SHADOW
from engine.render.passes.shadow_cascades import SUN_SHADOW

BLOCK = layout([Field("cascades", "float"), Field("lamps", "float"), Field("covers", "float")], rule="std140")


class ShadowMapsPass(Pass):
    name: ClassVar[str] = "shadow_maps"
    reach: ClassVar[int | None] = WHOLE_PICTURE

    def needs(self, facts: SceneFacts) -> bool | str:
        return True if facts.debug_view == "shadow_maps" else "the view is not that of the shadow maps"

    def declare(self, b: Builder) -> None:
        b.read(SUN_SHADOW, optional=True)
        b.read(LOCAL_SHADOW, optional=True)
        b.write("hdr")

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        facts, row = frame.facts, np.zeros((), BLOCK.dtype)
        row["covers"] = facts.debug_view == "shadow_maps"  # where everything is forced, it is drawn, but covers nothing
        textures = {}
        for name, unit in ((SUN_SHADOW, SHADOW_UNIT), (LOCAL_SHADOW, LOCAL_DEPTH_UNIT)):
            if ctx.has(name):
                textures[unit] = (ctx.texture(name), frame.point_sampler)
        row["cascades"] = len(frame.shadows.cascades) if SHADOW_UNIT in textures and facts.sun_shadows else 0
        row["lamps"] = float(LOCAL_DEPTH_UNIT in textures and facts.local_shadows > 0)
        pipeline = frame.programs.screen("shadow_maps.frag", block=BLOCK, block_name="maps", blend=OVER)
        block = frame.pass_block(self.name, row)
        with ctx.device.render_pass(self.name, [ColorAttachment(ctx.texture("hdr"))]) as render_pass:
            render_pass.set_pipeline(pipeline)
            render_pass.set_bindings(frame.view_bindings(textures, {PASS_BINDING: block}))
            render_pass.draw(3)
