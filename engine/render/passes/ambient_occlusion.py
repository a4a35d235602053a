"""How much of its surroundings each pixel sees: found from depth, filtered, and given to environment light."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from engine.framegraph.builder import Builder
from engine.framegraph.passes import WHOLE_PICTURE, Pass, PassContext
from engine.gpu.glsl_layout import Field, layout
from engine.gpu.types import Bindings, Texture
from engine.render.facts import SceneFacts
from engine.render.frame import AMBIENT_UNIT, DEPTH_UNIT, INPUT_UNIT, PASS_BINDING, VIEW_BINDING, RenderFrame
from engine.render.occlusion import METHODS

#: r16f: 1 open, 0 closed; rgba16f with bent normals: from the normal to the mean open direction (world), then the same
VISIBILITY, FILTERED = "ambient_visibility_raw", "ambient_visibility"

FORMATS = {False: "r16f", True: "rgba16f"}

BLOCK = layout(
    [
        Field("radius", "float"),  # metres
        Field("per_radius_squared", "float"),  # 1 / radius^2
        Field("strength", "float"),  # 0 none to 1 all
        Field("thickness", "float"),  # metres
        Field("bias", "float"),  # sine above the tangent plane that does not hide anything yet
    ],
    rule="std140",
)
#: half floats of the filtered visibility, and facets between pixels, are no flatter than this
BIAS = 0.02


class AmbientOcclusionPass(Pass):
    """Before surfaces are shaded, and only for light from the environment: lamps have shadows of their own."""

    name: ClassVar[str] = "ambient_occlusion"
    reach: ClassVar[int | None] = WHOLE_PICTURE

    def needs(self, facts: SceneFacts) -> bool | str:
        return True if facts.ambient_occlusion.wanted else facts.ambient_occlusion.why_not

    def declare(self, b: Builder) -> None:
        b.read("depth")
        stride = b.facts.ambient_occlusion.stride
        form = FORMATS[b.facts.ambient_occlusion.bent]
        b.create(VISIBILITY, form, scale=1.0 / stride)
        b.create(FILTERED, form)

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        quality, row = frame.facts.ambient_occlusion, np.zeros((), BLOCK.dtype)
        row["radius"] = frame.look["ambient_radius"]
        row["per_radius_squared"] = 1.0 / float(row["radius"]) ** 2
        row["strength"] = frame.look["ambient_strength"] if quality.wanted else 0.0
        row["thickness"] = frame.look["ambient_thickness"]
        row["bias"] = BIAS
        block = frame.pass_block(self.name, row)
        defines = {
            "METHOD": METHODS.index(quality.method), "DIRECTIONS": quality.directions, "STEPS": quality.steps,
            "STRIDE": quality.stride, "SAMPLES": frame.facts.samples,
            "BENT": int(quality.bent), "FORMAT": FORMATS[quality.bent],
        }  # fmt: skip
        depth = {DEPTH_UNIT: (ctx.texture("depth"), frame.point_sampler)}
        raw, filtered = ctx.texture(VISIBILITY), ctx.texture(FILTERED)
        self._dispatch(ctx, "ambient_occlusion.comp", defines, depth, raw, block)
        inputs = {**depth, INPUT_UNIT: (raw, frame.point_sampler)}
        self._dispatch(ctx, "ambient_occlusion_filter.comp", defines, inputs, filtered, block)

    def _dispatch(
        self, ctx: PassContext, shader: str, defines: dict[str, int], inputs: dict[int, Any], out: Texture, block: Any
    ) -> None:
        frame: RenderFrame = ctx.frame
        pipeline = frame.programs.compute(shader, block=BLOCK, block_name="ao", defines=defines)
        with ctx.device.compute_pass(shader.removesuffix(".comp")) as compute_pass:
            compute_pass.set_pipeline(pipeline)
            compute_pass.set_bindings(
                Bindings({VIEW_BINDING: frame.view_buffer, PASS_BINDING: block}, {}, inputs, {1: (out, 0, "write")})
            )
            compute_pass.dispatch(-(-out.desc.width // 8), -(-out.desc.height // 8))


def ambient_inputs(ctx: PassContext) -> dict[int, Any]:
    """The visibility for surface shaders, by texture unit; nothing where the frame has none."""
    if not ctx.has(FILTERED):
        return {}
    frame: RenderFrame = ctx.frame
    return {AMBIENT_UNIT: (ctx.texture(FILTERED), frame.point_sampler)}
