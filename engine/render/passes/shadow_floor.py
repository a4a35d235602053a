"""Shadows and ambient occlusion on a level floor below the scene: they darken what is behind; it is not seen itself."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from engine.framegraph.builder import Builder
from engine.framegraph.passes import Pass, PassContext
from engine.gpu.glsl_layout import Field, layout
from engine.gpu.types import BlendState, ColorAttachment, DepthAttachment, DepthState
from engine.render.facts import SceneFacts
from engine.render.frame import ENVIRONMENT_UNIT, PASS_BINDING, RenderFrame
from engine.render.passes.ambient_occlusion import FILTERED, ambient_inputs
from engine.render.passes.local_shadows import local_shadow_inputs, read_local_shadows
from engine.render.passes.shadow_cascades import SUN_MOMENTS, SUN_SHADOW, shadow_inputs

BLOCK = layout([Field("height", "float"), Field("strength", "float")], rule="std140")
#: premultiplied; what the target keeps in alpha stays
DARKEN = BlendState("one", "one_minus_src_alpha", "add", "zero", "one", "add")


class ShadowFloorPass(Pass):
    """Debevec 1998, "Rendering Synthetic Objects into Real Scenes": what is behind, times the light that a white, matt
    floor has over the light that it would have with nothing on it."""

    name: ClassVar[str] = "shadow_floor"
    reach: ClassVar[int | None] = 0

    def needs(self, facts: SceneFacts) -> bool | str:
        return True if facts.shadow_floor else "no floor is asked for, or nothing throws a shadow or hides light"

    def declare(self, b: Builder) -> None:
        b.read("depth")
        b.read(SUN_SHADOW, optional=True)
        b.read(SUN_MOMENTS, optional=True)
        read_local_shadows(b)
        b.read(FILTERED, optional=True)
        b.write("hdr")

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        facts, floor = frame.facts, frame.shadows.floor
        if not facts.shadow_floor or floor is None:  # forced: it covers nothing
            return
        row = np.zeros((), BLOCK.dtype)
        row["height"] = floor - frame.origin[1]
        row["strength"] = frame.view.settings.shadow_floor
        pipeline = frame.programs.screen(
            "shadow_floor.frag", block=BLOCK, block_name="ground", lights=True, blend=DARKEN,
            depth=DepthState(test=True, write=False, compare="gequal"),
            defines={
                "SUN_SHADOWS": int(facts.sun_shadows or facts.force_all),
                "AMBIENT_VISIBILITY": int(facts.ambient_occlusion.wanted),
                "AMBIENT_OCCLUSION": facts.ambient_occlusion.shading & 3, **facts.light_defines(),
            },
        )  # fmt: skip
        inputs = {
            ENVIRONMENT_UNIT: (frame.environment.texture, frame.environment.sampler),
            **shadow_inputs(ctx), **local_shadow_inputs(ctx), **ambient_inputs(ctx),
        }  # fmt: skip
        depth = DepthAttachment(ctx.texture("depth"), read_only=True)
        with ctx.device.render_pass(self.name, [ColorAttachment(ctx.texture("hdr"))], depth) as render_pass:
            render_pass.set_pipeline(pipeline)
            render_pass.set_bindings(frame.light_bindings(inputs, {PASS_BINDING: frame.pass_block(self.name, row)}))
            render_pass.draw(3)
