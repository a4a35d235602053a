"""Opaque and alpha-tested surfaces, shaded forward into the HDR target."""

from __future__ import annotations

from typing import Any, ClassVar

from engine.framegraph.builder import Builder
from engine.framegraph.passes import Pass, PassContext
from engine.gpu.types import ColorAttachment, DepthAttachment
from engine.render.frame import RenderFrame
from engine.render.passes.shadow_cascades import SUN_SHADOW, shadow_inputs

HDR_FORMAT = "rgba16f"


class OpaquePass(Pass):
    """Always there: it also clears the target to the background colour, so an empty scene is exactly that."""

    name: ClassVar[str] = "opaque"
    reach: ClassVar[int | None] = 0

    def declare(self, b: Builder) -> None:
        b.read(SUN_SHADOW, optional=True)
        samples = b.facts.samples
        b.create("hdr", HDR_FORMAT, samples=samples)
        b.create("depth", "d32f", samples=samples)

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        background: Any = frame.look["background"]
        color = ColorAttachment(ctx.texture("hdr"), clear=background)
        with ctx.device.render_pass(
            self.name, [color], DepthAttachment(ctx.texture("depth"), clear=0.0)
        ) as render_pass:
            frame.draw_batches(render_pass, frame.draws.opaque, frame.facts.samples, shadow_inputs(ctx))
