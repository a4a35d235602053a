"""What stands in front of transmissive bodies: it must not be seen through them, however a ray is bent.

depth ─┐
       ├─► scene_front: depth of what may be seen through; NOWHERE where it is in front of the body that is there.
nearest transmissive surface (glass_depth)   Beside it its halves, of nearest depths: what blurred lookups mix
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any, ClassVar

from engine.framegraph.builder import Builder
from engine.framegraph.passes import WHOLE_PICTURE, Pass, PassContext
from engine.gpu.types import DepthAttachment, Pipeline
from engine.materials.effect import Effect
from engine.materials.variant import VariantRequest
from engine.render.draw_states import DrawState
from engine.render.facts import SceneFacts
from engine.render.frame import DEPTH_UNIT, INPUT_UNIT, SCENE_FRONT_UNIT, OtherRole, RenderFrame
from engine.render.other_programs import OtherPrograms
from engine.render.refraction import TESTED
from engine.render.variant_requests import depth_request
from engine.resources.arena import MeshArena

#: r32f, the picture and its halves (shaders/lib/scene_front.glsl); d32f
SCENE_FRONT, GLASS_DEPTH = "scene_front", "glass_depth"
ROLE = "depth"


class SceneFrontPass(Pass):
    name: ClassVar[str] = "scene_front"
    reach: ClassVar[int | None] = WHOLE_PICTURE

    def __init__(self) -> None:
        super().__init__()
        self._programs = OtherPrograms("depth of glass")

    def needs(self, facts: SceneFacts) -> bool | str:
        if not facts.transmission:
            return "nothing shows what is behind it"
        return True if facts.refraction == TESTED else "the view does not test what is seen through a body"

    def declare(self, b: Builder) -> None:
        b.read("depth")
        b.create(GLASS_DEPTH, "d32f")
        width, height = b.view_size
        halves = sum(max(1, height >> level) for level in range(1, levels_of(width, height)))
        b.create(SCENE_FRONT, "r32f", size=(width + max(1, width >> 1), max(height, halves)))

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        glass, front, point = ctx.texture(GLASS_DEPTH), ctx.texture(SCENE_FRONT), frame.point_sampler
        batches = [
            batch
            for batch in frame.draws.blended
            if batch.state.transmissive and frame.programs.has_role(batch.state, ROLE)
        ]
        role = OtherRole(ROLE, partial(self._program, frame), {}, self.name)
        with ctx.device.render_pass(GLASS_DEPTH, [], DepthAttachment(glass, clear=0.0)) as render_pass:
            frame.draw_batches(render_pass, batches, 1, other=role)
        inputs: dict[int, Any] = {
            DEPTH_UNIT: (ctx.texture("depth"), point), INPUT_UNIT: (glass, point),
        }  # fmt: skip
        for level in range(levels_of(*ctx.size)):
            defines = {"LEVEL": level, "SAMPLES": frame.facts.samples}
            width, height = (max(1, side >> level) for side in ctx.size)
            with ctx.device.compute_pass(self.name) as compute_pass:
                compute_pass.set_pipeline(frame.programs.compute("scene_front.comp", defines=defines))
                compute_pass.set_bindings(frame.pass_bindings(inputs, {}, {1: (front, 0, "read_write")}))
                compute_pass.dispatch(-(-width // 8), -(-height // 8))

    def _program(self, frame: RenderFrame, state: DrawState, index: int) -> Pipeline:
        key = frame.facts.quality
        return self._programs.get(frame, key, partial(_request, frame.facts), state, index)


def levels_of(width: int, height: int) -> int:
    """Mips of a picture of that size, itself included."""
    return max(width, height).bit_length()


def _request(facts: SceneFacts, state: DrawState, arena: MeshArena, effect: Effect, index: int) -> VariantRequest:
    return replace(depth_request(state, arena, replace(facts, alpha_to_coverage=False), effect), index=index)


def scene_front_inputs(ctx: PassContext) -> dict[int, Any]:
    """For shaders that look through, by texture unit; nothing where the frame has none."""
    if not ctx.has(SCENE_FRONT):
        return {}
    frame: RenderFrame = ctx.frame
    return {SCENE_FRONT_UNIT: (ctx.texture(SCENE_FRONT), frame.point_sampler)}
