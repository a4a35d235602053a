"""What of the settings changes the maps' shape or the shaders: part of the facts."""

from __future__ import annotations

from dataclasses import dataclass

#: the index is SHADOW_FILTER in shaders/lib/shadows.glsl
FILTERS = ("none", "pcf", "vogel8", "vogel16", "pcss")


@dataclass(frozen=True, slots=True)
class ShadowQuality:
    """`size` texels square, `cascades` layers, `filter` of FILTERS."""

    filter: str = "vogel8"
    cascades: int = 3
    size: int = 1024


#: what a view has unless it says otherwise
DEFAULT = ShadowQuality()
