"""Classic deferred lighting: the back faces of each light's volume, drawn where they lie behind the surface; the shader
tests the range from the G-buffer's depth and adds the light's share.

One draw for all lights, in their order, so that the sums have the bits of every other path. No stencil marks volumes.
It would keep surfaces before a volume from the shader: on the atrium with 1,024 lights 42 % of what the depth test lets
through (478 pixels a light at 160x90 against 279), among thin poles 72 % (208 against 57); `lucarna report lights`
counts them. But it takes two draws and a state change a light, 2,048 draws a frame here, as volumes that
overlap cannot share a stencil; and such a pixel costs this shader one depth fetch and one compare before it
is let go. A software rasteriser, where nothing is let go early, has the tiled path, which is faster from about a
hundred lights on.

The three-pass form (an option) gathers light apart from surfaces: it reads the first word pair of the G-buffer only and
blends half floats. Its specular light has one colour a pixel and no Fresnel term, so its picture is an approximation.
"""

from __future__ import annotations

from typing import Any, ClassVar

from engine.framegraph.builder import Builder
from engine.framegraph.passes import Pass, PassContext
from engine.gpu.types import BlendState, ColorAttachment, DepthAttachment, DepthState, RasterState
from engine.render.facts import SceneFacts
from engine.render.frame import DEPTH_UNIT, GBUFFER_UNIT, LIGHT_BOUNDS_BINDING, RenderFrame
from engine.render.gbuffer import texture_names
from engine.render.passes.local_shadows import local_shadow_inputs, read_local_shadows
from engine.render.passes.opaque import GATHERED, LIGHT_SUM

#: triangles of a volume: rings x segments quads (shaders/passes/light_volumes.vert)
RINGS, SEGMENTS = 4, 8
ADD = BlendState("one", "one", "add", "one", "one", "add")
BEHIND = DepthState(test=True, write=False, compare="lequal")
#: depth is clamped, so that no volume ends at a camera's far plane
BACK_FACES = RasterState("front", depth_clamp=True)


class LightVolumesPass(Pass):
    name: ClassVar[str] = "light_volumes"
    reach: ClassVar[int | None] = 0

    def needs(self, facts: SceneFacts) -> bool | str:
        return True if facts.local_lights else "no local lights"

    def declare(self, b: Builder) -> None:
        lighting = b.facts.lighting
        for name in (*(texture_names(lighting.gbuffer)[: 1 if lighting.three_pass else None]), "depth"):
            b.read(name)
        read_local_shadows(b)
        b.write(GATHERED if lighting.three_pass else LIGHT_SUM)

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        count, lighting = frame.light_count, frame.facts.lighting
        if not count:
            return
        pipeline = frame.programs.screen(
            "light_volumes.frag", vertex="passes/light_volumes.vert", lights=True, depth=BEHIND, blend=ADD,
            raster=BACK_FACES,
            defines={
                "GBUFFER_LAYOUT": lighting.gbuffer, "THREE_PASS": int(lighting.three_pass), "LOCAL_LIGHTS": 1,
                "RINGS": RINGS, "SEGMENTS": SEGMENTS,
                **frame.facts.light_defines(),
            },
        )  # fmt: skip
        target = ColorAttachment(ctx.texture(GATHERED if lighting.three_pass else LIGHT_SUM))
        depth = DepthAttachment(ctx.texture("depth"), read_only=True)
        with ctx.device.render_pass(self.name, [target], depth) as render_pass:
            render_pass.set_pipeline(pipeline)
            render_pass.set_bindings(
                frame.light_bindings(
                    {**gbuffer_inputs(ctx), **local_shadow_inputs(ctx)},
                    storage={LIGHT_BOUNDS_BINDING: frame.light_lists.bounds},
                )
            )
            render_pass.draw(6 * RINGS * SEGMENTS, count)


def gbuffer_inputs(ctx: PassContext) -> dict[int, Any]:
    """The G-buffer and depth by texture unit."""
    frame: RenderFrame = ctx.frame
    names = [name for name in texture_names(frame.facts.lighting.gbuffer) if ctx.has(name)]
    textures = {GBUFFER_UNIT + i: (ctx.texture(name), frame.point_sampler) for i, name in enumerate(names)}
    return {**textures, DEPTH_UNIT: (ctx.texture("depth"), frame.point_sampler)}
