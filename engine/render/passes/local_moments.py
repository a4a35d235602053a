"""Moments of the distances in the tiles of local lights, blurred: for filters that look them up."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from engine.framegraph.builder import Builder
from engine.framegraph.passes import WHOLE_PICTURE, Pass, PassContext
from engine.render.facts import SceneFacts
from engine.render.frame import RenderFrame
from engine.render.kept import KeptParts
from engine.render.passes.local_shadows import LOCAL_MOMENTS, LOCAL_SHADOW, Square, stale_tiles
from engine.render.passes.shadow_moments import BLOCK, blur
from engine.render.shadows.moments import usable_exponent

#: blurred along x only, of one tile; the widest is half the map
ROWS = "local_moment_rows"


class LocalMomentsPass(Pass):
    """As ShadowMomentsPass, tile by tile: a tile is wider than what is looked up by all that a filter reaches, so that
    neither a cube's edges nor the next tile are seen in it. Without mips, which would mix tiles."""

    name: ClassVar[str] = "local_moments"
    reach: ClassVar[int | None] = WHOLE_PICTURE

    def __init__(self) -> None:
        super().__init__()
        self._made: KeptParts[Square] = KeptParts()

    def needs(self, facts: SceneFacts) -> bool | str:
        if not facts.shadow_quality.moments:
            return "the shadows' filter compares depths"
        return True if facts.local_shadows else "no shadows of local lights"

    def declare(self, b: Builder) -> None:
        quality, width = b.facts.shadow_quality, b.facts.local_shadows or 2
        if not quality.moments:  # a forced frame: nothing would look into them
            return
        b.read(LOCAL_SHADOW)
        b.create(ROWS, quality.format, size=(width // 2, width // 2))
        b.create(LOCAL_MOMENTS, quality.format, size=(width, width))
        b.keep(LOCAL_MOMENTS)

    def execute(self, ctx: PassContext) -> None:
        frame: RenderFrame = ctx.frame
        quality = frame.facts.shadow_quality
        if not (quality.moments and frame.facts.local_shadows):
            return
        out, depths = ctx.texture(LOCAL_MOMENTS), ctx.texture(LOCAL_SHADOW)
        exponent = usable_exponent(float(frame.view.settings.shadow_exponent), quality.precision)
        for i, tile in stale_tiles(self._made.of(out), frame, (exponent, quality.filter, id(depths))):
            row = np.zeros((), BLOCK.dtype)
            row["exponent"], row["size"] = exponent, tile.width
            row["corner"], row["far"] = (tile.x, tile.y), tile.far
            blur(frame, f"{self.name} {i}", row, tile.blur, (depths, ctx.texture(ROWS), out), lamps=True)
