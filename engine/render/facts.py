"""SceneFacts: what this scene has, in this view. Hashable: the frame graph and the shader variants are chosen by it."""

from __future__ import annotations

from dataclasses import dataclass, field

from engine.render.lighting import Lighting
from engine.render.shadows.quality import FILTERS, ShadowQuality


@dataclass(frozen=True, slots=True)
class SceneFacts:
    """Counts are reduced to what changes the frame, so that a moving camera does not recompile anything."""

    opaque: bool
    transparent: bool
    suns: bool
    local_lights: bool
    environment: bool
    background: bool
    tone_map: str
    samples: int
    debug_view: str
    hdr_output: bool = False
    force_all: bool = False
    sun_shadows: bool = False  # a sun, something that casts, something that is lit, and the view wants it
    shadow_quality: ShadowQuality = field(default_factory=ShadowQuality)
    alpha_to_coverage: bool = False  # cut-outs in the scene, several samples a pixel, and the view wants it
    lighting: Lighting = field(default_factory=Lighting)  # the default where there are no local lights
    area_lights: bool = False  # a rectangle or disk shines
    light_profiles: bool = False  # a light with an IES profile shines

    def variant_defines(self) -> dict[str, int]:
        """The macros of the surface shaders: absent light costs nothing. With `force_all` every branch is in."""
        from engine.render.settings import DEBUG_VIEWS

        return {
            "ENVIRONMENT": int(self.environment or self.force_all),
            "SUNS": int(self.suns or self.force_all),
            "SUN_SHADOWS": int(self.sun_shadows or self.force_all),
            "CASCADE_TINT": int(self.sun_shadows),  # a forced, empty map is no cascade to show
            "SHADOW_FILTER": FILTERS.index(self.shadow_quality.filter),
            "LOCAL_LIGHTS": int(self.local_lights or self.force_all),
            "DEBUG_VIEW": DEBUG_VIEWS.index(self.debug_view),
            **self.light_defines(),
        }

    def light_defines(self) -> dict[str, int]:
        """The macros of shaders/lib/lights.glsl, for every shader that shades local lights."""
        return {
            "AREA_LIGHTS": int(self.area_lights or self.force_all),
            "LIGHT_PROFILES": int(self.light_profiles or self.force_all),
        }
