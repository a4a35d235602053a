"""More than one bounce: what the layers reflect of light that was gathered at every fourth of their texels.

still    gather coarsely ─► reflect ─► smaller sizes, again for each bounce
motion   reflect what the frame before gathered, where it was then ─► gather coarsely for the next frame: one more
         bounce each frame, and nothing of a camera that jumped
"""

from __future__ import annotations

from typing import Any, ClassVar

from engine.framegraph.builder import Builder
from engine.framegraph.passes import WHOLE_PICTURE, Pass, PassContext
from engine.gpu.types import Buffer
from engine.render.facts import SceneFacts
from engine.render.frame import DEPTH_UNIT, DFG_UNIT, ENVIRONMENT_UNIT, INPUT_UNIT, RenderFrame
from engine.render.gi.block import block_of
from engine.render.gi.gather import (
    LIGHT_UNITS,
    LIGHTS,
    NEAR_FAR,
    SENT,
    SHAPE_UNITS,
    SHAPES,
    SIDES,
    dispatch,
    gather,
    levels_of,
    shrink,
)
from engine.render.passes.radiosity import OWN, size_of_layers

#: the size that is gathered at: a quarter of width and height
LEVEL = 2
#: rgba16f per layer: light over pi, part left to the environment; rg32f: how far both layers are
COARSE, COARSE_DEPTHS = ("coarse0_light", "coarse1_light"), "coarse_depths"
#: units in radiosity_bounce.comp
OWN_UNITS, COARSE_UNITS, COARSE_DEPTH_UNIT = (DEPTH_UNIT, 23), (22, 25), 24


class BouncesPass(Pass):
    name: ClassVar[str] = "bounces"
    reach: ClassVar[int | None] = WHOLE_PICTURE

    def needs(self, facts: SceneFacts) -> bool | str:
        if not facts.indirect.wanted:
            return facts.indirect.why_not
        return True if facts.indirect.again else "one bounce, and no environment light that surfaces reflect"

    def declare(self, b: Builder) -> None:
        quality = b.facts.indirect
        width, height = size_of_layers(b)
        level = min(LEVEL, levels_of(width, height) - 1)
        size = max(1, width >> level), max(1, height >> level)
        for name in (NEAR_FAR, SIDES):
            b.read(name)
        b.create(COARSE_DEPTHS, "rg32f", size=size)
        for layer in range(quality.layers):
            for names in (SHAPES, LIGHTS, OWN):
                b.read(names[layer])
            b.write(SENT[layer])
            b.create(COARSE[layer], "rgba16f", size=size)
        if quality.live:
            for name in (COARSE_DEPTHS, *COARSE[: quality.layers]):
                b.history(name)

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        quality = frame.facts.indirect
        if not quality.again:
            return  # forced to be here
        block = block_of(frame, known=not (quality.live and ctx.history_reset(COARSE_DEPTHS)))
        size = ctx.texture(NEAR_FAR).desc
        level = min(LEVEL, levels_of(size.width, size.height) - 1)
        if quality.live:
            self._reflect(ctx, block)
            self._gather(ctx, block, level)
            return
        for _ in range(quality.rounds):
            self._gather(ctx, block, level)
            self._reflect(ctx, block)

    def _gather(self, ctx: PassContext, block: Buffer, level: int) -> None:
        frame: RenderFrame = ctx.frame
        for layer in range(frame.facts.indirect.layers):
            gather(ctx, ctx.texture(COARSE[layer]), block, layer=layer, level=level)
        inputs = {INPUT_UNIT: (ctx.texture(NEAR_FAR), frame.point_sampler)}
        out = {1: (ctx.texture(COARSE_DEPTHS), 0, "write")}
        dispatch(ctx, "coarse_depths.comp", {"LEVEL": level}, inputs, out, block)

    def _reflect(self, ctx: PassContext, block: Buffer) -> None:
        frame: RenderFrame = ctx.frame
        quality = frame.facts.indirect
        found: Any = ctx.history if quality.live else ctx.texture
        named = {INPUT_UNIT: ctx.texture(NEAR_FAR), COARSE_DEPTH_UNIT: found(COARSE_DEPTHS)}
        for layer in range(quality.layers):
            for units, texture in (
                (SHAPE_UNITS, ctx.texture(SHAPES[layer])), (LIGHT_UNITS, ctx.texture(LIGHTS[layer])),
                (OWN_UNITS, ctx.texture(OWN[layer])), (COARSE_UNITS, found(COARSE[layer])),
            ):  # fmt: skip
                named[units[layer]] = texture
        inputs: dict[int, Any] = {unit: (texture, frame.point_sampler) for unit, texture in named.items()}
        inputs[ENVIRONMENT_UNIT] = frame.environment.texture, frame.environment.sampler
        inputs[DFG_UNIT] = frame.dfg.texture, frame.dfg.sampler
        defines = {
            "LAYERS": quality.layers, "LIVE": int(quality.live), "SKY": int(quality.sky),
            "LIT": int(quality.live or quality.bounces > 1),
        }  # fmt: skip
        images = {3 + layer: (ctx.texture(SENT[layer]), 0, "write") for layer in range(quality.layers)}
        dispatch(ctx, "radiosity_bounce.comp", defines, inputs, images, block)
        shrink(ctx, quality.layers, block)
