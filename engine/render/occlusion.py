"""Which ambient occlusion a view has: its method, how many places it looks at, and how far."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from engine.render.motion.jitter import radical_inverse

if TYPE_CHECKING:
    from engine.render.settings import RenderSettings

METHODS = ("alchemy", "hbao", "gtao")
#: views that show it
SHOWN_IN = frozenset({"lit", "lighting", "light_tiles", "occlusion", "ambient_occlusion"})
METHOD_CHOICES = ("off", *METHODS)

#: frames that one is the mean of: while something moves (each fetch between texels softens), and while nothing does
MOVING, RESTING = 8, 64

#: part of a scene's size that is taken for the radius where none is set: a scene in other units looks the same
RADIUS_PART = 0.03


@dataclass(frozen=True, slots=True)
class Occlusion:
    """`directions`: slices through a pixel; `steps`: places on each side of one (alchemy: in all); `stride`: 2 where
    every second row and column is looked at. `bent`: also where the open part lies; `bounces`: what hides light sends
    on what it receives. `temporal`: mixed with the frames before; `mips`: far places are looked up in smaller depths.
    `why_not`: why it is not wanted."""

    method: str = "gtao"
    directions: int = 2
    steps: int = 8
    stride: int = 1
    bent: bool = False
    bounces: bool = False
    temporal: bool = False
    mips: bool = False
    wanted: bool = False
    why_not: str = "ambient occlusion is off"

    @property
    def shading(self) -> int:
        """What surfaces do with it, as their shaders know it: 0 nothing, 1 it dims; and 2 bent, 4 bounces."""
        return int(self.wanted) * (1 + 2 * self.bent + 4 * self.bounces)


def occlusion_of(settings: RenderSettings, *, lit: bool, solid: bool, live: bool = False) -> Occlusion:
    """What the view asks for; `lit`: there is light from the environment, `solid`: something stands in it, `live`: its
    pictures follow one another."""
    method = str(settings.ambient_occlusion)
    stride = 2 if settings.ao_half else 1
    view = settings.shading_view
    shown = view == "ambient_occlusion"
    why = (
        "ambient occlusion is off" if method == "off"
        else "its strength is 0" if settings.ao_strength <= 0.0
        else "no environment light that could be hidden" if not lit and not shown
        else f"the view {view} shows no environment light" if view not in SHOWN_IN
        else "nothing solid" if not solid
        else ""
    )  # fmt: skip
    if why:
        return Occlusion(stride=1, why_not=why)
    # what gathers light from surfaces knows these bounces itself, and the view of the visibility is of that alone
    bounces = bool(settings.ao_bounces) and settings.gi == "off" and not shown
    bent = bool(settings.ao_bent) and method == "gtao" and not shown
    return Occlusion(
        method, int(settings.ao_directions), int(settings.ao_steps), stride, bent, bounces,
        live and bool(settings.ao_temporal), bool(settings.ao_mips), True, "",
    )  # fmt: skip


def turns_of(frame: int) -> tuple[float, float]:
    """By how much of a turn, and of the way between two places, frame `frame` of a run looks elsewhere: 16 in a row
    have every place of the pattern of 4 x 4 pixels once, the next 16 what lies between."""
    return radical_inverse(frame, 2), radical_inverse(frame, 3)


def radius_of(settings: RenderSettings, low: NDArray[np.float64], high: NDArray[np.float64]) -> float:
    """Metres: as set, or by the size of the scene between `low` and `high` (f8[3])."""
    if settings.ao_radius > 0.0:
        return float(settings.ao_radius)
    size = float(np.linalg.norm(high - low))
    return RADIUS_PART * size if np.isfinite(size) and size > 0.0 else 1.0
