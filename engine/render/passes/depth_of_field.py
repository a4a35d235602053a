"""Depth of field: what is out of focus is spread over discs, gathered at half size, and laid over what is sharp.

What is before the plane of focus is kept apart from what is behind it. After Jimenez 2014, "Next Generation Post
Processing in Call of Duty: Advanced Warfare" (two layers, tiles of the widest disc before the plane) and Abadie 2018,
"A Life of a Bokeh" (a disc's light goes evenly over its area). Before TAA, whose mean has edges of no one depth."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np

from engine.framegraph.builder import Builder
from engine.framegraph.passes import WHOLE_PICTURE, Pass, PassContext
from engine.gpu.glsl_layout import Field, layout
from engine.gpu.types import Bindings
from engine.render.facts import SceneFacts
from engine.render.focus import WIDEST, lens_width, pixels_per_slope
from engine.render.frame import DEPTH_UNIT, INPUT_UNIT, PASS_BINDING, VIEW_BINDING, RenderFrame
from engine.render.one_sample import reason

#: rgba16f at half size: light and the disc's radius; the widest disc around; behind (a: there is some), before (a: how
#: much it covers). SHARP: the picture as it was.
HALF, TILES, BEHIND, BEFORE, SHARP = "dof_half", "dof_tiles", "dof_behind", "dof_before", "dof_sharp"

BLOCK = layout(
    [
        Field("scale", "float"),  # pixels of radius per difference of device depth
        Field("focus", "float"),  # device depth that is sharp; below 0: that of the middle of the picture
        Field("widest", "float"),  # pixels of radius
        Field("tile", "uint"),  # texels of half size
    ],
    rule="std140",
)


class DepthOfFieldPass(Pass):
    name: ClassVar[str] = "depth_of_field"
    reach: ClassVar[int | None] = WHOLE_PICTURE

    def needs(self, facts: SceneFacts) -> bool | str:
        if facts.depth_of_field:
            return True
        return reason(facts.samples, "it is off, or the view shows values or has no perspective")

    def declare(self, b: Builder) -> None:
        b.read("hdr")
        b.read("depth")
        width, height = (-(-extent // 2) for extent in b.view_size)
        tile = tile_of(b.view_size[1])
        b.create(HALF, "rgba16f", size=(width, height))
        b.create(TILES, "r16f", size=(-(-width // tile), -(-height // tile)))
        b.create(BEHIND, "rgba16f", size=(width, height))
        b.create(BEFORE, "rgba16f", size=(width, height))
        b.create(SHARP, "rgba16f")
        b.write("hdr")

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        if not frame.facts.depth_of_field:  # forced to be here
            return
        camera, settings, row = frame.view.camera, frame.view.settings, np.zeros((), BLOCK.dtype)
        # device depth is near / distance
        row["scale"] = 0.5 * lens_width(camera, settings) * pixels_per_slope(camera, ctx.size[1]) / camera.znear
        row["focus"] = camera.znear / settings.focus if settings.focus > 0.0 else -1.0
        row["widest"], row["tile"] = max(0.5 * WIDEST * ctx.size[1], 1.0), tile_of(ctx.size[1])
        block, point = frame.pass_block(self.name, row), frame.point_sampler
        hdr, depth, half, tiles, behind, before, sharp = (
            ctx.texture(name) for name in ("hdr", "depth", HALF, TILES, BEHIND, BEFORE, SHARP)
        )
        stages = (
            ("dof_half.comp", {INPUT_UNIT: hdr, DEPTH_UNIT: depth}, (half, sharp), half),
            ("dof_tiles.comp", {INPUT_UNIT: half}, (tiles,), tiles),
            ("dof_gather.comp", {INPUT_UNIT: half, INPUT_UNIT + 1: tiles}, (behind, before), half),
            (
                "dof_mix.comp",
                {INPUT_UNIT: sharp, DEPTH_UNIT: depth, INPUT_UNIT + 1: half, INPUT_UNIT + 2: behind,
                 INPUT_UNIT + 3: before}, (hdr,), hdr,
            ),
        )  # fmt: skip
        for shader, inputs, outputs, size in stages:
            defines = {"SAMPLES": 1, "TAPS": int(settings.focus_taps)}
            pipeline = frame.programs.compute(shader, block=BLOCK, block_name="dof", defines=defines)
            with ctx.device.compute_pass(shader.removesuffix(".comp")) as compute_pass:
                compute_pass.set_pipeline(pipeline)
                uniforms = {VIEW_BINDING: frame.view_buffer, PASS_BINDING: block}
                sampled = {unit: (texture, point) for unit, texture in inputs.items()}
                images = {1 + i: (texture, 0, "write") for i, texture in enumerate(outputs)}
                compute_pass.set_bindings(Bindings(uniforms, {}, sampled, images))
                compute_pass.dispatch(-(-size.desc.width // 8), -(-size.desc.height // 8))


def tile_of(height: int) -> int:
    """Texels of half size: as wide as the widest disc reaches, so that the tiles around are enough."""
    return max(math.ceil(0.25 * WIDEST * height), 1)
