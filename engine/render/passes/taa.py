"""Temporal anti-aliasing: each frame looks elsewhere in its pixels, and a picture is the mean of the last ones.

What was seen before is found by its motion, held to the colours around the pixel, and dropped where something hid it.
While nothing changes it is the plain mean of all frames since, so that it converges to the supersampled picture."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from engine.framegraph.builder import Builder
from engine.framegraph.passes import Pass, PassContext
from engine.gpu.glsl_layout import Field, layout
from engine.gpu.types import Bindings
from engine.render.facts import SceneFacts
from engine.render.frame import DEPTH_UNIT, INPUT_UNIT, PASS_BINDING, VIEW_BINDING, RenderFrame
from engine.render.one_sample import reason
from engine.render.passes.motion import MOTION
from engine.render.passes.tone_map import exposure_scale

#: rgba16f, rounded by chance, so that sums of many frames do not stop short of their limit; and of what was seen depth,
#: variance over frames and motion, to know what was hidden and what is thinner than a pixel
MEAN, SEEN = "taa_mean", "taa_seen"
HISTORY_UNIT, SEEN_UNIT, MOTION_UNIT = 28, 29, 30

BLOCK = layout(
    [
        Field("before_from_now", "mat4"),
        Field("jitter", "vec2"),
        Field("known", "float"),  # 1: there is a mean of frames before
        Field("frozen", "float"),  # 1: nothing changed since, and nothing is held to anything
        Field("part", "float"),  # of this frame in the mean
        Field("exposure", "float"),  # bright samples count less, by what the display makes of them
        Field("spread", "float"),  # standard deviations that colours of before may lie off
        Field("sharpness", "float"),
        Field("thin", "float"),  # of the variance over frames, added to that of the colours around
        Field("turn", "float"),  # of what is rounded by chance, from frame to frame
    ],
    rule="std140",
)
#: a turn that repeats least (golden ratio)
GOLDEN = 0.6180339887
#: what counts as frames gathered before when things come to rest
RESTING = 3


class TaaPass(Pass):
    name: ClassVar[str] = "taa"
    reach: ClassVar[int | None] = 3

    def needs(self, facts: SceneFacts) -> bool | str:
        return True if facts.taa else reason(facts.samples, "antialias is not taa, or the view shows values")

    def declare(self, b: Builder) -> None:
        b.read("hdr")
        b.read("depth")
        b.read(MOTION)
        b.create(MEAN, "rgba16f")
        b.create(SEEN, "rgba16f")
        b.history(MEAN)
        b.history(SEEN)
        b.write("hdr")

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        if not frame.facts.taa:  # forced to be here
            return
        settings, motion, row = frame.view.settings, frame.motion, np.zeros((), BLOCK.dtype)
        known = motion.known and not ctx.history_reset(MEAN)
        row["before_from_now"], row["jitter"] = motion.before_from_now.T, motion.jitter
        row["known"], row["frozen"] = known, known and motion.frozen > 0
        row["part"] = part_of(motion.frames, motion.frozen, float(settings.taa_part)) if known else 1.0
        metered = frame.exposure.stops if frame.facts.auto_exposure and known else 0.0
        row["exposure"] = exposure_scale(frame.look["exposure"] + metered)
        row["spread"], row["sharpness"] = settings.taa_spread, settings.taa_sharpness
        row["thin"], row["turn"] = settings.taa_thin, GOLDEN * motion.frames % 1.0
        block, point = frame.pass_block(self.name, row), frame.point_sampler
        mean = ctx.texture(MEAN)
        for shader, inputs, images in (
            (
                "taa.comp",
                {
                    INPUT_UNIT: ctx.texture("hdr"), DEPTH_UNIT: ctx.texture("depth"), HISTORY_UNIT: ctx.history(MEAN),
                    SEEN_UNIT: ctx.history(SEEN), MOTION_UNIT: ctx.texture(MOTION),
                },
                {1: (mean, 0, "write"), 2: (ctx.texture(SEEN), 0, "write")},
            ),
            ("taa_sharpen.comp", {INPUT_UNIT: mean}, {1: (ctx.texture("hdr"), 0, "write")}),
        ):  # fmt: skip
            pipeline = frame.programs.compute(shader, block=BLOCK, block_name="taa", defines={"SAMPLES": 1})
            with ctx.device.compute_pass(shader.removesuffix(".comp")) as compute_pass:
                compute_pass.set_pipeline(pipeline)
                compute_pass.set_bindings(
                    Bindings(
                        {VIEW_BINDING: frame.view_buffer, PASS_BINDING: block},
                        {},
                        {unit: (texture, point) for unit, texture in inputs.items()},
                        images,
                    )
                )
                compute_pass.dispatch(-(-ctx.size[0] // 8), -(-ctx.size[1] // 8))


def part_of(frames: int, frozen: int, part: float) -> float:
    """The weight of a frame: `part`, more in the first frames of a run, less the longer nothing changed."""
    if frozen == 0:
        return max(part, 1.0 / (frames + 1))
    return 1.0 / (min(frozen, frames) + 1 + (RESTING if frames > frozen else 0))
