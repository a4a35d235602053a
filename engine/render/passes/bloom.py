"""Light scattered by the lens: the picture halved again and again, and brought back up as one sum of halos."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from engine.framegraph.builder import Builder
from engine.framegraph.passes import WHOLE_PICTURE, Pass, PassContext
from engine.gpu.glsl_layout import Field, layout
from engine.gpu.types import Bindings, Texture
from engine.render.bloom import level_sizes
from engine.render.facts import SceneFacts
from engine.render.frame import BLOOM_UNIT, INPUT_UNIT, PASS_BINDING, SHADOW_UNIT, VIEW_BINDING, RenderFrame
from engine.render.passes.opaque import HDR_FORMAT

#: the scattered light, as large as the picture; without its part that stays in its pixel
HALO = "bloom"

BLOCK = layout(
    [
        Field("finer", "vec2"),  # size of the larger picture
        Field("coarser", "vec2"),  # of the smaller one
        Field("coarser_part", "float"),
        Field("own_part", "float"),
    ],
    rule="std140",
)
#: unit of the picture that is added on the way up: no shadow is looked up here
OWN_UNIT = SHADOW_UNIT


class BloomPass(Pass):
    """Keeps the sum of light: what it adds to pixels around is taken from where it came from (`bloom_inputs`)."""

    name: ClassVar[str] = "bloom"
    reach: ClassVar[int | None] = WHOLE_PICTURE

    def needs(self, facts: SceneFacts) -> bool | str:
        return True if facts.bloom.wanted else facts.bloom.why_not

    def declare(self, b: Builder) -> None:
        b.read("hdr")
        b.create(HALO, HDR_FORMAT)
        for level, size in enumerate(level_sizes(*b.view_size, b.facts.bloom.levels)):
            if level > 0:
                b.create(f"{HALO} 1/{1 << level}", HDR_FORMAT, size=size)
            if 0 < level < b.facts.bloom.levels:
                b.create(f"{HALO} 1/{1 << level} sum", HDR_FORMAT, size=size)

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        levels, weights = frame.facts.bloom.levels, frame.look["bloom_weights"]
        halvings = [ctx.texture("hdr")] + [ctx.texture(f"{HALO} 1/{1 << k}") for k in range(1, levels + 1)]
        for k in range(levels):
            finer, coarser = halvings[k], halvings[k + 1]
            defines = {"SAMPLES": frame.facts.samples if k == 0 else 1,
                       "CALM": int(k == 0 and frame.facts.bloom.calm)}  # fmt: skip
            block = self._block(frame, f"down {k}", finer, coarser)
            self._dispatch(ctx, "bloom_down.comp", defines, {INPUT_UNIT: finer}, coarser, block)
        coarser, part = halvings[levels], float(weights[levels])
        for k in range(levels - 1, -1, -1):
            out = ctx.texture(f"{HALO} 1/{1 << k} sum") if k else ctx.texture(HALO)
            block = self._block(frame, f"up {k}", out, coarser, part, float(weights[k]))
            inputs = {INPUT_UNIT: coarser, **({OWN_UNIT: halvings[k]} if k else {})}
            self._dispatch(ctx, "bloom_up.comp", {"OWN": int(k > 0)}, inputs, out, block)
            coarser, part = out, 1.0

    def _block(
        self, frame: RenderFrame, name: str, finer: Texture, coarser: Texture, coarser_part: float = 1.0,
        own_part: float = 0.0,
    ) -> Any:  # fmt: skip
        row = np.zeros((), BLOCK.dtype)
        row["finer"] = finer.desc.width, finer.desc.height
        row["coarser"] = coarser.desc.width, coarser.desc.height
        row["coarser_part"], row["own_part"] = coarser_part, own_part
        return frame.pass_block(f"{self.name} {name}", row)

    def _dispatch(
        self, ctx: PassContext, shader: str, defines: dict[str, int], inputs: dict[int, Texture], out: Texture,
        block: Any,
    ) -> None:  # fmt: skip
        frame: RenderFrame = ctx.frame
        textures = {unit: (texture, frame.point_sampler) for unit, texture in inputs.items()}
        uniforms = {VIEW_BINDING: frame.view_buffer, PASS_BINDING: block}
        with ctx.device.compute_pass(shader.removesuffix(".comp")) as compute_pass:
            compute_pass.set_pipeline(frame.programs.compute(shader, block=BLOCK, block_name="bloom", defines=defines))
            compute_pass.set_bindings(Bindings(uniforms, {}, textures, {1: (out, 0, "write")}))
            compute_pass.dispatch(-(-out.desc.width // 8), -(-out.desc.height // 8))


def bloom_inputs(ctx: PassContext) -> dict[int, Any]:
    """The scattered light for passes that show the picture, by texture unit; nothing where the frame has none."""
    frame: RenderFrame = ctx.frame
    return {BLOOM_UNIT: (ctx.texture(HALO), frame.point_sampler)} if ctx.has(HALO) else {}


def bloom_parts(frame: RenderFrame) -> tuple[float, float]:
    """(of a pixel's own light, of the light in `HALO`): what the shown picture is made of."""
    if not frame.facts.bloom.wanted:
        return 1.0, 0.0
    scattered = float(frame.view.settings.bloom)
    return 1.0 - scattered * (1.0 - float(frame.look["bloom_weights"][0])), scattered
