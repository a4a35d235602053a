"""Lighting: by which path local lights reach the surfaces, how their lists are made. Hashable, part of the facts."""

from __future__ import annotations

from dataclasses import dataclass

PATHS = ("forward", "deferred", "tiled-deferred", "forward-plus")
PATH_CHOICES = ("auto", *PATHS)
TILE_SIZES = (8, 16, 32)
#: what a tile is to the test: the planes of its corner, a box about what it shows, or a cone about its pixels
TESTS = ("planes", "aabb", "cone")
#: its depth: from nearest to farthest pixel; 32 bins between them; slices of the whole view, each its own list
DEPTHS = ("range", "bins", "clusters")
#: z-slices of clusters: each as deep as SLICE_GROWTH says, the first ends at FIRST_SLICE near distances
SLICES, SLICE_GROWTH, FIRST_SLICE = 24, 1.35, 8.0


@dataclass(frozen=True, slots=True)
class Lighting:
    """`gbuffer`: layout (engine/render/gbuffer.py); `tile`, `test`, `depth`: how lights are culled; `three_pass`:
    deferred accumulates light apart from shading; `forward_only`: something solid cannot be deferred."""

    path: str = "forward"
    gbuffer: int = 1
    tile: int = 8
    test: str = "aabb"
    depth: str = "bins"
    three_pass: bool = False
    forward_only: bool = False
    steps: int = 1  # lights in one turn of a loop (loop_steps)

    @property
    def deferred(self) -> bool:
        return self.path in ("deferred", "tiled-deferred")

    @property
    def clustered(self) -> bool:
        return self.depth == "clusters"

    @property
    def lists(self) -> int:
        """Light lists per tile: one for what is opaque and one for what is blended, or one per slice."""
        return SLICES if self.clustered else 2


@dataclass(frozen=True, slots=True)
class Choice:
    """By which path a frame was made. `samples`: what the path can do of those asked for; `reason`: why this path."""

    path: str
    samples: int
    reason: str


def loop_steps(lights: int, *, software: bool) -> int:
    """How many lights a turn of a shader's loop has to do. llvmpipe ends all loops of a shader after 65,535 turns in
    all; making a list turns twice per light and twice per 32 lights."""
    if not software:
        return 1
    return next((steps for steps in (1, 4) if lights * 2 / steps + lights / 16 < 60_000), 16)
