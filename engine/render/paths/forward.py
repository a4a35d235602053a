"""The forward path: every surface is shaded as it is drawn."""

from __future__ import annotations

from engine.framegraph.passes import Pass
from engine.render.passes.ambient_occlusion import AmbientOcclusionPass
from engine.render.passes.bounces import BouncesPass
from engine.render.passes.deep_gbuffer import DeepGbufferPass
from engine.render.passes.depth_prepass import DepthPrepass
from engine.render.passes.indirect import IndirectPass
from engine.render.passes.light_heat import LightHeatPass
from engine.render.passes.motion import LateMotionPass, MotionPass
from engine.render.passes.opaque import OpaquePass
from engine.render.passes.planar_reflections import PlanarReflectionsPass
from engine.render.passes.radiosity import RadiosityPass
from engine.render.passes.reflections import ReflectionsPass
from engine.render.passes.scene_color import SceneColorPass
from engine.render.passes.scene_front import SceneFrontPass
from engine.render.passes.shadow_floor import ShadowFloorPass
from engine.render.passes.shadow_maps import ShadowMapsPass
from engine.render.passes.sky import SkyPass
from engine.render.passes.transparent import TransparentPass
from engine.render.paths.lens import lens_passes
from engine.render.paths.shadow_maps import shadow_passes


def forward_passes() -> list[Pass]:
    return [
        *shadow_passes(), DepthPrepass(), MotionPass(),
        PlanarReflectionsPass(), AmbientOcclusionPass(),
        DeepGbufferPass(), RadiosityPass(), BouncesPass(), IndirectPass(), ReflectionsPass(),
        OpaquePass(), SkyPass(), ShadowFloorPass(), LateMotionPass(), SceneColorPass(), SceneFrontPass(),
        TransparentPass(), LightHeatPass(), ShadowMapsPass(), *lens_passes(),
    ]  # fmt: skip
