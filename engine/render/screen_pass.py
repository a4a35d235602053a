"""ScreenPass: a pass that changes the finished picture by one fragment shader; its parameters become its uniforms."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from engine.framegraph.builder import Builder
from engine.framegraph.passes import Pass, PassContext
from engine.gpu.glsl_layout import BlockLayout, Field, layout
from engine.gpu.types import ColorAttachment
from engine.render.frame import INPUT_UNIT, PASS_BINDING, RenderFrame

GLSL_TYPES = {"bool": "float", "int": "int", "uint": "uint", "color3": "vec3", "color4": "vec4"}


class ScreenPass(Pass):
    """`fragment`: a file in `passes/` of a shader folder. It has the picture as `t_picture` (binding 10, display
    colours) and `p.<parameter>` for each parameter; numbers, vectors and colours only."""

    fragment: ClassVar[str] = ""

    def declare(self, b: Builder) -> None:
        b.read("color")
        b.create(f"{self.name}_before", "rgba8")
        b.write("color")

    @classmethod
    def block(cls) -> BlockLayout:
        fields = [Field(p.name, GLSL_TYPES.get(p.type, p.type)) for p in cls.Params.PARAMS]
        return layout(fields or [Field("unused", "float")], rule="std140")

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        block = self.block()
        row = np.zeros((), block.dtype)
        for name, value in self.params.values().items():
            row[name] = value
        buffer = frame.pass_block(self.name, row)
        before = f"{self.name}_before"
        copy = frame.programs.screen("copy_picture.frag")
        own = frame.programs.screen(self.fragment, block=block, block_name="p")
        for pipeline, source, target in ((copy, "color", before), (own, before, "color")):
            with ctx.device.render_pass(self.name, [ColorAttachment(ctx.texture(target))]) as render_pass:
                render_pass.set_pipeline(pipeline)
                textures = {INPUT_UNIT: (ctx.texture(source), frame.point_sampler)}
                render_pass.set_bindings(frame.view_bindings(textures, {PASS_BINDING: buffer}))
                render_pass.draw(3)
