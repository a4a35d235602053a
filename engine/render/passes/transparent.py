"""Blended surfaces, back to front, over what is there. Nearer opaque surfaces hide them; they write no depth."""

from __future__ import annotations

from typing import ClassVar

from engine.framegraph.builder import Builder
from engine.framegraph.passes import Pass, PassContext
from engine.gpu.types import ColorAttachment, DepthAttachment
from engine.render.facts import SceneFacts
from engine.render.frame import RenderFrame
from engine.render.passes.light_culling import LIGHT_TILES, light_list_inputs
from engine.render.passes.shadow_cascades import SUN_SHADOW, shadow_inputs


class TransparentPass(Pass):
    name: ClassVar[str] = "transparent"
    reach: ClassVar[int | None] = 0

    def needs(self, facts: SceneFacts) -> bool | str:
        return True if facts.transparent else "no blended material in the scene"

    def declare(self, b: Builder) -> None:
        b.read("depth")
        b.read(SUN_SHADOW, optional=True)
        b.read(LIGHT_TILES, optional=True)
        b.write("hdr")

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        depth = DepthAttachment(ctx.texture("depth"), read_only=True)
        with ctx.device.render_pass(self.name, [ColorAttachment(ctx.texture("hdr"))], depth) as render_pass:
            inputs = {**shadow_inputs(ctx), **light_list_inputs(ctx)}
            frame.draw_batches(render_pass, frame.draws.blended, frame.facts.samples, inputs)
