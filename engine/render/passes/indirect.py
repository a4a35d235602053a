"""Light from other surfaces at each pixel: gathered from the layers, mixed with the frames before, and filtered."""

from __future__ import annotations

from typing import Any, ClassVar

from engine.framegraph.builder import Builder
from engine.framegraph.passes import WHOLE_PICTURE, Pass, PassContext
from engine.gpu.types import Buffer, Texture
from engine.render.facts import SceneFacts
from engine.render.frame import DEPTH_UNIT, INDIRECT_UNIT, INPUT_UNIT, RenderFrame
from engine.render.gi.block import block_of
from engine.render.gi.gather import DEPTHS, LIGHTS, NEAR_FAR, SENT, SHAPES, SIDES, dispatch, gather
from engine.render.passes.motion import MOTION

#: rgba16f: light over pi; part of the environment's light that is left
GATHERED, INDIRECT = "indirect_raw", "indirect"
#: rgba32f: the same, of this frame and those before; rg32f: how far the place is, how many frames are in it
MIXED, MIXED_STATE = "indirect_mixed", "indirect_state"
#: between both, in the layers' size: taps on each side, texels from one to the next
FILTERED, FILTERS = ("indirect_even", "indirect_wide"), ((2, 1), (1, 4))
#: unit of what moved in indirect_temporal.comp
MOTION_UNIT = 20
#: debug view -> LAYER_VIEW of indirect_filter.comp, and the second layer's textures there
LAYER_VIEWS, LAYER_UNITS = {"layer_color": 1, "layer_depth": 2}, {19: SHAPES, 21: LIGHTS, 22: DEPTHS}


class IndirectPass(Pass):
    name: ClassVar[str] = "indirect"
    reach: ClassVar[int | None] = WHOLE_PICTURE

    def needs(self, facts: SceneFacts) -> bool | str:
        if facts.indirect.wanted and not facts.indirect.gather:
            return "only reflections are on"
        return True if facts.indirect.wanted else facts.indirect.why_not

    def declare(self, b: Builder) -> None:
        quality = b.facts.indirect
        for name in ("depth", NEAR_FAR, SIDES, *SENT[: quality.layers], SHAPES[0]):
            b.read(name)
        if b.facts.debug_view in LAYER_VIEWS and quality.layers > 1:
            for names in (DEPTHS, SHAPES, LIGHTS):
                b.read(names[1])
        scale = 1.0 / quality.stride
        b.create(GATHERED, "rgba16f", scale=scale)
        if quality.smooth:
            b.read(MOTION)
            b.create(MIXED, "rgba32f", scale=scale)  # means of many frames in half floats stop short of their limit
            b.create(MIXED_STATE, "rg32f", scale=scale)
            b.history(MIXED)
            b.history(MIXED_STATE)
        for name in FILTERED:
            b.create(name, "rgba16f", scale=scale)
        b.create(INDIRECT, "rgba16f")

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        quality, point = frame.facts.indirect, frame.point_sampler
        found = ctx.texture(GATHERED)
        gather(ctx, found, block_of(frame, on=quality.gather))
        if quality.smooth:
            found = self._mixed(ctx, found, block_of(frame, known=not ctx.history_reset(MIXED)))
        layers = {17: (ctx.texture(NEAR_FAR), point), 18: (ctx.texture(SIDES), point)}
        noisy = found
        for name, (radius, apart) in zip(FILTERED, FILTERS, strict=True):
            defines = {"WHOLE": 0, "LAYER_VIEW": 0, "RADIUS": radius, "APART": apart, "NOISY": int(apart > 1)}
            out = {1: (ctx.texture(name), 0, "write")}
            inputs = {**layers, INPUT_UNIT: (found, point), 19: (noisy, point)}
            dispatch(ctx, "indirect_filter.comp", defines, inputs, out, block_of(frame), label=name)
            found = ctx.texture(name)
        inputs = {**layers, DEPTH_UNIT: (ctx.texture("depth"), point), INPUT_UNIT: (found, point)}
        shown = LAYER_VIEWS.get(frame.facts.debug_view, 0) if quality.layers > 1 else 0
        if shown:
            inputs |= {unit: (ctx.texture(names[1]), point) for unit, names in LAYER_UNITS.items()}
        defines = {"WHOLE": 1, "SAMPLES": frame.facts.samples, "LAYER_VIEW": shown, "RADIUS": 1, "APART": 1, "NOISY": 0}
        out = {1: (ctx.texture(INDIRECT), 0, "write")}
        dispatch(ctx, "indirect_filter.comp", defines, inputs, out, block_of(frame, on=quality.gather))

    def _mixed(self, ctx: PassContext, now: Texture, block: Buffer) -> Texture:
        frame: RenderFrame = ctx.frame
        mixed = ctx.texture(MIXED)
        textures = {
            INPUT_UNIT: now, 17: ctx.texture(NEAR_FAR), 18: ctx.history(MIXED), 19: ctx.history(MIXED_STATE),
            MOTION_UNIT: ctx.texture(MOTION),
        }  # fmt: skip
        inputs = {unit: (texture, frame.point_sampler) for unit, texture in textures.items()}
        out = {1: (mixed, 0, "write"), 2: (ctx.texture(MIXED_STATE), 0, "write")}
        dispatch(ctx, "indirect_temporal.comp", {}, inputs, out, block)
        return mixed


def indirect_inputs(ctx: PassContext) -> dict[int, Any]:
    """The light for surface shaders, by texture unit; nothing where the frame has none."""
    if not ctx.has(INDIRECT):
        return {}
    frame: RenderFrame = ctx.frame
    return {INDIRECT_UNIT: (ctx.texture(INDIRECT), frame.point_sampler)}
