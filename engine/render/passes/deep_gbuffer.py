"""The deep G-buffer: what is seen, and the nearest surface behind it that is a minimum separation away. Unlit."""

from __future__ import annotations

from functools import partial
from typing import ClassVar

from engine.framegraph.builder import Builder
from engine.framegraph.passes import Pass, PassContext
from engine.gpu.types import ColorAttachment, DepthAttachment
from engine.render.effect_programs import EffectPrograms
from engine.render.facts import SceneFacts
from engine.render.frame import DEPTH_UNIT, PASS_BINDING, OtherRole, RenderFrame
from engine.render.gbuffer import NO_REFLECTION
from engine.render.gi.block import block_of
from engine.render.gi.gather import DEPTHS, LIGHTS, SHAPES
from engine.render.gi.layers import ROLE, layer_request

NOTHING = (float(NO_REFLECTION), 0.0, 0.0, 0.0)


class DeepGbufferPass(Pass):
    """Two draws: layer 1 is peeled against the depth of layer 0 of this very frame, exactly.

    One draw into two layers (Mara et al. 2016, sect. 3: each triangle goes to both) would save what the second one
    costs besides its pixels, triangles and commands: 1 % of the pass where there are few (a box, 15 ms at 640 x 427 on
    two cores of llvmpipe), 3 % for 2,000 blocks (35 ms), 5 % in the atrium (51 ms). It would have to know layer 0
    beforehand: the depth of the frame before, moved to now, is wrong where things were hidden, and a still picture,
    which must depend on nothing but the scene, has none."""

    name: ClassVar[str] = "deep_gbuffer"
    reach: ClassVar[int | None] = 0

    def __init__(self) -> None:
        super().__init__()
        self._programs = [EffectPrograms(ROLE, partial(layer_request, layer=layer)) for layer in range(len(DEPTHS))]

    def needs(self, facts: SceneFacts) -> bool | str:
        return True if facts.indirect.wanted else facts.indirect.why_not

    def declare(self, b: Builder) -> None:
        scale = 1.0 / b.facts.indirect.stride
        for layer in range(b.facts.indirect.layers):
            b.create(DEPTHS[layer], "d32f", scale=scale)
            b.create(SHAPES[layer], "rg32ui", scale=scale)
            b.create(LIGHTS[layer], "rg32ui", scale=scale)

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        effects = frame.residency.effects
        batches = [batch for batch in frame.draws.opaque if ROLE in effects.get(batch.state.effect).techniques]
        uniforms = {PASS_BINDING: block_of(frame)}
        for layer in range(frame.facts.indirect.layers):
            colors = [ColorAttachment(ctx.texture(name[layer]), clear=NOTHING) for name in (SHAPES, LIGHTS)]
            depth = DepthAttachment(ctx.texture(DEPTHS[layer]), clear=0.0)
            inputs = {DEPTH_UNIT: (ctx.texture(DEPTHS[0]), frame.point_sampler)} if layer else {}
            with ctx.device.render_pass(f"layer {layer}", colors, depth) as render_pass:
                program = partial(self._programs[layer].get, frame)
                role = OtherRole(ROLE, program, uniforms, (ROLE, layer))
                frame.draw_batches(render_pass, batches, 1, inputs, other=role)
