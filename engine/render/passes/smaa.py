"""Subpixel morphological anti-aliasing of the finished picture: edges, how much of a pixel lies beyond its edge, blend.

Jimenez, Echevarria, Sousa, Gutierrez 2012, "SMAA: Enhanced Subpixel Morphological Antialiasing", in its form for one
sample, with diagonals and corners. Their tables of areas and searches make do with little arithmetic; here areas are
computed where they are needed and lines followed pixel by pixel: exact at any length, and no table has to fit."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from engine.framegraph.builder import Builder
from engine.framegraph.passes import Pass, PassContext
from engine.gpu.glsl_layout import Field, layout
from engine.gpu.types import ColorAttachment, Texture
from engine.render.facts import SceneFacts
from engine.render.frame import INPUT_UNIT, PASS_BINDING, RenderFrame
from engine.render.one_sample import reason

#: pixels that a line is followed to each side
STEPS = 32
#: rg8: an edge to the left, above; rgba8: of the edge above, parts of the pixel above and of this one, then of the left
EDGES, PARTS, SHOWN = "smaa_edges", "smaa_parts", "smaa_picture"
MORE_UNIT = INPUT_UNIT + 1

BLOCK = layout([Field("wanted", "float")], rule="std140")


class SmaaPass(Pass):
    name: ClassVar[str] = "smaa"
    reach: ClassVar[int | None] = STEPS + 3

    def needs(self, facts: SceneFacts) -> bool | str:
        return True if facts.smaa else reason(facts.samples, "antialias is not smaa, or the view shows values")

    def declare(self, b: Builder) -> None:
        b.read("color")
        b.create(EDGES, "rg8")
        b.create(PARTS, "rgba8")
        b.create(SHOWN, "rgba8")
        b.write("color")

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        row = np.zeros((), BLOCK.dtype)
        row["wanted"] = frame.facts.smaa
        block = frame.pass_block(self.name, row)
        color, edges, parts, shown = (ctx.texture(name) for name in ("color", EDGES, PARTS, SHOWN))
        stages: tuple[tuple[str, Texture, dict[int, Texture]], ...] = (
            ("copy_picture.frag", shown, {INPUT_UNIT: color}),
            ("smaa_edges.frag", edges, {INPUT_UNIT: shown}),
            ("smaa_parts.frag", parts, {INPUT_UNIT: edges}),
            ("smaa_blend.frag", color, {INPUT_UNIT: shown, MORE_UNIT: parts}),
        )
        defines = {"STEPS": STEPS, "PATTERNS": int(frame.view.settings.smaa_patterns == "all")}
        for shader, target, inputs in stages:
            if shader == "copy_picture.frag":
                pipeline = frame.programs.screen(shader)
            else:
                pipeline = frame.programs.screen(shader, block=BLOCK, block_name="smaa", defines=defines)
            with ctx.device.render_pass(shader.removesuffix(".frag"), [ColorAttachment(target)]) as render_pass:
                render_pass.set_pipeline(pipeline)
                sampled = {unit: (texture, frame.point_sampler) for unit, texture in inputs.items()}
                render_pass.set_bindings(frame.view_bindings(sampled, {PASS_BINDING: block}))
                render_pass.draw(3)
