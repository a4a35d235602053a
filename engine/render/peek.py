"""A look into the middle of a frame: one target's texels, read right after the last pass that uses it. What a graph
shares with others, or uses again for another target, is only there until then. The picture is the same with it; a
renderer without one does nothing for it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.framegraph.compiled import CompiledGraph


class Peek:
    """Of `resource`, which must have one sample a pixel. It reads once, and again only after `take`: what nobody looks
    at is not read."""

    def __init__(self, resource: str, level: int = 0, layer: int = 0) -> None:
        self.resource, self.level, self.layer = resource, level, layer
        self._pixels: NDArray[Any] | None = None
        self._taken = True

    def after(self, graph: CompiledGraph, name: str) -> None:
        """The pass `name` has run."""
        plan = graph.plan
        span = plan.spans.get(self.resource)
        if span is None or plan.passes[span.last].name != name:
            return
        if not self._taken:
            self._pixels = None  # not of this frame any more
            return
        texture = graph.texture(self.resource)
        self._pixels = np.array(texture.read(level=self.level, layer=self.layer))
        self._taken = False

    def take(self) -> NDArray[Any] | None:
        """The texels of the last frame as Texture.read gives them; None: not read, ask after the next frame."""
        self._taken = True
        return self._pixels
