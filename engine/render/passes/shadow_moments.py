"""Moments of the sun's shadow maps, blurred: for filters that look them up instead of comparing depths."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from engine.framegraph.builder import Builder
from engine.framegraph.passes import WHOLE_PICTURE, Pass, PassContext
from engine.gpu.glsl_layout import Field, layout
from engine.gpu.types import Bindings, Texture
from engine.render.facts import SceneFacts
from engine.render.frame import INPUT_UNIT, PASS_BINDING, VIEW_BINDING, RenderFrame
from engine.render.kept import KeptParts
from engine.render.passes.shadow_cascades import SUN_MOMENTS, SUN_SHADOW
from engine.render.shadows.moments import MOST_TAPS, blur_weights, usable_exponent

#: blurred along x only
ROWS = "shadow_moment_rows"
#: of the moments' texture: a lookup far away takes the mean of so many halvings at most, as the cascades' margins allow
MIPS = 3

BLOCK = layout(
    [
        Field("exponent", "float"),
        Field("size", "int"),  # texels
        Field("layer", "int"),
        Field("taps", "int"),  # on each side of the middle
        Field("weights", "vec4", MOST_TAPS // 4 + 1),  # of the middle, one beside it, two …
        Field("corner", "ivec2"),  # of a lamp's tile, texels
        Field("far", "float"),  # m, where z is 1 for a lamp
    ],
    rule="std140",
)


class ShadowMomentsPass(Pass):
    """Kept from frame to frame as the maps are: what is drawn anew is blurred anew."""

    name: ClassVar[str] = "shadow_moments"
    reach: ClassVar[int | None] = WHOLE_PICTURE

    def __init__(self) -> None:
        super().__init__()
        self._made: KeptParts[int] = KeptParts()

    def needs(self, facts: SceneFacts) -> bool | str:
        if not facts.shadow_quality.moments:
            return "the shadows' filter compares depths"
        return True if facts.sun_shadows else "no shadows of the sun"

    def declare(self, b: Builder) -> None:
        quality = b.facts.shadow_quality
        if not quality.moments:  # a forced frame: nothing would look into them
            return
        size = (quality.size, quality.size)
        b.read(SUN_SHADOW)
        b.create(ROWS, quality.format, size=size)
        b.create(SUN_MOMENTS, quality.format, size=size, kind="2d-array", layers=quality.cascades, mips=MIPS)
        b.keep(SUN_MOMENTS)

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        settings, quality = frame.view.settings, frame.facts.shadow_quality
        if not quality.moments:
            return
        out = ctx.texture(SUN_MOMENTS)
        made = self._made.of(out)
        exponent = usable_exponent(float(settings.shadow_exponent), quality.precision)
        look = (exponent, float(settings.shadow_softness), quality.filter)
        # the depth's own texture is part of it: another one may not be whole yet
        keys = {i: (key, look, id(ctx.texture(SUN_SHADOW))) for i, key in enumerate(frame.shadows.keys or ["empty"])}
        stale = [layer for layer, key in keys.items() if made.get(layer) != key]
        for layer in stale:
            self._blur(ctx, out, layer, exponent)
            made[layer] = keys[layer]
        if stale:
            ctx.device.generate_mips(out)
        if frame.programs.ahead.skipping:  # the depths are not whole
            made.clear()

    def _blur(self, ctx: PassContext, out: Texture, layer: int, exponent: float) -> None:
        frame: RenderFrame = ctx.frame
        row = np.zeros((), BLOCK.dtype)
        row["exponent"], row["size"], row["layer"] = exponent, frame.facts.shadow_quality.size, layer
        targets = (ctx.texture(SUN_SHADOW), ctx.texture(ROWS), out)
        blur(frame, f"{self.name} {layer}", row, float(frame.view.settings.shadow_softness), targets)


def blur(
    frame: RenderFrame, label: str, row: NDArray[np.void], radius: float, textures: tuple[Texture, Texture, Texture],
    *, lamps: bool = False,
) -> None:  # fmt: skip
    """Moments of depth, blurred: (depth, what holds them blurred along x, where they go). `row`: of BLOCK, all but its
    weights; `radius`: texels; `lamps`: of a tile of the map of local lights."""
    weights, size = blur_weights(radius), int(row["size"])
    row["taps"] = len(weights) - 1
    row["weights"].reshape(-1)[: len(weights)] = weights
    block = frame.pass_block(label, row)
    depth, rows, out = textures
    for first, source, target in ((1, depth, rows), (0, rows, out)):
        defines = {"FIRST": first, "LAMPS": int(lamps), **frame.facts.light_defines()}
        pipeline = frame.programs.compute("shadow_moments.comp", block=BLOCK, block_name="blur", defines=defines)
        with frame.device.compute_pass(label) as compute_pass:
            compute_pass.set_pipeline(pipeline)
            uniforms = {VIEW_BINDING: frame.view_buffer, PASS_BINDING: block}
            bound = {INPUT_UNIT: (source, frame.point_sampler)}
            compute_pass.set_bindings(Bindings(uniforms, {}, bound, {1: (target, 0, "write")}))
            compute_pass.dispatch(-(-size // 16), -(-size // 8))
