"""Depth of the scene as the first sun sees it, a layer per cascade. A layer whose key is the last one is not drawn."""

from __future__ import annotations

from typing import Any, ClassVar

from engine.framegraph.builder import Builder
from engine.framegraph.passes import WHOLE_PICTURE, Pass, PassContext
from engine.gpu.types import DepthAttachment, SamplerDesc
from engine.render.facts import SceneFacts
from engine.render.frame import SHADOW_DEPTH_UNIT, SHADOW_TINT_UNIT, SHADOW_UNIT, RenderFrame
from engine.render.kept import KeptParts
from engine.render.shadows.quality import HARDWARE, LINEAR

#: d32f array: 1 towards the sun, 0 where nothing casts; only the layers of this frame's cascades mean anything
SUN_SHADOW = "sun_shadow"
#: blurred moments of its depths, where the filter asks for them (passes/shadow_moments.py)
SUN_MOMENTS = "sun_shadow_moments"
#: what blended casters leave of the light, where that is wanted (passes/shadow_tints.py)
SUN_TINT = "sun_shadow_tint"


class ShadowCascadesPass(Pass):
    """The map stays from frame to frame (`keep`), so a scene at rest pays for the lookups only.

    A forced frame in which nothing casts has one layer, empty: lit everywhere.
    """

    name: ClassVar[str] = "shadow_cascades"
    reach: ClassVar[int | None] = WHOLE_PICTURE

    def __init__(self) -> None:
        super().__init__()
        self._drawn: KeptParts[int] = KeptParts()

    def needs(self, facts: SceneFacts) -> bool | str:
        return True if facts.sun_shadows else "no sun, nothing that casts or shows a shadow, or shadows are off"

    def declare(self, b: Builder) -> None:
        quality = b.facts.shadow_quality
        size = (quality.size, quality.size)
        b.create(SUN_SHADOW, "d32f", size=size, kind="2d-array", layers=quality.cascades)
        b.keep(SUN_SHADOW)

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        texture = ctx.texture(SUN_SHADOW)
        drawn = self._drawn.of(texture)
        shadows = frame.shadows
        if not shadows.cascades and drawn.get(0) != "empty":
            drawn[0] = "empty"
            ctx.device.render_pass("shadow cascade 0", [], DepthAttachment(texture, clear=0.0, layer=0)).end()
        for layer, key in enumerate(shadows.keys):
            if drawn.get(layer) == key:
                continue
            drawn.pop(layer, None)
            row = frame.shadow_rows.copy()
            row["clip_from_origin"] = shadows.clip_from_origin(layer, frame.origin).T
            block = frame.pass_block(f"shadow cascade {layer}", row)
            target = DepthAttachment(texture, clear=0.0, layer=layer)
            with ctx.device.render_pass(f"shadow cascade {layer}", [], target) as render_pass:
                frame.draw_casters(render_pass, frame.draws.caster_batches[layer], block)
            if not frame.programs.ahead.skipping:  # else it is not whole
                drawn[layer] = key


def shadow_inputs(ctx: PassContext) -> dict[int, Any]:
    """The map for the lookups of surface shaders, by texture unit; nothing where the frame has none."""
    frame: RenderFrame = ctx.frame
    tint = {SHADOW_TINT_UNIT: (ctx.texture(SUN_TINT), frame.point_sampler)} if ctx.has(SUN_TINT) else {}
    if ctx.has(SUN_MOMENTS):
        return {SHADOW_DEPTH_UNIT: (ctx.texture(SUN_MOMENTS), ctx.device.sampler(LINEAR)), **tint}
    if not ctx.has(SUN_SHADOW):
        return tint
    texture, chosen = ctx.texture(SUN_SHADOW), frame.facts.shadow_quality.filter
    if chosen not in HARDWARE:
        return {SHADOW_DEPTH_UNIT: (texture, frame.point_sampler), **tint}
    compare = ctx.device.sampler(SamplerDesc("clamp", "clamp", "clamp", "linear", "linear", compare="gequal"))
    return {SHADOW_UNIT: (texture, compare), **tint}
