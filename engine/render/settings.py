"""RenderSettings: how a view is shown. One declaration makes CLI flags, editor widgets and docs."""

from __future__ import annotations

from engine.core.param import ParamBlock, param
from engine.render.gi import choice as gi_choice
from engine.render.lighting import DEPTHS, PATH_CHOICES, TESTS, TILE_SIZES
from engine.render.occlusion import METHOD_CHOICES
from engine.render.shadows.quality import DEFAULT, FILTER_CHOICES, PRECISIONS

TONE_MAPS = ("none", "agx", "aces", "neutral")
DEBUG_VIEWS = (
    "lit", "base_color", "normal", "roughness", "metallic", "occlusion", "emission", "cascades",
    # lights per tile, as a heat map; what the G-buffer's words hold
    "light_tiles", "gbuffer_normal", "gbuffer_color", "gbuffer_roughness", "gbuffer_f0",
    # shaders/lib/debug_views.glsl
    "lighting", "depth", "overdraw", "wireframe", "texel_density", "uv_checker",
    # shaders/lib/skin_views.glsl
    "weights", "influences",
    "ambient_occlusion",
    *gi_choice.VIEWS,
    # shadows: density of the map that a place reads, and all maps
    "shadow_texels", "shadow_maps",
)  # fmt: skip
#: shown as the lit picture is, exposed and tone-mapped
LIT_LOOK = ("lit", "lighting")
#: on black: what is behind the scene has none of what they show
ON_BLACK = ("depth", "overdraw", "wireframe", "texel_density", "uv_checker", "shadow_texels")
#: what a view shows, for tooltips and the status bar; the others say it by their names
VIEW_LEGENDS = {
    "lighting": "white surfaces under the scene's lights",
    "depth": "metres from the camera's plane, from the nearest to the farthest that is seen",
    "overdraw": "how many fragments were shaded for the pixel",
    "wireframe": "edges of the triangles that face the camera, hidden ones too",
    "texel_density": "texels a metre, in cells of 16 texels; grey without a texture",
    "uv_checker": "red along u, green along v, white at the origin; eight cells a turn; grey without UVs",
    "ambient_occlusion": "how much of its surroundings a place sees: white all",
    "indirect": "light that arrives from other surfaces",
    "indirect_confidence": "how much of its surroundings a place can look up: white all",
    "layer_color": "albedo of the second layer: the nearest surface behind what is seen",
    "layer_depth": "how far the second layer is, bright near; black: there is none",
    "reflections": "what mirrors would see of the picture itself; black where they see the environment",
    "weights": "a colour for each bone, mixed by its weight; grey without a skin",
    "influences": "joints that move a vertex: blue 1, green 2, yellow 3, red 4, violet more; grey without a skin",
    "light_tiles": "lights in each tile's list, by the ramp; white: more than fit, so all",
    "cascades": "the shadow map that a place reads: red, green, blue, yellow from near to far, then again; grey: none",
    "shadow_texels": "texels a metre of the sun's shadow map, in cells of 8 texels; grey where it has none",
    "shadow_maps": "the sun's cascades from near to far, then the map of lamps: white near the light",
}
#: how transmissive bodies show what is behind them
REFRACTIONS = ("straight", "bent", "tested")
#: the lit picture, dimmed, with what is no number marked
NONFINITE = "nonfinite"


class RenderSettings(ParamBlock):
    """The look of one view; what is neutral here costs nothing there."""

    exposure: float = param(0.0, min=-20.0, max=20.0, step=0.1, unit="EV", doc="added to the scene's exposure")
    tone_map: str = param(
        "scene", choices=("scene", *TONE_MAPS), doc="curve to the display; scene = as the scene file says"
    )
    environment_intensity: float = param(1.0, min=0.0, max=100.0, step=0.01, doc="scales the environment light")
    environment_rotation: float = param(
        0.0, min=-360.0, max=360.0, step=1.0, unit="deg", doc="turns the environment about +Y"
    )
    sun_intensity: float = param(1.0, min=0.0, max=100.0, step=0.01, doc="scales the environment's sun")
    background: str = param(
        "scene", choices=("scene", "environment", "color"), doc="what is behind; scene = as the scene file says"
    )
    background_blur: float = param(0.0, min=0.0, max=1.0, step=0.01, doc="blur of the background: a roughness")
    view: str = param("lit", choices=(*DEBUG_VIEWS, NONFINITE), doc="debug view of one input of the shading")
    quality: str = param(
        "auto", choices=("auto", "low", "medium", "high"),
        doc="level of effects' techniques; auto: the highest that the device can do",
    )  # fmt: skip
    samples: int = param(4, min=1, max=8, doc="anti-aliasing samples a pixel (1, 2, 4, 8; limited by the device)")
    antialias: str = param(
        "none", choices=("none", "fxaa", "smaa", "taa"),
        doc="with samples = 1. fxaa, smaa: smooth edges of the finished picture (smaa keeps more of what is no edge);"
        " taa: the mean of frames that look elsewhere in each pixel",
    )  # fmt: skip
    smaa_patterns: str = param(
        "all", choices=("all", "lines"),
        doc="smaa: all: slanted lines near 45 degrees as such, and corners stay sharp; lines: each step by itself",
    )  # fmt: skip
    taa_frames: int = param(16, min=1, max=64, doc="taa: places in a pixel that are looked at, one a frame")
    taa_part: float = param(
        0.2,
        min=0.01,
        max=1.0,
        step=0.01,
        doc="taa: of a new frame in the mean while things move; up to 3 times that, where fast",
    )
    taa_spread: float = param(
        1.0, min=0.0, max=8.0, step=0.05,
        doc="taa: standard deviations of the colours around that older ones may lie off: less flickers, more drags",
    )  # fmt: skip
    taa_thin: float = param(
        1.0, min=0.0, max=8.0, step=0.1,
        doc="taa: how much more is kept of what is missed now and then, as lines thinner than a pixel are; 0 = nothing",
    )  # fmt: skip
    taa_sharpness: float = param(0.0, min=0.0, max=2.0, step=0.05, doc="taa: how much edges are steepened")
    alpha_to_coverage: bool = param(True, doc="smooth edges of cut-outs, where a pixel has several samples")
    path: str = param(
        "auto", choices=PATH_CHOICES,
        doc="how local lights reach surfaces; all give one picture. auto: the cheapest for this scene and device."
        " The deferred ones need samples = 1",
    )  # fmt: skip
    depth_first: bool = param(
        False,
        doc="draw depth before surfaces are shaded, so that none is shaded in vain: worth it where surfaces hide each"
        " other or are dear to shade, and triangles are not as many as pixels. On in any case where lists of lights,"
        " ambient occlusion or gi are made from depth",
    )  # fmt: skip
    light_tile: str = param("8", choices=tuple(map(str, TILE_SIZES)), unit="px", doc="width of a tile of light lists")
    light_test: str = param(
        "aabb", choices=TESTS, doc="light against tile: planes of its frustum, box about its pixels, cone from the eye"
    )
    light_depth: str = param(
        "bins", choices=DEPTHS, doc="a tile's depth: nearest to farthest, 32 bins between, or clusters (slices)"
    )
    light_form: str = param(
        "exact", choices=("exact", "three-pass"),
        doc="deferred only: shade in each volume, or gather light apart from surfaces (fewer bytes, approximate)",
    )  # fmt: skip
    light_stats: bool = param(False, doc="count the lights that each tile and pixel needs, too (slow)")
    shadows: bool = param(True, doc="the sun (the first one) casts shadows")
    shadow_filter: str = param(
        "auto", choices=FILTER_CHOICES,
        doc="auto, pcf: 2x2 texels; none: one; vogel, poisson: lookups in a disc; pcss: soft away from what"
        " casts; esm, vsm, evsm, msm: blurred maps, any softness at one lookup",
    )  # fmt: skip
    shadow_precision: str = param(
        "single", choices=PRECISIONS, doc="numbers of blurred maps; half: half the memory, more light leaks"
    )
    shadow_exponent: float = param(
        42.0, min=1.0, max=42.0, step=1.0, doc="esm, evsm: how sharply depths are told apart; half: 5.54 at most"
    )
    shadow_leak: float = param(
        0.15, min=0.0, max=0.9, step=0.01, doc="blurred maps: light up to this part is none; more: darker penumbrae"
    )
    translucent_shadows: bool = param(
        False, doc="blended surfaces tint the light that casts shadows, by their colour and as much as their alpha says"
    )
    shadow_cascades: int = param(DEFAULT.cascades, min=1, max=8, doc="shadow maps for near to far")
    shadow_size: int = param(DEFAULT.size, min=16, max=8192, unit="px", doc="width of each shadow map")
    shadow_distance: float = param(
        0.0, min=0.0, max=1e6, step=1.0, unit="m", doc="no shadows beyond; 0 = as far as the scene"
    )
    shadow_split: float = param(
        0.9, min=0.0, max=1.0, step=0.01, doc="how the depth is cut: 0 evenly, 1 logarithmically"
    )
    shadow_softness: float = param(
        1.5, min=0.0, max=8.0, step=0.1, unit="px", doc="radius of the filter's disc in shadow map texels"
    )
    sun_angle: float = param(0.53, min=0.0, max=20.0, step=0.01, unit="deg", doc="width of the sun, for pcss")
    local_shadows: str = param(
        "auto", choices=("auto", "all", "off"),
        doc="lamps and area lights cast shadows; auto: those that are said to, all: as many as may",
    )  # fmt: skip
    soft_lamps: bool = param(True, doc="area lights, and lamps with a radius, throw shadows as soft as they are large")
    local_shadow_size: int = param(2048, min=64, max=8192, unit="px", doc="width of the map that their tiles share")
    local_shadow_lights: int = param(32, min=0, max=256, doc="most lights with shadows, by brightness and nearness")
    shadow_floor: float = param(
        0.0, min=0.0, max=1.0, step=0.01,
        doc="a floor at the scene's lowest point of which only shadows are seen, and occlusion: how dark; 0 = no floor",
    )  # fmt: skip
    shadow_floor_offset: float = param(
        0.0, min=-1e6, max=1e6, step=0.01, unit="m", doc="raises that floor over the lowest point, or sinks it"
    )
    ambient_occlusion: str = param(
        "off", choices=METHOD_CHOICES,
        doc="hides environment light in corners; gtao: slices, free-standing things hide less; hbao, alchemy: older",
    )  # fmt: skip
    ao_radius: float = param(0.0, min=0.0, max=1e6, step=0.01, unit="m", doc="how far things hide; 0 = by the scene")
    ao_strength: float = param(1.0, min=0.0, max=1.0, step=0.01, doc="0 none, 1 as much as is hidden")
    ao_thickness: float = param(
        0.4, min=0.0, max=4.0, step=0.01, doc="how thick things are taken to be behind what is seen, in radii"
    )
    ao_directions: int = param(1, min=1, max=16, doc="slices through each pixel (gtao, hbao)")
    ao_steps: int = param(8, min=1, max=64, doc="places on each side of a slice; alchemy: places in all")
    ao_bent: bool = param(True, doc="take environment light from where it is open, not from the normal (gtao)")
    ao_bounces: bool = param(
        False, doc="what hides light sends on what it receives, where it is bright; gi does so better"
    )
    ao_half: bool = param(False, doc="look at every second row and column only")
    ao_temporal: bool = param(
        False, doc="mixes with the frames before, where pictures follow one another: each looks in other directions"
    )
    ao_mips: bool = param(False, doc="look far places up in smaller copies of depth: for a large radius in pixels")
    gi: str = param(
        "off", choices=gi_choice.CHOICES,
        doc="light from surface to surface, as far as the picture and what lies behind it show it. one: light of lamps,"
        " suns and what glows, reflected once; many: again and again",
    )  # fmt: skip
    gi_strength: float = param(1.0, min=0.0, max=1.0, step=0.01, doc="0 none, 1 all that arrives")
    gi_bounces: int = param(4, min=2, max=16, doc="many, in a still picture; in motion each frame adds one")
    gi_radius: float = param(
        0.0, min=0.0, max=1e6, step=0.1, unit="m", doc="how far light is gathered from; 0 = by the scene"
    )
    gi_method: str = param(
        "slices", choices=gi_choice.METHODS,
        doc="slices: the nearer hides the farther; spiral: the mean of what is in front, nothing hides anything",
    )  # fmt: skip
    gi_directions: int = param(1, min=1, max=16, doc="slices through each pixel")
    gi_steps: int = param(16, min=1, max=64, doc="places on each side of a slice; spiral: places in all")
    gi_half: bool = param(True, doc="layers of half the width and height; whole where there are reflections")
    gi_layers: int = param(2, min=1, max=2, doc="1: what is seen; 2: and the nearest surface behind it")
    gi_separation: float = param(
        0.0, min=0.0, max=1e6, step=0.01, unit="m",
        doc="between the layers at least, and how thick a surface is taken to be; 0 = by the scene",
    )  # fmt: skip
    gi_boost: float = param(1.0, min=0.0, max=4.0, step=0.05, doc="many: of what surfaces reflect again, 0.95 at most")
    gi_unseen: str = param(
        "environment", choices=gi_choice.UNSEEN,
        doc="what comes from where the picture shows nothing: the environment's light, or as from what is seen (rooms)",
    )  # fmt: skip
    gi_smooth: bool = param(True, doc="mixes with the frames before, where pictures follow one another")
    reflections: bool = param(False, doc="smooth surfaces mirror what the picture and the layer behind it show")
    reflection_distance: float = param(
        0.0, min=0.0, max=1e6, step=0.1, unit="m", doc="how far they see; 0 = by the scene"
    )
    reflection_steps: int = param(
        128, min=4, max=1024, doc="pieces of the picture that a mirrored ray goes through at most, large where it can"
    )
    refraction: str = param(
        "tested", choices=REFRACTIONS,
        doc="bodies that light passes: tested: bend it, and never show what is in front of them; bent: may do so, and"
        " take less time; straight: bend nothing",
    )  # fmt: skip
    planar_mirrors: int = param(
        2, min=0, max=4,
        doc="planes at most in which flat surfaces of materials with planar_reflection mirror the scene, the largest in"
        " the picture first; each draws the scene once more",
    )  # fmt: skip
    planar_scale: float = param(1.0, min=0.1, max=1.0, step=0.05, doc="width of what they show, in pictures")
    planar_roughness: float = param(
        0.5, min=0.0, max=1.0, step=0.01, doc="rougher ones mirror the environment instead, a little smoother ones both"
    )
    auto_exposure: bool = param(
        False, doc="brighten or darken by what is seen, in the place of the scene's exposure; `exposure` is added"
    )
    auto_low: float = param(0.4, min=0.0, max=1.0, step=0.01, doc="darker pixels than this part of them do not count")
    auto_high: float = param(0.95, min=0.0, max=1.0, step=0.01, doc="and those that are brighter than this part")
    auto_limit: float = param(16.0, min=0.0, max=32.0, step=0.5, unit="EV", doc="at most so much either way")
    adapt_darker: float = param(
        0.3, min=0.0, max=60.0, step=0.05, unit="s", doc="time to get used to brightness (63 %), while it moves"
    )
    adapt_brighter: float = param(1.0, min=0.0, max=60.0, step=0.05, unit="s", doc="time to get used to darkness")
    bloom: float = param(0.0, min=0.0, max=1.0, step=0.01, doc="part of the light that the lens scatters; 0 = none")
    bloom_radius: float = param(
        0.1, min=0.0, max=1.0, step=0.01, doc="width of the widest halo (its standard deviation) in picture heights"
    )
    bloom_calm: bool = param(
        False, doc="bright single pixels count less in the halos: they flicker less, but light is lost"
    )
    depth_of_field: bool = param(False, doc="blur what is not in focus, with samples = 1")
    focus: float = param(
        0.0, min=0.0, max=1e6, step=0.05, unit="m", doc="distance that is sharp; 0 = what is in the middle"
    )
    f_stop: float = param(2.8, min=0.5, max=64.0, step=0.1, doc="focal length over the lens's width: less blurs more")
    sensor: float = param(
        24.0, min=0.1, max=1000.0, step=0.5, unit="mm",
        doc="height of the picture in the camera; with the view's angle it makes the focal length",
    )  # fmt: skip
    focus_taps: int = param(64, min=8, max=256, doc="places that each blurred pixel looks at")
    anisotropy: float = param(8.0, min=1.0, max=16.0, step=1.0, doc="texture sharpness at a grazing angle; 1 = off")
    force_all: bool = param(False, doc="leave nothing out: every pass and every branch runs")
    check_numbers: bool = param(False, doc="count NaN and infinities in what each pass wrote (slow)")

    @property
    def shading_view(self) -> str:
        """The view that surfaces are shaded for: marks lie over the lit picture."""
        return "lit" if self.view == NONFINITE else str(self.view)

    @property
    def wants_numbers(self) -> bool:
        return bool(self.check_numbers) or self.view == NONFINITE

    @property
    def takes_time(self) -> bool:
        """Whether a picture depends on those before, as long as there are some."""
        return bool(self.auto_exposure) or self.antialias == "taa"
