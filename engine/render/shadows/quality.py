"""What of the settings changes the maps' shape or the shaders: part of the facts."""

from __future__ import annotations

from dataclasses import dataclass

#: the index is SHADOW_FILTER in shaders/lib/shadows.glsl
FILTERS = ("none", "pcf", "vogel8", "vogel16", "pcss")


#: what a view may ask for: `auto` is what the device can afford
FILTER_CHOICES = ("auto", *FILTERS)


def filter_for(choice: str, *, software: bool) -> str:
    """The filter of FILTERS that `choice` means: a software rasteriser pays about as much for each lookup as for all
    the rest of a pixel, so there one hardware-style lookup is what `auto` gives."""
    if choice != "auto":
        return choice
    return "pcf" if software else "vogel8"


@dataclass(frozen=True, slots=True)
class ShadowQuality:
    """`size` texels square, `cascades` layers, `filter` of FILTERS."""

    filter: str = "vogel8"
    cascades: int = 3
    size: int = 1024


#: what a view has unless it says otherwise
DEFAULT = ShadowQuality()
