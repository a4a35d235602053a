"""Forward+: depth first, light lists per tile, then every surface with the list of its tile."""

from __future__ import annotations

from engine.framegraph.passes import Pass
from engine.render.passes.ambient_occlusion import AmbientOcclusionPass
from engine.render.passes.auto_exposure import AutoExposurePass
from engine.render.passes.bloom import BloomPass
from engine.render.passes.depth_prepass import DepthPrepass
from engine.render.passes.fxaa import FxaaPass
from engine.render.passes.light_culling import LightCullingPass
from engine.render.passes.light_heat import LightHeatPass
from engine.render.passes.local_shadows import LocalShadowsPass
from engine.render.passes.opaque import OpaquePass
from engine.render.passes.resolve import ResolvePass
from engine.render.passes.scene_color import SceneColorPass
from engine.render.passes.shadow_cascades import ShadowCascadesPass
from engine.render.passes.shadow_moments import ShadowMomentsPass
from engine.render.passes.sky import SkyPass
from engine.render.passes.tone_map import ToneMapPass
from engine.render.passes.transparent import TransparentPass


def forward_plus_passes() -> list[Pass]:
    return [
        ShadowCascadesPass(), ShadowMomentsPass(), LocalShadowsPass(), DepthPrepass(), AmbientOcclusionPass(),
        LightCullingPass(), OpaquePass(), SkyPass(), SceneColorPass(), TransparentPass(), LightHeatPass(),
        AutoExposurePass(), BloomPass(), ResolvePass(), ToneMapPass(), FxaaPass(),
    ]  # fmt: skip
