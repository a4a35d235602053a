"""SceneFacts: what this scene has, in this view. Hashable: the frame graph and the shader variants are chosen by it."""

from __future__ import annotations

from dataclasses import dataclass, field

from engine.render.bloom import Bloom
from engine.render.gi.choice import Indirect
from engine.render.lighting import Lighting
from engine.render.occlusion import Occlusion
from engine.render.planar.choice import Planar
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
    translucent_shadows: bool = False  # the above, and something blended tints the sun's light, and the view wants it
    shadow_quality: ShadowQuality = field(default_factory=ShadowQuality)
    alpha_to_coverage: bool = False  # cut-outs in the scene, several samples a pixel, and the view wants it
    lighting: Lighting = field(default_factory=Lighting)  # the default where there are no local lights
    area_lights: bool = False  # a rectangle or disk shines
    light_profiles: bool = False  # a light with an IES profile shines
    transmission: bool = False  # a surface shows what is behind it, refracted
    refraction: str = "straight"  # how: REFRACTIONS of engine/render/settings.py
    quality: str = "auto"  # level of techniques: low, medium, high, or the highest that the device can do
    stencil: bool = False  # a technique of what is drawn tests or writes it
    ambient_occlusion: Occlusion = field(default_factory=Occlusion)
    indirect: Indirect = field(default_factory=Indirect)  # light between surfaces, reflections
    planar: Planar = field(default_factory=Planar)  # flat surfaces that mirror the scene itself
    local_shadows: int = 0  # width of the map of local lights' shadows, texels; 0 where none casts
    soft_lamps: bool = False  # one of them has a size that softens its shadows
    translucent_lamps: bool = False  # something blended tints the light of one of them, and the view wants it
    bloom: Bloom = field(default_factory=Bloom)
    auto_exposure: bool = False
    fxaa: bool = False
    smaa: bool = False
    depth_of_field: bool = False
    taa: bool = False
    motion: bool = False  # something is gathered over frames, and wants to know where it was (engine/render/motion)
    shadow_floor: bool = False  # a floor that only shadows are seen of, and something that throws them or hides light
    depth_asked: bool = False  # depth before anything is shaded, whether something is made from it or not
    moving: bool = False  # a thing that is seen moved since the frame before, and the above

    @property
    def depth_first(self) -> bool:
        """Whether depth is drawn before anything is shaded."""
        from_it = self.ambient_occlusion.wanted or self.indirect.wanted
        return self.lighting.path == "forward-plus" or from_it or self.depth_asked or self.force_all

    @property
    def depth_format(self) -> str:
        return "d32f-s8" if self.stencil else "d32f"

    def variant_defines(self) -> dict[str, int]:
        """The macros of the surface shaders: absent light costs nothing. With `force_all` every branch is in."""
        from engine.render.settings import DEBUG_VIEWS, REFRACTIONS

        return {
            "ENVIRONMENT": int(self.environment or self.indirect.wanted or self.planar.wanted or self.force_all),
            "SUNS": int(self.suns or self.force_all),
            "SUN_SHADOWS": int(self.sun_shadows or self.force_all),
            "TRANSLUCENT_SHADOWS": int(self.translucent_shadows or self.force_all),
            "CASCADE_TINT": int(self.sun_shadows),  # a forced, empty map is no cascade to show
            "AMBIENT_OCCLUSION": self.ambient_occlusion.shading or int(self.force_all),
            "INDIRECT": int(self.indirect.wanted or self.force_all),
            "GATHERED": int(self.indirect.gather or self.force_all),
            "REFLECTIONS": int(self.indirect.reflections or self.force_all),
            "REFRACTION": REFRACTIONS.index(self.refraction),
            "PLANAR_MIRRORS": int(self.planar.wanted or self.force_all),
            "LOCAL_LIGHTS": int(self.local_lights or self.force_all),
            "DEBUG_VIEW": DEBUG_VIEWS.index(self.debug_view),
            "VIEW_SHADOW_TEXELS": int(self.debug_view == "shadow_texels"),
            **self.light_defines(),
        }

    def light_defines(self) -> dict[str, int]:
        """The macros of shaders/lib/lights.glsl, for every shader that shades local lights."""
        return {
            "AREA_LIGHTS": int(self.area_lights or self.force_all),
            "LIGHT_PROFILES": int(self.light_profiles or self.force_all),
            "LOCAL_SHADOWS": int(self.local_shadows > 0 or self.force_all),
            "SOFT_LAMPS": int(self.soft_lamps or self.force_all),
            "TRANSLUCENT_LAMPS": int(self.translucent_lamps or self.force_all),
            "SHADOW_FILTER": FILTERS.index(self.shadow_quality.filter),
            "SHADOW_HALF": int(self.shadow_quality.moments and self.shadow_quality.precision == "half"),
        }
