"""HDR to display: exposure, tone map (of a quantity: its ramp), sRGB; the samples of a pixel are averaged after the
curve, so that a bright edge stays smooth."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from engine.framegraph.builder import Builder
from engine.framegraph.passes import Pass, PassContext
from engine.gpu.glsl_layout import Field, layout
from engine.gpu.types import ColorAttachment
from engine.render.frame import INPUT_UNIT, PASS_BINDING, RenderFrame
from engine.render.legends import VALUE_VIEWS, Legend
from engine.render.passes.auto_exposure import EXPOSURE, exposure_inputs
from engine.render.passes.bloom import HALO, bloom_inputs, bloom_parts
from engine.render.settings import TONE_MAPS

#: stops: as far as a scene file may go; 2^100 times the brightest radiance still is a float32
MAX_EXPOSURE = 100.0

BLOCK = layout(
    [
        Field(name, "float")
        for name in (
            "exposure_scale",
            "ramp_scale",
            "ramp_offset",
            "ramp_log",
            "bloom_kept",
            "bloom_scattered",
            "adapted",
        )
    ],
    rule="std140",
)


class ToneMapPass(Pass):
    name: ClassVar[str] = "tone_map"
    reach: ClassVar[int | None] = 0

    def declare(self, b: Builder) -> None:
        b.read("hdr")
        b.read(HALO, optional=True)
        b.read(EXPOSURE, optional=True)
        b.create("color", "rgba8")
        b.present("color")

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        row = np.zeros((), BLOCK.dtype)
        row["exposure_scale"] = exposure_scale(frame.look["exposure"])
        legend: Legend | None = frame.look.get("legend")
        values = legend is not None and frame.facts.debug_view in VALUE_VIEWS
        if legend is not None and values:
            row["ramp_scale"], row["ramp_offset"], row["ramp_log"] = legend.mapping
        row["bloom_kept"], row["bloom_scattered"] = bloom_parts(frame)
        row["adapted"] = frame.facts.auto_exposure
        block, scattered, metered = frame.pass_block(self.name, row), bloom_inputs(ctx), exposure_inputs(ctx)
        defines = {"TONE_MAP": TONE_MAPS.index(frame.facts.tone_map), "SAMPLES": frame.facts.samples}
        defines |= {"VALUES": int(values), "BLOOM": int(bool(scattered)), "METERED": int(bool(metered))}
        pipeline = frame.programs.screen("tone_map.frag", block=BLOCK, block_name="tone_map", defines=defines)
        with ctx.device.render_pass(self.name, [ColorAttachment(ctx.texture("color"))]) as render_pass:
            render_pass.set_pipeline(pipeline)
            render_pass.set_bindings(
                frame.view_bindings(
                    {INPUT_UNIT: (ctx.texture("hdr"), frame.point_sampler), **scattered, **metered},
                    {PASS_BINDING: block},
                )
            )
            render_pass.draw(3)


def exposure_scale(stops: float) -> float:
    """2^stops, with stops kept within MAX_EXPOSURE; not a number counts as 0."""
    return float(2.0 ** min(max(stops, -MAX_EXPOSURE), MAX_EXPOSURE)) if stops == stops else 1.0
