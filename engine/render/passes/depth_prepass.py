"""Depth of everything solid before it is shaded: lists of lights and ambient occlusion are made from it, and nothing is
shaded twice."""

from __future__ import annotations

from typing import ClassVar

from engine.framegraph.builder import Builder
from engine.framegraph.passes import Pass, PassContext
from engine.gpu.types import DepthAttachment
from engine.render.facts import SceneFacts
from engine.render.frame import RenderFrame


class DepthPrepass(Pass):
    name: ClassVar[str] = "depth_prepass"
    reach: ClassVar[int | None] = 0

    def needs(self, facts: SceneFacts) -> bool | str:
        lists = facts.local_lights and facts.lighting.path == "forward-plus"
        if lists or facts.ambient_occlusion.wanted or facts.indirect.wanted or facts.depth_asked:
            return True
        return "nothing is made from it, and depth_first is off"

    def declare(self, b: Builder) -> None:
        b.create("depth", b.facts.depth_format, samples=b.facts.samples)

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        batches = [batch for batch in frame.draws.opaque if frame.programs.has_role(batch.state, "depth")]
        if frame.facts.debug_view in ("wireframe", "overdraw"):
            batches = []  # forced to be here: it would hide the edges and fragments that these views are about
        with ctx.device.render_pass(self.name, [], DepthAttachment(ctx.texture("depth"), clear=0.0)) as render_pass:
            frame.draw_batches(render_pass, batches, frame.facts.samples, depth_only=True)
