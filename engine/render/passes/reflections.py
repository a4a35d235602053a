"""Smooth surfaces mirror what the layers of the deep G-buffer show; where they show nothing, the environment."""

from __future__ import annotations

from typing import Any, ClassVar

from engine.framegraph.builder import Builder
from engine.framegraph.passes import WHOLE_PICTURE, Pass, PassContext
from engine.gpu.types import Buffer, Texture
from engine.render.facts import SceneFacts
from engine.render.frame import DEPTH_UNIT, INPUT_UNIT, REFLECTION_UNIT, RenderFrame
from engine.render.gi.block import block_of
from engine.render.gi.gather import LIGHTS, NEAR_FAR, SENT, SHAPES, SIDES, dispatch, levels_of, sent_inputs
from engine.render.passes.radiosity import size_of_layers

#: rgba16f, as large as the layers: radiance, how sure it is
REFLECTIONS = "reflections"
#: rg32f, half their size and less: the nearest depth and the farthest of what is there
RANGES = "reflection_depths"
#: sizes of those at most
RANGE_LEVELS = 6
#: units of layer 0's matter and of the ranges in reflections.comp
MATTER_UNIT, RANGES_UNIT = 21, 22


class ReflectionsPass(Pass):
    name: ClassVar[str] = "reflections"
    reach: ClassVar[int | None] = WHOLE_PICTURE

    def needs(self, facts: SceneFacts) -> bool | str:
        if facts.indirect.wanted and not facts.indirect.reflections:
            return "reflections are off"
        return True if facts.indirect.wanted else facts.indirect.why_not

    def declare(self, b: Builder) -> None:
        for name in (NEAR_FAR, SIDES, *SENT[: b.facts.indirect.layers], SHAPES[0], LIGHTS[0]):
            b.read(name)
        b.create(REFLECTIONS, "rgba16f", scale=1.0 / b.facts.indirect.stride)
        width, height = size_of_layers(b)
        b.create(RANGES, "rg32f", size=(max(1, width // 2), max(1, height // 2)), mips=ranges_of(width, height))

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        quality, point, out = frame.facts.indirect, frame.point_sampler, ctx.texture(REFLECTIONS)
        block = block_of(frame, on=quality.reflections)
        ranges = self._ranges(ctx, block)
        inputs = {
            **sent_inputs(ctx, quality.layers), DEPTH_UNIT: (ctx.texture(SHAPES[0]), point),
            MATTER_UNIT: (ctx.texture(LIGHTS[0]), point), RANGES_UNIT: (ranges, point),
        }  # fmt: skip
        defines = {
            "STEPS": quality.reflection_steps, "LAYERS": quality.layers,
            "LEVELS": levels_of(out.desc.width, out.desc.height),
            "RANGES": ranges_of(out.desc.width, out.desc.height),
        }  # fmt: skip
        dispatch(ctx, "reflections.comp", defines, inputs, {1: (out, 0, "write")}, block)

    def _ranges(self, ctx: PassContext, block: Buffer) -> Texture:
        frame: RenderFrame = ctx.frame
        near_far, out = ctx.texture(NEAR_FAR), ctx.texture(RANGES)
        inputs = {INPUT_UNIT: (near_far, frame.point_sampler), 17: (out, frame.point_sampler)}
        for level in range(ranges_of(near_far.desc.width, near_far.desc.height)):
            dispatch(ctx, "reflection_depths.comp", {"LEVEL": level}, inputs, {1: (out, level, "write")}, block)
        return out


def ranges_of(width: int, height: int) -> int:
    """Smaller sizes of layers so wide and high."""
    return max(1, min(RANGE_LEVELS, max(width // 2, height // 2).bit_length()))


def reflection_inputs(ctx: PassContext) -> dict[int, Any]:
    """The mirrored light for surface shaders, by texture unit; nothing where the frame has none."""
    if not ctx.has(REFLECTIONS):
        return {}
    frame: RenderFrame = ctx.frame
    return {REFLECTION_UNIT: (ctx.texture(REFLECTIONS), frame.point_sampler)}
