"""What blended surfaces leave of local lights, a tile per view from one: the option of translucent shadows."""

from __future__ import annotations

from functools import partial
from typing import ClassVar

from engine.framegraph.builder import Builder
from engine.framegraph.passes import WHOLE_PICTURE, Pass, PassContext
from engine.gpu.types import ColorAttachment, DepthAttachment
from engine.render.effect_programs import EffectPrograms
from engine.render.facts import SceneFacts
from engine.render.frame import OtherRole, RenderFrame
from engine.render.kept import KeptParts
from engine.render.passes.local_shadows import LOCAL_SHADOW, LOCAL_TINT, Square, stale_tiles
from engine.render.passes.shadow_tints import FORMAT, NOTHING
from engine.render.shadows.tint_request import ROLE, tint_request


class LocalTintsPass(Pass):
    """As ShadowTintsPass, in the tiles of the local lights' map. What is kept of depth is how many times nearer it is
    than the farthest caster: halves keep that to 1/2048 whatever the scene's size."""

    name: ClassVar[str] = "local_tints"
    reach: ClassVar[int | None] = WHOLE_PICTURE

    def __init__(self) -> None:
        super().__init__()
        self._drawn: KeptParts[Square] = KeptParts()
        self._programs = EffectPrograms(ROLE, partial(tint_request, lamps=True))

    def needs(self, facts: SceneFacts) -> bool | str:
        if facts.translucent_lamps:
            return True
        return "translucent shadows are off, no local light casts, or nothing that is blended tints its light"

    def declare(self, b: Builder) -> None:
        width = b.facts.local_shadows if b.facts.translucent_lamps else 1  # a forced frame: it leaves all
        b.read(LOCAL_SHADOW)
        b.create(LOCAL_TINT, FORMAT, size=(width, width))
        b.keep(LOCAL_TINT)

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        tints, depths = ctx.texture(LOCAL_TINT), ctx.texture(LOCAL_SHADOW)
        drawn = self._drawn.of(tints)
        if not drawn:
            drawn[(0, 0, 0)] = "empty"
            ctx.device.render_pass("local tints cleared", [ColorAttachment(tints, clear=NOTHING)]).end()
        if not frame.facts.translucent_lamps:
            return
        role = OtherRole(ROLE, partial(self._programs.get, frame), {}, (ROLE, "lamps"))
        depth = DepthAttachment(depths, read_only=True)
        for i, tile in stale_tiles(drawn, frame, (id(depths),)):
            row = frame.shadow_rows.copy()
            row["clip_from_origin"] = tile.unit_from_origin(frame.origin).T
            block = frame.pass_block(f"local tint {i}", row)
            with ctx.device.render_pass(f"local tint {i}", [ColorAttachment(tints)], depth) as render_pass:
                render_pass.set_viewport(tile.x, tile.y, tile.width, tile.width)
                render_pass.set_pipeline(frame.programs.screen("tint_clear.frag"))
                render_pass.set_bindings(frame.view_bindings())
                render_pass.draw(3)
                frame.draw_casters(render_pass, frame.draws.lamp_tint_batches[i], block, lamps=True, other=role)
