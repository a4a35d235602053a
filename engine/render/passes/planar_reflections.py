"""What flat mirrors show: the scene from behind each plane, before surfaces are shaded; they look it up where they are.

    shadows ─► planar_reflections ─► planar (light), planar_reach (how far away it is): with mips, for rough mirrors
Where nothing stands before a mirror its picture is empty: surfaces put the environment there (shaders/lib/planar.glsl).
"""

from __future__ import annotations

from functools import partial
from typing import Any, ClassVar

from engine.framegraph.builder import Builder
from engine.framegraph.passes import WHOLE_PICTURE, Pass, PassContext
from engine.gpu.types import ColorAttachment, DepthAttachment, SamplerDesc, Texture
from engine.render.facts import SceneFacts
from engine.render.frame import (
    INPUT_UNIT,
    PASS_BINDING,
    PLANAR_REACH_UNIT,
    PLANAR_UNIT,
    SCENE_COLOR_UNIT,
    OtherRole,
    RenderFrame,
    SeenBy,
)
from engine.render.passes.local_shadows import local_shadow_inputs, read_local_shadows
from engine.render.passes.shadow_cascades import SUN_MOMENTS, SUN_SHADOW, SUN_TINT, shadow_inputs
from engine.render.planar.mirrors import Mirror
from engine.render.planar.programs import ROLE, MirrorPrograms

#: arrays of a layer per mirror. rgba16f: light, premultiplied by how much of the texel shows a body; r32f: depth
PLANAR, PLANAR_REACH = "planar", "planar_reach"
#: of the mirror that is drawn
DEPTH = "planar_depth"
#: what transmissive bodies in a mirror see behind them
BEHIND = "planar_behind"
_SMOOTH = SamplerDesc("clamp", "clamp", "clamp")
NOTHING = (0.0, 0.0, 0.0, 0.0)


class PlanarReflectionsPass(Pass):
    name: ClassVar[str] = "planar_reflections"
    reach: ClassVar[int | None] = WHOLE_PICTURE

    def __init__(self) -> None:
        super().__init__()
        self._programs = MirrorPrograms()

    def needs(self, facts: SceneFacts) -> bool | str:
        return True if facts.planar.wanted else "no flat surface asks for a planar reflection, or the view wants none"

    def declare(self, b: Builder) -> None:
        for name in (SUN_SHADOW, SUN_MOMENTS, SUN_TINT):
            b.read(name, optional=True)
        read_local_shadows(b)
        planar = b.facts.planar
        size, layers = planar.size(*b.view_size), max(planar.mirrors, 1)
        b.create(PLANAR, "rgba16f", size=size, kind="2d-array", layers=layers, mips=0)
        b.create(PLANAR_REACH, "r32f", size=size, kind="2d-array", layers=layers, mips=0)
        b.create(DEPTH, "d32f", size=size)
        if b.facts.transmission:
            b.create(BEHIND, "rgba16f", size=size, mips=0)

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        color, reach, shown = ctx.texture(PLANAR), ctx.texture(PLANAR_REACH), frame.mirrors.shown
        for layer, mirror in enumerate(shown):
            self._draw(ctx, layer, mirror)
            self._look(ctx, "planar_reach.frag", {}, {INPUT_UNIT: ctx.texture(DEPTH)}, ColorAttachment(reach, 0, layer))
        for layer in range(len(shown), color.desc.layers):
            empty = [ColorAttachment(texture, layer=layer, clear=NOTHING) for texture in (color, reach)]
            ctx.device.render_pass("no mirror", empty).end()
        ctx.device.generate_mips(color)
        ctx.device.generate_mips(reach)

    def _draw(self, ctx: PassContext, layer: int, mirror: Mirror) -> None:
        frame: RenderFrame = ctx.frame
        color, depth = ctx.texture(PLANAR), ctx.texture(DEPTH)
        seen = SeenBy(
            frame.pass_block(f"mirror {layer} view", mirror.view_row), frame.mirrors.ids, frame.mirrors.commands
        )
        clip = frame.pass_block(f"mirror {layer} clip", mirror.clip_row)
        role = OtherRole(ROLE, partial(self._programs.get, frame), {PASS_BINDING: clip}, (self.name, layer))
        inputs = {**shadow_inputs(ctx), **local_shadow_inputs(ctx)}
        target = ColorAttachment(color, layer=layer, clear=NOTHING)
        with ctx.device.render_pass(f"mirror {layer}", [target], DepthAttachment(depth, 0.0)) as render_pass:
            frame.draw_batches(render_pass, mirror.opaque, 1, inputs, other=role, seen=seen)
        if not mirror.blended:
            return
        if ctx.has(BEHIND):
            inputs[SCENE_COLOR_UNIT] = self._behind(ctx, layer)
        target = ColorAttachment(color, layer=layer)
        with ctx.device.render_pass(f"mirror {layer}", [target], DepthAttachment(depth)) as render_pass:
            frame.draw_batches(render_pass, mirror.blended, 1, inputs, other=role, seen=seen)

    def _behind(self, ctx: PassContext, layer: int) -> tuple[Any, Any]:
        """A copy of what is solid in a mirror, with mips."""
        behind = ctx.texture(BEHIND)
        inputs = {INPUT_UNIT: ctx.texture(PLANAR)}
        self._look(ctx, "planar_behind.frag", {"LAYER": layer}, inputs, ColorAttachment(behind))
        ctx.device.generate_mips(behind)
        return behind, ctx.device.sampler(_SMOOTH)

    def _look(
        self, ctx: PassContext, shader: str, defines: dict[str, int], inputs: dict[int, Texture],
        target: ColorAttachment,
    ) -> None:  # fmt: skip
        """Run a shader over the texels of a target."""
        frame: RenderFrame = ctx.frame
        textures = {unit: (texture, frame.point_sampler) for unit, texture in inputs.items()}
        with ctx.device.render_pass(shader.removesuffix(".frag"), [target]) as render_pass:
            render_pass.set_pipeline(frame.programs.screen(shader, defines=defines))
            render_pass.set_bindings(frame.view_bindings(textures))
            render_pass.draw(3)


def planar_inputs(ctx: PassContext) -> dict[int, Any]:
    """The mirrors' pictures for surface shaders, by texture unit; nothing where the frame has none."""
    if not ctx.has(PLANAR):
        return {}
    smooth = ctx.device.sampler(_SMOOTH)
    return {PLANAR_UNIT: (ctx.texture(PLANAR), smooth), PLANAR_REACH_UNIT: (ctx.texture(PLANAR_REACH), smooth)}
