"""Depth of the scene as local lights see it, in tiles of one map. What is as it was is not drawn."""

from __future__ import annotations

from collections.abc import Hashable, Iterator
from typing import Any, ClassVar

from engine.framegraph.builder import Builder
from engine.framegraph.passes import WHOLE_PICTURE, Pass, PassContext
from engine.gpu.types import DepthAttachment, DepthState, SamplerDesc
from engine.render.facts import SceneFacts
from engine.render.frame import LOCAL_DEPTH_UNIT, LOCAL_SHADOW_UNIT, LOCAL_TINT_UNIT, RenderFrame
from engine.render.kept import KeptParts
from engine.render.shadows.local import Tile

#: d32f: 1e-6 m / distance from the light, 0 where nothing casts; only the tiles of this frame mean anything
LOCAL_SHADOW = "local_shadow"
#: blurred moments of the distances in it, where the filter asks for them (passes/local_moments.py)
LOCAL_MOMENTS = "local_shadow_moments"
#: what blended casters leave of local lights, where that is wanted (passes/local_tints.py)
LOCAL_TINT = "local_shadow_tint"
#: the map of a forced frame in which no local light casts, which nothing looks into
NO_ATLAS = 16
#: a tile is emptied by a triangle at depth 0, as clearing would empty the whole map
EMPTY = DepthState(test=True, write=True, compare="always")

#: left, top, width in texels
Square = tuple[int, int, int]


class LocalShadowsPass(Pass):
    """The map stays from frame to frame (`keep`), so lights and casters at rest cost the lookups only."""

    name: ClassVar[str] = "local_shadows"
    reach: ClassVar[int | None] = WHOLE_PICTURE

    def __init__(self) -> None:
        super().__init__()
        self._drawn: KeptParts[Square] = KeptParts()

    def needs(self, facts: SceneFacts) -> bool | str:
        if facts.local_shadows:
            return True
        return "no local light that casts, nothing that casts or shows a shadow, or local shadows are off"

    def declare(self, b: Builder) -> None:
        width = b.facts.local_shadows or NO_ATLAS
        b.create(LOCAL_SHADOW, "d32f", size=(width, width))
        b.keep(LOCAL_SHADOW)

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        texture = ctx.texture(LOCAL_SHADOW)
        drawn = self._drawn.of(texture)
        if not drawn:
            drawn[(0, 0, 0)] = "empty"
            ctx.device.render_pass("local shadows cleared", [], DepthAttachment(texture, clear=0.0)).end()
        for i, tile in stale_tiles(drawn, frame):
            row = frame.shadow_rows.copy()
            row["clip_from_origin"] = tile.clip_from_origin(frame.origin).T
            block = frame.pass_block(f"local shadow {i}", row)
            with ctx.device.render_pass(f"local shadow {i}", [], DepthAttachment(texture)) as render_pass:
                render_pass.set_viewport(tile.x, tile.y, tile.width, tile.width)
                render_pass.set_pipeline(frame.programs.screen("shadow_clear.frag", depth=EMPTY))
                render_pass.set_bindings(frame.view_bindings())
                render_pass.draw(3)
                frame.draw_casters(render_pass, frame.draws.lamp_batches[i], block, lamps=True)


def stale_tiles(
    drawn: dict[Square, Hashable], frame: RenderFrame, more: tuple[object, ...] = ()
) -> Iterator[tuple[int, Tile]]:
    """Number and tile of what is not there as it should be, to be drawn; then it is. `more`: what else makes it."""
    for i, tile in enumerate(frame.local_shadows.tiles):
        square, key = (tile.x, tile.y, tile.width), (*tile.key, *more)
        if drawn.get(square) == key:
            continue
        for other in [other for other in drawn if _overlap(other, square)]:
            del drawn[other]
        yield i, tile
        if not frame.programs.ahead.skipping:  # else it is not whole
            drawn[square] = key


def _overlap(a: Square, b: Square) -> bool:
    return all(a[i] < b[i] + b[2] and b[i] < a[i] + a[2] for i in (0, 1))


def read_local_shadows(b: Builder) -> None:
    """What `local_shadow_inputs` binds, for the `declare` of a pass."""
    for name in (LOCAL_SHADOW, LOCAL_MOMENTS, LOCAL_TINT):
        b.read(name, optional=True)


def local_shadow_inputs(ctx: PassContext) -> dict[int, Any]:
    """The map for the lookups of everything that shades local lights, by texture unit; nothing where there is none."""
    if not ctx.has(LOCAL_SHADOW):
        return {}
    frame: RenderFrame = ctx.frame
    facts = frame.facts
    if ctx.has(LOCAL_MOMENTS):
        smooth = ctx.device.sampler(SamplerDesc("clamp", "clamp", "clamp", "linear", "linear"))
        bound: dict[int, Any] = {LOCAL_SHADOW_UNIT: (ctx.texture(LOCAL_MOMENTS), smooth)}
    else:
        filter = "nearest" if facts.shadow_quality.filter == "none" else "linear"
        compare = ctx.device.sampler(SamplerDesc("clamp", "clamp", "clamp", filter, filter, compare="gequal"))
        bound = {LOCAL_SHADOW_UNIT: (ctx.texture(LOCAL_SHADOW), compare)}
    if facts.soft_lamps or facts.force_all:
        bound[LOCAL_DEPTH_UNIT] = (ctx.texture(LOCAL_SHADOW), frame.point_sampler)
    if ctx.has(LOCAL_TINT):
        bound[LOCAL_TINT_UNIT] = (ctx.texture(LOCAL_TINT), frame.point_sampler)
    return bound
