"""Automatic exposure: the picture's luminance decides how much it is brightened, as an eye gets used to it."""

from __future__ import annotations

import math
from typing import Any, ClassVar

import numpy as np

from engine.framegraph.builder import Builder
from engine.framegraph.passes import WHOLE_PICTURE, Pass, PassContext
from engine.gpu.glsl_layout import Field, layout
from engine.gpu.types import Bindings
from engine.render.exposure import adaptation
from engine.render.facts import SceneFacts
from engine.render.frame import EXPOSURE_UNIT, INPUT_UNIT, PASS_BINDING, VIEW_BINDING, RenderFrame

#: r32f, one texel: what the picture is multiplied by
EXPOSURE = "exposure"
#: what the metered luminance becomes, in stops
GREY = math.log2(0.18)

BLOCK = layout(
    [Field(name, "float") for name in ("low", "high", "grey", "limit", "darker", "brighter", "known")], rule="std140"
)
HISTOGRAM, STATE, RESULT = 2, 3, 4


class AutoExposurePass(Pass):
    name: ClassVar[str] = "auto_exposure"
    reach: ClassVar[int | None] = WHOLE_PICTURE

    def needs(self, facts: SceneFacts) -> bool | str:
        return True if facts.auto_exposure else "auto exposure is off, or the view shows values as they are"

    def declare(self, b: Builder) -> None:
        b.read("hdr")
        b.create(EXPOSURE, "r32f", size=(1, 1))

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        settings, row = frame.view.settings, np.zeros((), BLOCK.dtype)
        row["low"], row["high"] = settings.auto_low, settings.auto_high
        row["grey"], row["limit"] = GREY, settings.auto_limit
        row["darker"], row["brighter"] = adaptation(settings, frame.view.seconds)
        row["known"] = frame.exposure.begin(frame.look.get("subject"), cut=frame.view.cut)
        histogram, state, result = frame.exposure.buffers
        block = frame.pass_block(self.name, row)
        width, height = ctx.size
        with ctx.device.compute_pass(self.name) as compute_pass:
            for shader, defines, groups in (
                ("exposure_histogram.comp", {"SAMPLES": frame.facts.samples}, (-(-width // 64), -(-height // 64))),
                ("exposure_adapt.comp", {}, (1, 1)),
            ):
                pipeline = frame.programs.compute(shader, block=BLOCK, block_name="exposure", defines=defines)
                compute_pass.set_pipeline(pipeline)
                compute_pass.set_bindings(
                    Bindings(
                        {VIEW_BINDING: frame.view_buffer, PASS_BINDING: block},
                        {HISTOGRAM: histogram, STATE: state, RESULT: result},
                        {INPUT_UNIT: (ctx.texture("hdr"), frame.point_sampler)},
                        {1: (ctx.texture(EXPOSURE), 0, "write")},
                    )
                )
                compute_pass.dispatch(*groups)


def exposure_inputs(ctx: PassContext) -> dict[int, Any]:
    """The factor for the tone map, by texture unit; nothing where the frame has none."""
    frame: RenderFrame = ctx.frame
    return {EXPOSURE_UNIT: (ctx.texture(EXPOSURE), frame.point_sampler)} if ctx.has(EXPOSURE) else {}
