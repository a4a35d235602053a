"""What flat mirrors show: the scene from behind each plane, before surfaces are shaded; they look it up where they are.

    shadows ─► planar_reflections ─► planar (colour, mips: the blur of rough mirrors), planar_depth (how far they see)
Where nothing stands before a mirror its picture is empty: surfaces put the environment there (shaders/lib/planar.glsl).
"""

from __future__ import annotations

from functools import partial
from typing import Any, ClassVar

from engine.framegraph.builder import Builder
from engine.framegraph.passes import WHOLE_PICTURE, Pass, PassContext
from engine.gpu.types import ColorAttachment, DepthAttachment, SamplerDesc
from engine.render.facts import SceneFacts
from engine.render.frame import (
    INPUT_UNIT,
    PASS_BINDING,
    PLANAR_DEPTH_UNIT,
    PLANAR_UNIT,
    SCENE_COLOR_UNIT,
    OtherRole,
    RenderFrame,
    SeenBy,
)
from engine.render.passes.local_shadows import LOCAL_SHADOW, local_shadow_inputs
from engine.render.passes.shadow_cascades import SUN_MOMENTS, SUN_SHADOW, SUN_TINT, shadow_inputs
from engine.render.planar.mirrors import Mirror
from engine.render.planar.programs import ROLE, MirrorPrograms

#: rgba16f arrays of a layer per mirror: light, premultiplied by how much of the texel shows a body; depth
PLANAR, PLANAR_DEPTH = "planar", "planar_depth"
#: what transmissive bodies in a mirror see behind them
BEHIND = "planar_behind"
_SMOOTH = SamplerDesc("clamp", "clamp", "clamp")
NOTHING = (0.0, 0.0, 0.0, 0.0)


class PlanarReflectionsPass(Pass):
    name: ClassVar[str] = "planar_reflections"
    reach: ClassVar[int | None] = WHOLE_PICTURE

    def __init__(self) -> None:
        super().__init__()
        self._programs = MirrorPrograms({})

    def needs(self, facts: SceneFacts) -> bool | str:
        return True if facts.planar.wanted else "no flat surface asks for a planar reflection, or the view wants none"

    def declare(self, b: Builder) -> None:
        for name in (SUN_SHADOW, SUN_MOMENTS, SUN_TINT, LOCAL_SHADOW):
            b.read(name, optional=True)
        planar = b.facts.planar
        size, layers = planar.size(*b.view_size), max(planar.mirrors, 1)
        b.create(PLANAR, "rgba16f", size=size, kind="2d-array", layers=layers, mips=0)
        b.create(PLANAR_DEPTH, "d32f", size=size, kind="2d-array", layers=layers)
        if b.facts.transmission:
            b.create(BEHIND, "rgba16f", size=size, mips=0)

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        color, depth = ctx.texture(PLANAR), ctx.texture(PLANAR_DEPTH)
        for layer in range(color.desc.layers):
            target = [ColorAttachment(color, layer=layer, clear=NOTHING)]
            if layer >= len(frame.mirrors.shown):
                ctx.device.render_pass("no mirror", target, DepthAttachment(depth, 0.0, layer)).end()
                continue
            self._draw(ctx, layer, frame.mirrors.shown[layer])
        if frame.mirrors.shown:
            ctx.device.generate_mips(color)

    def _draw(self, ctx: PassContext, layer: int, mirror: Mirror) -> None:
        frame: RenderFrame = ctx.frame
        color, depth = ctx.texture(PLANAR), ctx.texture(PLANAR_DEPTH)
        seen = SeenBy(
            frame.pass_block(f"mirror {layer} view", mirror.view_row), frame.mirrors.ids, frame.mirrors.commands
        )
        clip = frame.pass_block(f"mirror {layer} clip", mirror.clip_row)
        role = OtherRole(ROLE, partial(self._programs.get, frame), {PASS_BINDING: clip}, (self.name, layer))
        inputs = {**shadow_inputs(ctx), **local_shadow_inputs(ctx)}
        target = ColorAttachment(color, layer=layer, clear=NOTHING)
        with ctx.device.render_pass(f"mirror {layer}", [target], DepthAttachment(depth, 0.0, layer)) as render_pass:
            frame.draw_batches(render_pass, mirror.opaque, 1, inputs, other=role, seen=seen)
        if not mirror.blended:
            return
        if ctx.has(BEHIND):
            inputs[SCENE_COLOR_UNIT] = self._behind(ctx, layer)
        target = ColorAttachment(color, layer=layer)
        with ctx.device.render_pass(f"mirror {layer}", [target], DepthAttachment(depth, None, layer)) as render_pass:
            frame.draw_batches(render_pass, mirror.blended, 1, inputs, other=role, seen=seen)

    def _behind(self, ctx: PassContext, layer: int) -> tuple[Any, Any]:
        """A copy of what is solid in a mirror, with mips."""
        frame: RenderFrame = ctx.frame
        behind = ctx.texture(BEHIND)
        pipeline = frame.programs.screen("planar_behind.frag", defines={"LAYER": layer})
        with ctx.device.render_pass(BEHIND, [ColorAttachment(behind)]) as render_pass:
            render_pass.set_pipeline(pipeline)
            render_pass.set_bindings(frame.view_bindings({INPUT_UNIT: (ctx.texture(PLANAR), frame.point_sampler)}))
            render_pass.draw(3)
        ctx.device.generate_mips(behind)
        return behind, ctx.device.sampler(_SMOOTH)


def planar_inputs(ctx: PassContext) -> dict[int, Any]:
    """The mirrors' pictures for surface shaders, by texture unit; nothing where the frame has none."""
    if not ctx.has(PLANAR):
        return {}
    frame: RenderFrame = ctx.frame
    return {
        PLANAR_UNIT: (ctx.texture(PLANAR), ctx.device.sampler(_SMOOTH)),
        PLANAR_DEPTH_UNIT: (ctx.texture(PLANAR_DEPTH), frame.point_sampler),
    }
