"""A copy of the picture of all that is solid, and the sky, with mips: what transmissive surfaces see behind them."""

from __future__ import annotations

from typing import Any, ClassVar

from engine.framegraph.builder import Builder
from engine.framegraph.passes import WHOLE_PICTURE, Pass, PassContext
from engine.gpu.types import ColorAttachment, SamplerDesc
from engine.render.facts import SceneFacts
from engine.render.frame import INPUT_UNIT, SCENE_COLOR_UNIT, RenderFrame

#: rgba16f, all mips, one sample a pixel
SCENE_COLOR = "scene_color"
_SMOOTH = SamplerDesc("clamp", "clamp", "clamp")


class SceneColorPass(Pass):
    name: ClassVar[str] = "scene_color"
    #: what is refracted may be anywhere in the picture
    reach: ClassVar[int | None] = WHOLE_PICTURE

    def needs(self, facts: SceneFacts) -> bool | str:
        return True if facts.transmission else "nothing shows what is behind it"

    def declare(self, b: Builder) -> None:
        b.read("hdr")
        b.create(SCENE_COLOR, "rgba16f", mips=0)

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        target = ctx.texture(SCENE_COLOR)
        pipeline = frame.programs.screen("scene_color.frag", defines={"SAMPLES": frame.facts.samples, "BLOOM": 0})
        with ctx.device.render_pass(self.name, [ColorAttachment(target)]) as render_pass:
            render_pass.set_pipeline(pipeline)
            render_pass.set_bindings(frame.view_bindings({INPUT_UNIT: (ctx.texture("hdr"), frame.point_sampler)}))
            render_pass.draw(3)
        ctx.device.generate_mips(target)


def scene_color_inputs(ctx: PassContext) -> dict[int, Any]:
    """The copy for shaders that look through, by texture unit."""
    frame: RenderFrame = ctx.frame
    if not frame.facts.transmission:
        return {}
    return {SCENE_COLOR_UNIT: (ctx.texture(SCENE_COLOR), ctx.device.sampler(_SMOOTH))}
