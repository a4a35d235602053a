"""What both layers of the deep G-buffer send out, matt, and smaller sizes of it for places that are far away."""

from __future__ import annotations

from typing import Any, ClassVar

from engine.framegraph.builder import Builder
from engine.framegraph.passes import WHOLE_PICTURE, Pass, PassContext
from engine.render.facts import SceneFacts
from engine.render.frame import DEPTH_UNIT, PASS_BINDING, RenderFrame
from engine.render.gi.block import BLOCK, NAME, block_of, layer_size
from engine.render.gi.gather import (
    DEPTHS,
    LIGHT_UNITS,
    LIGHTS,
    NEAR_FAR,
    SENT,
    SHAPE_UNITS,
    SHAPES,
    SIDES,
    levels_of,
    sent_targets,
    shrink,
)
from engine.render.passes.local_shadows import local_shadow_inputs, read_local_shadows
from engine.render.passes.shadow_cascades import SUN_MOMENTS, SUN_SHADOW, SUN_TINT, shadow_inputs

#: rgba16f: what a layer sends out before anything else lights it; there where it is lit again
OWN = ("layer0_own", "layer1_own")
#: units in radiosity.comp
DEPTH_UNITS = (DEPTH_UNIT, 22)


def size_of_layers(b: Builder) -> tuple[int, int]:
    """As engine.render.gi.block.layer_size, while a graph is compiled."""
    stride = b.facts.indirect.stride
    return max(1, -(-b.view_size[0] // stride)), max(1, -(-b.view_size[1] // stride))


class RadiosityPass(Pass):
    name: ClassVar[str] = "radiosity"
    reach: ClassVar[int | None] = WHOLE_PICTURE

    def needs(self, facts: SceneFacts) -> bool | str:
        return True if facts.indirect.wanted else facts.indirect.why_not

    def declare(self, b: Builder) -> None:
        b.read(SUN_SHADOW, optional=True)
        b.read(SUN_MOMENTS, optional=True)
        b.read(SUN_TINT, optional=True)
        read_local_shadows(b)
        size, levels = size_of_layers(b), levels_of(*size_of_layers(b))
        for layer in range(b.facts.indirect.layers):
            for names in (DEPTHS, SHAPES, LIGHTS):
                b.read(names[layer])
            b.create(SENT[layer], "rgba16f", size=size, mips=levels)
            if self._kept(b.facts):
                b.create(OWN[layer], "rgba16f", size=size)
        b.create(NEAR_FAR, "rg32f", size=size, mips=levels)
        b.create(SIDES, "rgba8", size=size, mips=levels)

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        facts, block = frame.facts, block_of(frame)
        layers, kept = facts.indirect.layers, self._kept(frame.facts)
        width, height = layer_size(frame)
        defines = {
            "LAYERS": layers, "SUNS": int(facts.suns), "SUN_SHADOWS": int(facts.sun_shadows and facts.suns),
            "TRANSLUCENT_SHADOWS": int(facts.translucent_shadows and facts.suns),
            "LOCAL_LIGHTS": int(facts.local_lights), "MULTISAMPLED": 0, "LOOP_STEPS": facts.lighting.steps,
            "KEPT": int(kept), **facts.light_defines(),
        }  # fmt: skip
        inputs: dict[int, Any] = {**shadow_inputs(ctx), **local_shadow_inputs(ctx)}
        images = {i: (texture, 0, "write") for i, texture in sent_targets(ctx, layers).items()}
        for layer in range(layers):
            for unit, name in ((SHAPE_UNITS, SHAPES), (LIGHT_UNITS, LIGHTS), (DEPTH_UNITS, DEPTHS)):
                inputs[unit[layer]] = (ctx.texture(name[layer]), frame.point_sampler)
            if kept:
                images[5 + layer] = (ctx.texture(OWN[layer]), 0, "write")
        pipeline = frame.programs.compute("radiosity.comp", block=BLOCK, block_name=NAME, defines=defines, lights=True)
        with ctx.device.compute_pass(self.name) as compute_pass:
            compute_pass.set_pipeline(pipeline)
            compute_pass.set_bindings(frame.light_bindings(inputs, {PASS_BINDING: block}, images=images))
            compute_pass.dispatch(-(-width // 8), -(-height // 8))
        if not facts.indirect.live:  # else it is not whole yet
            shrink(ctx, layers, block)

    def _kept(self, facts: SceneFacts) -> bool:
        return facts.indirect.again or facts.force_all
