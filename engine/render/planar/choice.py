"""Whether a view has planar reflections. Part of the facts: hashable."""

from __future__ import annotations

import math
from dataclasses import dataclass

from engine.render.settings import LIT_LOOK, RenderSettings

#: local lights from which on lists of them are made for each mirror
LISTS_FROM = 16


@dataclass(frozen=True, slots=True)
class Planar:
    """`mirrors`: planes that may mirror, as many as the scene has and the view wants; of `scale` times its size.
    `lists`: there are so many lights that lists of them are worth it."""

    mirrors: int = 0
    scale: float = 1.0
    lists: bool = False

    @property
    def wanted(self) -> bool:
        return self.mirrors > 0

    def size(self, width: int, height: int) -> tuple[int, int]:
        """Of a mirror's picture, in pixels."""
        return max(1, math.ceil(width * self.scale)), max(1, math.ceil(height * self.scale))


def planar_of(settings: RenderSettings, planes: int, lights: int) -> Planar:
    """`planes`: flat parts that ask for it, in all of the scene; `lights`: local ones."""
    if settings.shading_view not in LIT_LOOK:
        return Planar()
    count = min(int(settings.planar_mirrors), planes)
    return Planar(count, float(settings.planar_scale), lights >= LISTS_FROM) if count else Planar()
