"""Depth of everything solid before it is shaded: the lists of lights are made from it, and nothing is shaded twice."""

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
        return True if facts.local_lights else "no local lights"

    def declare(self, b: Builder) -> None:
        b.create("depth", "d32f", samples=b.facts.samples)

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        batches = [batch for batch in frame.draws.opaque if frame.programs.has_role(batch.state, "depth")]
        with ctx.device.render_pass(self.name, [], DepthAttachment(ctx.texture("depth"), clear=0.0)) as render_pass:
            frame.draw_batches(render_pass, batches, frame.facts.samples, depth_only=True)
