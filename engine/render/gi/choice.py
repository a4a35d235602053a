"""Which light between surfaces a view has: bounces, how it is gathered, reflections, and how far it looks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from engine.render.settings import RenderSettings

CHOICES = ("off", "one", "many")
METHODS = ("slices", "spiral")
UNSEEN = ("environment", "seen")
#: views of it alone, and those that it is part of
VIEWS = ("indirect", "indirect_confidence", "layer_color", "layer_depth", "reflections")
SHOWN_IN = frozenset({"lit", "lighting", "light_tiles", *VIEWS})

#: parts of a scene's size that are taken where no length is set: a scene in other units looks the same
RADIUS_PART, SEPARATION_PART, DISTANCE_PART = 0.5, 0.02, 1.0
#: frames at rest after which all bounces are there; and frames that a mean is of from then on
BOUNCED, RESTING = 16, 64
#: smaller sizes of the layers that far places are read from
LEVELS = 5


@dataclass(frozen=True, slots=True)
class Indirect:
    """`bounces`: of one picture; `live`: a further one each frame, from what the frame before had. `directions`: slices
    through a pixel; `steps`: places on each side of one (spiral: in all); `stride`: 2 where layers have half the size.
    `gather`, `reflections`: which of both is wanted. `sky`: the environment
    gives light. `why_not`: why nothing is."""

    method: str = "slices"
    bounces: int = 1
    live: bool = False
    smooth: bool = False
    directions: int = 1
    steps: int = 16
    stride: int = 1
    layers: int = 2
    unseen: str = "environment"
    gather: bool = False
    reflections: bool = False
    reflection_steps: int = 128
    sky: bool = False
    why_not: str = "light between surfaces is off"

    @property
    def wanted(self) -> bool:
        return self.gather or self.reflections

    @property
    def rounds(self) -> int:
        """Bounces of a still picture before the last; what the environment lights is lit once at least."""
        return max(self.bounces - 1, int(self.sky))

    @property
    def rests_after(self) -> int:
        """Frames in which nothing changes until the picture does not either, to speak of."""
        return (BOUNCED if self.live else 0) + (RESTING if self.smooth else 0)

    @property
    def again(self) -> bool:
        """Whether surfaces send out more than lamps and suns give them."""
        return self.gather and (self.live or self.rounds > 0)


def indirect_of(settings: RenderSettings, *, solid: bool, lit: bool = False, live: bool = False) -> Indirect:
    """What the view asks for; `solid`: something stands there; `lit`: the environment gives light; `live`: frames
    follow one another."""
    view = settings.shading_view
    why = (
        "light between surfaces is off" if settings.gi == "off" and not settings.reflections
        else "its strength is 0" if settings.gi_strength <= 0.0
        else f"the view {view} shows no light between surfaces" if view not in SHOWN_IN
        else "nothing solid" if not solid
        else ""
    )  # fmt: skip
    if why:
        return Indirect(why_not=why)
    many = settings.gi == "many"
    half = settings.gi_half and not settings.reflections  # mirrors show every texel
    return Indirect(
        method=str(settings.gi_method), bounces=int(settings.gi_bounces) if many and not live else 1,
        live=live and many, smooth=live and bool(settings.gi_smooth) and settings.gi != "off",
        directions=int(settings.gi_directions), steps=int(settings.gi_steps), stride=2 if half else 1,
        layers=int(settings.gi_layers), unseen=str(settings.gi_unseen), gather=settings.gi != "off",
        reflections=bool(settings.reflections), reflection_steps=int(settings.reflection_steps), sky=lit, why_not="",
    )  # fmt: skip


def size_of(low: NDArray[np.float64], high: NDArray[np.float64]) -> float:
    """Of a scene between `low` and `high` (f8[3]), metres; 1 where it has none."""
    with np.errstate(over="ignore", invalid="ignore"):
        size = float(np.linalg.norm(high - low))
    return size if np.isfinite(size) and size > 0.0 else 1.0


def lengths_of(settings: RenderSettings, size: float) -> dict[str, float]:
    """Metres: as set, or by the scene's size."""
    return {
        "radius": float(settings.gi_radius) or RADIUS_PART * size,
        "separation": float(settings.gi_separation) or SEPARATION_PART * size,
        "distance": float(settings.reflection_distance) or DISTANCE_PART * size,
    }
