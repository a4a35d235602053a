"""RenderSettings: how a view is shown. One declaration makes CLI flags, editor widgets and docs."""

from __future__ import annotations

from engine.core.param import ParamBlock, param
from engine.render.shadows.quality import DEFAULT, FILTER_CHOICES

TONE_MAPS = ("none", "agx", "aces", "neutral")
DEBUG_VIEWS = ("lit", "base_color", "normal", "roughness", "metallic", "occlusion", "emission", "cascades")


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
    view: str = param("lit", choices=DEBUG_VIEWS, doc="debug view of one input of the shading")
    samples: int = param(4, min=1, max=8, doc="anti-aliasing samples a pixel (1, 2, 4, 8; limited by the device)")
    shadows: bool = param(True, doc="the sun (the first one) casts shadows")
    shadow_filter: str = param(
        "auto", choices=FILTER_CHOICES,
        doc="auto: by device; none: texels; pcf: 2x2; vogel: lookups in a disc; pcss: soft away from what casts",
    )  # fmt: skip
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
    anisotropy: float = param(8.0, min=1.0, max=16.0, step=1.0, doc="texture sharpness at a grazing angle; 1 = off")
    force_all: bool = param(False, doc="leave nothing out: every pass and every branch runs")
