"""What of the settings changes the maps' shape or the shaders: part of the facts."""

from __future__ import annotations

from dataclasses import dataclass, replace

from engine.gpu.types import SamplerDesc
from engine.render.shadows.moments import COUNTS, format_of

#: the index is SHADOW_FILTER in shaders/lib/shadows.glsl
FILTERS = (
    "none", "pcf", "vogel8", "vogel16", "pcss", "poisson8", "poisson16", "poisson24",
    "esm", "vsm", "evsm2", "evsm4", "msm",
)  # fmt: skip
#: those that look into blurred moments of depth
MOMENTS = frozenset(COUNTS)
#: those of the thesis, whose depths the hardware compares
HARDWARE = frozenset({"poisson8", "poisson16", "poisson24"})
PRECISIONS = ("single", "half")

#: what a view may ask for
FILTER_CHOICES = ("auto", *FILTERS)
#: lookups of moments: between texels, and between mips
LINEAR = SamplerDesc("clamp", "clamp", "clamp", "linear_mip_linear", "linear")


def filter_for(choice: str) -> str:
    """The filter of FILTERS that `choice` means. A sun of half a degree throws sharp shadows: four texels that are each
    compared with the receiver's plane are nearer to rays, by rmse and by FLIP, than any wider filter at several times
    the price (`lucarna report shadows`)."""
    return choice if choice != "auto" else "pcf"


@dataclass(frozen=True, slots=True)
class ShadowQuality:
    """`size` texels square, `cascades` layers, `filter` of FILTERS. `precision` of PRECISIONS: of moments, which only
    their filters have."""

    filter: str = "pcf"
    cascades: int = 3
    size: int = 1024
    precision: str = "single"

    def used(self) -> ShadowQuality:
        """The same without what this filter does not have."""
        return self if self.moments else replace(self, precision="single")

    @property
    def moments(self) -> bool:
        return self.filter in MOMENTS

    @property
    def format(self) -> str:
        """Of the moments."""
        return format_of(self.filter, self.precision)


#: what a view has unless it says otherwise
DEFAULT = ShadowQuality()
