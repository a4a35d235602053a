"""How far what each pixel shows has moved since the frame before: as drawn, or from depth and cameras.

See engine/render/motion for the conventions."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from engine.framegraph.builder import Builder
from engine.framegraph.passes import Pass, PassContext
from engine.gpu.types import Bindings, ColorAttachment, DepthAttachment
from engine.render.effect_programs import EffectPrograms
from engine.render.facts import SceneFacts
from engine.render.frame import (
    DEPTH_UNIT,
    INPUT_UNIT,
    MATERIAL_BINDING,
    MORPH_BINDING,
    OBJECT_BINDING,
    PALETTE_BINDING,
    PASS_BINDING,
    TRANSFORM_BINDING,
    VIEW_BINDING,
    RenderFrame,
)
from engine.render.motion.request import BLOCK, ROLE, motion_request

#: rg16f, pixels; and what was drawn of it
MOTION, DRAWN = "motion", "motion_drawn"
#: in DRAWN where nothing moved by itself
UNMOVED = 32000.0


class MotionPass(Pass):
    """After the depth of what is seen is known and before anything is shaded, where depth comes first."""

    name: ClassVar[str] = "motion"
    reach: ClassVar[int | None] = 0

    def __init__(self) -> None:
        super().__init__()
        self._programs = EffectPrograms(ROLE, motion_request)

    def needs(self, facts: SceneFacts) -> bool | str:
        if not facts.motion:
            return "nothing is gathered over frames"
        return True if facts.depth_first else "depth is known later: see motion_late"

    def declare(self, b: Builder) -> None:
        b.read("depth")
        if b.facts.moving or b.facts.force_all:
            b.create(DRAWN, "rg16f", samples=b.facts.samples)
        b.create(MOTION, "rg16f")

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        motion, row = frame.motion, np.zeros((), BLOCK.dtype)
        row["clip_before"], row["before_from_now"] = motion.clip_before.T, motion.before_from_now.T
        row["jitter"], row["still"] = motion.jitter, motion.still or not motion.known
        row["drawn"] = bool(motion.batches)
        row["nodes"], row["joints"], row["morphs"] = motion.nodes, motion.joints, motion.morphs
        block = frame.pass_block("motion", row)
        inputs: dict[int, Any] = {DEPTH_UNIT: (ctx.texture("depth"), frame.point_sampler)}
        if ctx.has(DRAWN):
            self._draw(ctx, block)
            inputs[INPUT_UNIT] = (ctx.texture(DRAWN), frame.point_sampler)
        defines = {"SAMPLES": frame.facts.samples, "MOVING": int(ctx.has(DRAWN))}
        pipeline = frame.programs.compute("motion.comp", block=BLOCK, block_name="motion", defines=defines)
        with ctx.device.compute_pass(self.name) as compute_pass:
            compute_pass.set_pipeline(pipeline)
            uniforms = {VIEW_BINDING: frame.view_buffer, PASS_BINDING: block}
            compute_pass.set_bindings(Bindings(uniforms, {}, inputs, {1: (ctx.texture(MOTION), 0, "write")}))
            compute_pass.dispatch(-(-ctx.size[0] // 8), -(-ctx.size[1] // 8))

    def _draw(self, ctx: PassContext, block: Any) -> None:
        frame: RenderFrame = ctx.frame
        motion, materials = frame.motion, frame.residency.materials
        ids, commands = motion.ids, motion.commands
        if ids is None or commands is None:  # nothing moved: there is only the clear colour
            commands = ids = frame.draws.ids
        target = ColorAttachment(ctx.texture(DRAWN), clear=(UNMOVED, UNMOVED, 0.0, 0.0))
        depth = DepthAttachment(ctx.texture("depth"), read_only=True)
        with ctx.device.render_pass(f"{self.name} of things", [target], depth) as render_pass:
            for batch in motion.batches:
                state = batch.state
                if not frame.programs.has_role(state, ROLE):
                    continue
                arena = frame.residency.arenas[state.arena]
                render_pass.set_vertex_buffers({**arena.streams, "object": ids}, arena.indices)
                render_pass.set_bindings(
                    Bindings(
                        {VIEW_BINDING: frame.view_buffer, PASS_BINDING: block},
                        {
                            TRANSFORM_BINDING: frame.transforms,
                            OBJECT_BINDING: frame.draws.objects,
                            MATERIAL_BINDING: materials.buffer(state.effect),
                            PALETTE_BINDING: frame.palettes,
                            MORPH_BINDING: frame.morphs,
                        },
                        materials.bindings(state.group, frame.view.settings.anisotropy),
                    )
                )
                for index in range(frame.programs.passes(state, frame.facts, ROLE)):
                    if frame.programs.ahead.wants((state, ROLE, index)):
                        render_pass.set_pipeline(self._programs.get(frame, state, index))
                        render_pass.multi_draw_indexed_indirect(commands, batch.first, batch.count)


class LateMotionPass(MotionPass):
    """The same after everything solid is drawn, where depth does not come first; else it has no work."""

    name: ClassVar[str] = "motion_late"

    def needs(self, facts: SceneFacts) -> bool | str:
        if not facts.motion:
            return "nothing is gathered over frames"
        return "motion is known from the depth that was drawn first" if facts.depth_first else True

    def declare(self, b: Builder) -> None:
        if b.facts.depth_first:
            b.read(MOTION)
        else:
            super().declare(b)

    def execute(self, ctx: PassContext) -> None:
        if not ctx.frame.facts.depth_first:
            super().execute(ctx)
