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
    LIGHT_TILES_UNIT,
    PASS_BINDING,
    PLANAR_REACH_UNIT,
    PLANAR_UNIT,
    SCENE_COLOR_UNIT,
    OtherRole,
    RenderFrame,
    SeenBy,
)
from engine.render.passes.light_culling import ListJob, make_lists
from engine.render.passes.local_shadows import local_shadow_inputs, read_local_shadows
from engine.render.passes.shadow_cascades import SUN_MOMENTS, SUN_SHADOW, SUN_TINT, shadow_inputs
from engine.render.planar.mirrors import Mirror
from engine.render.planar.programs import ROLE, MirrorPrograms, lighting_behind

#: arrays of a layer per mirror. rgba16f: light, premultiplied by how much of the texel shows a body; r32f: depth
PLANAR, PLANAR_REACH = "planar", "planar_reach"
#: of the mirror that is drawn; headers of its light lists, where there are many lights
DEPTH, TILES = "planar_depth", "planar_tiles"
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
        lighting = lighting_behind(b.facts)
        if lighting.path == "forward-plus":
            tiles = (-(-size[0] // lighting.tile), -(-size[1] // lighting.tile))
            b.create(TILES, "rg32ui", size=tiles, kind="2d-array", layers=lighting.lists)
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
        color, depth, mirrors = ctx.texture(PLANAR), ctx.texture(DEPTH), frame.mirrors
        view = frame.pass_block(f"mirror {layer} view", mirror.view_row)
        clip = {PASS_BINDING: frame.pass_block(f"mirror {layer} clip", mirror.clip_row)}
        seen = SeenBy(view, mirrors.ids, mirrors.commands, mirrors.lists)
        role = OtherRole(ROLE, partial(self._programs.surface, frame), clip, (self.name, layer))
        inputs = {**shadow_inputs(ctx), **local_shadow_inputs(ctx)}
        far: float | None = 0.0
        if ctx.has(TILES):
            self._lists(ctx, layer, mirror, seen, clip)
            inputs[LIGHT_TILES_UNIT] = (ctx.texture(TILES), frame.point_sampler)
            far = None  # it is drawn
        target = ColorAttachment(color, layer=layer, clear=NOTHING)
        with ctx.device.render_pass(f"mirror {layer}", [target], DepthAttachment(depth, far)) as render_pass:
            frame.draw_batches(render_pass, mirror.opaque, 1, inputs, other=role, seen=seen)
        if not mirror.blended:
            return
        if ctx.has(BEHIND):
            inputs[SCENE_COLOR_UNIT] = self._behind(ctx, layer)
        target = ColorAttachment(color, layer=layer)
        with ctx.device.render_pass(f"mirror {layer}", [target], DepthAttachment(depth)) as render_pass:
            frame.draw_batches(render_pass, mirror.blended, 1, inputs, other=role, seen=seen)

    def _lists(self, ctx: PassContext, layer: int, mirror: Mirror, seen: SeenBy, clip: dict[int, Any]) -> None:
        """Which lights reach what the mirror shows, from its depth."""
        frame: RenderFrame = ctx.frame
        depth, lists = ctx.texture(DEPTH), seen.lists
        lighting = self._programs.facts(frame).lighting
        batches = [batch for batch in mirror.opaque if frame.programs.has_role(batch.state, "depth")]
        role = OtherRole("depth", partial(self._programs.depth, frame), clip, (self.name, layer, "depth"))
        with ctx.device.render_pass(f"mirror {layer} depth", [], DepthAttachment(depth, clear=0.0)) as render_pass:
            frame.draw_batches(render_pass, batches, 1, other=role, seen=seen)
        assert frame.mirrors.light_bounds is not None, "of this frame"
        lists.upload_bounds(frame.mirrors.light_bounds)
        lists.prepare(lighting, depth.desc.width, depth.desc.height, frame.light_count)
        row = mirror.view_row
        row["tiles"], row["clusters"] = lists.view_fields(lighting, frame.view.camera.znear)
        seen.view.write(row.tobytes())
        job = ListJob(lists, lighting, seen.view, row, depth, 1, ctx.texture(TILES), bool(mirror.blended))
        make_lists(ctx, f"mirror {layer} lights", job)

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
