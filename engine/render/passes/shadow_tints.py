"""What blended surfaces leave of the first sun's light, a layer per cascade: the option of translucent shadows."""

from __future__ import annotations

from functools import partial
from typing import ClassVar

from engine.framegraph.builder import Builder
from engine.framegraph.passes import WHOLE_PICTURE, Pass, PassContext
from engine.gpu.types import ColorAttachment, DepthAttachment, Texture
from engine.render.effect_programs import EffectPrograms
from engine.render.facts import SceneFacts
from engine.render.frame import OtherRole, RenderFrame
from engine.render.kept import KeptParts
from engine.render.passes.shadow_cascades import SUN_SHADOW, SUN_TINT
from engine.render.shadows.tint_request import ROLE, tint_request

#: rgba16f: product of what each surface lets through, depth of the nearest (0: there is none)
FORMAT = "rgba16f"
NOTHING = (1.0, 1.0, 1.0, 0.0)


class ShadowTintsPass(Pass):
    """Surfaces are filters: their colours are multiplied, in whatever order they are drawn. What is behind a solid
    caster fails the test against its depth. Kept from frame to frame, as the maps of depth are.

    Of depths only the nearest is known: between two surfaces light has the tint of both. Halves keep it to 1/2048 of
    the map's depth, so that what is less than that behind a surface has no tint."""

    name: ClassVar[str] = "shadow_tints"
    reach: ClassVar[int | None] = WHOLE_PICTURE

    def __init__(self) -> None:
        super().__init__()
        self._drawn: KeptParts[int] = KeptParts()
        self._programs = EffectPrograms(ROLE, tint_request)

    def needs(self, facts: SceneFacts) -> bool | str:
        if facts.translucent_shadows:
            return True
        return "translucent shadows are off, there is no sun, or nothing that is blended tints its light"

    def declare(self, b: Builder) -> None:
        quality, wanted = b.facts.shadow_quality, b.facts.translucent_shadows
        size = (quality.size, quality.size) if wanted else (1, 1)  # a forced frame: it leaves all
        b.read(SUN_SHADOW)
        b.create(SUN_TINT, FORMAT, size=size, kind="2d-array", layers=quality.cascades)
        b.keep(SUN_TINT)

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        tints, shadows = ctx.texture(SUN_TINT), frame.shadows
        drawn = self._drawn.of(tints)
        if not (frame.facts.translucent_shadows and shadows.cascades):
            for layer in range(frame.facts.shadow_quality.cascades):
                if drawn.get(layer) != "empty":
                    self._clear(ctx, tints, layer)
                    drawn[layer] = "empty"
            return
        depths = ctx.texture(SUN_SHADOW)
        for layer, of_depths in enumerate(shadows.keys):
            key = (of_depths, id(depths))
            if drawn.get(layer) == key:
                continue
            drawn.pop(layer, None)
            row = frame.shadow_rows.copy()
            row["clip_from_origin"] = shadows.clip_from_origin(layer, frame.origin).T
            block = frame.pass_block(f"shadow tint {layer}", row)
            colors = [ColorAttachment(tints, layer=layer, clear=NOTHING)]
            depth = DepthAttachment(depths, layer=layer, read_only=True)
            role = OtherRole(ROLE, partial(self._programs.get, frame), {}, ROLE)
            with ctx.device.render_pass(f"shadow tint {layer}", colors, depth) as render_pass:
                frame.draw_casters(render_pass, frame.draws.tint_batches[layer], block, other=role)
            if not frame.programs.ahead.skipping:  # else it is not whole
                drawn[layer] = key

    def _clear(self, ctx: PassContext, tints: Texture, layer: int) -> None:
        ctx.device.render_pass(f"shadow tint {layer}", [ColorAttachment(tints, layer=layer, clear=NOTHING)]).end()
