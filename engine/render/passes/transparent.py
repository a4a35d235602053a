"""Blended surfaces, back to front, over what is there. Nearer opaque surfaces hide them; they write no depth.
Transmissive ones among them do, and see what is behind them in a copy of the picture (scene_color.py): what is solid,
and the sky. They take their turn among the others by distance; a blended or transmissive surface behind one is not seen
through it, as it is not in the copy (KHR_materials_transmission allows so)."""

from __future__ import annotations

from typing import ClassVar

from engine.framegraph.builder import Builder
from engine.framegraph.passes import Pass, PassContext
from engine.gpu.types import ColorAttachment, DepthAttachment
from engine.render.facts import SceneFacts
from engine.render.frame import RenderFrame
from engine.render.passes.light_culling import LIGHT_TILES, light_list_inputs
from engine.render.passes.local_shadows import local_shadow_inputs, read_local_shadows
from engine.render.passes.planar_reflections import PLANAR, PLANAR_REACH, planar_inputs
from engine.render.passes.scene_color import SCENE_COLOR, scene_color_inputs
from engine.render.passes.scene_front import SCENE_FRONT, scene_front_inputs
from engine.render.passes.shadow_cascades import SUN_MOMENTS, SUN_SHADOW, SUN_TINT, shadow_inputs


class TransparentPass(Pass):
    name: ClassVar[str] = "transparent"
    reach: ClassVar[int | None] = 0

    def needs(self, facts: SceneFacts) -> bool | str:
        return True if facts.transparent else "no blended material in the scene"

    def declare(self, b: Builder) -> None:
        if b.facts.transmission:
            b.write("depth")  # a solid body hides its own far side
        else:
            b.read("depth")
        b.read(SCENE_COLOR, optional=True)
        b.read(SCENE_FRONT, optional=True)
        b.read(SUN_SHADOW, optional=True)
        b.read(SUN_MOMENTS, optional=True)
        b.read(SUN_TINT, optional=True)
        read_local_shadows(b)
        b.read(PLANAR, optional=True)
        b.read(PLANAR_REACH, optional=True)
        b.read(LIGHT_TILES, optional=True)
        b.write("hdr")

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        depth = DepthAttachment(ctx.texture("depth"), read_only=not frame.facts.transmission)
        with ctx.device.render_pass(self.name, [ColorAttachment(ctx.texture("hdr"))], depth) as render_pass:
            inputs = {
                **shadow_inputs(ctx), **local_shadow_inputs(ctx), **light_list_inputs(ctx), **scene_color_inputs(ctx),
                **planar_inputs(ctx), **scene_front_inputs(ctx),
            }  # fmt: skip
            frame.draw_batches(render_pass, frame.draws.blended, frame.facts.samples, inputs)
