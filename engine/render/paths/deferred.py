"""The deferred paths: a G-buffer first, local lights after it."""

from __future__ import annotations

from engine.framegraph.passes import Pass
from engine.render.passes.ambient_occlusion import AmbientOcclusionPass
from engine.render.passes.bounces import BouncesPass
from engine.render.passes.deep_gbuffer import DeepGbufferPass
from engine.render.passes.depth_prepass import DepthPrepass
from engine.render.passes.indirect import IndirectPass
from engine.render.passes.light_culling import LightCullingPass
from engine.render.passes.light_heat import LightHeatPass
from engine.render.passes.light_resolve import LightResolvePass
from engine.render.passes.light_volumes import LightVolumesPass
from engine.render.passes.motion import LateMotionPass, MotionPass
from engine.render.passes.opaque import OpaqueForwardPass, OpaquePass
from engine.render.passes.planar_reflections import PlanarReflectionsPass
from engine.render.passes.radiosity import RadiosityPass
from engine.render.passes.reflections import ReflectionsPass
from engine.render.passes.scene_color import SceneColorPass
from engine.render.passes.scene_front import SceneFrontPass
from engine.render.passes.shadow_floor import ShadowFloorPass
from engine.render.passes.shadow_maps import ShadowMapsPass
from engine.render.passes.sky import SkyPass
from engine.render.passes.tiled_shading import TiledShadingPass
from engine.render.passes.transparent import TransparentPass
from engine.render.paths.lens import lens_passes
from engine.render.paths.shadow_maps import shadow_passes


def deferred_passes() -> list[Pass]:
    """Each light's volume is drawn over what it reaches."""
    return [
        *shadow_passes(), DepthPrepass(), MotionPass(),
        PlanarReflectionsPass(), AmbientOcclusionPass(),
        DeepGbufferPass(), RadiosityPass(), BouncesPass(), IndirectPass(), ReflectionsPass(),
        OpaquePass(), LightVolumesPass(),
        LightResolvePass(), OpaqueForwardPass(), SkyPass(), ShadowFloorPass(), LightCullingPass(),
        LateMotionPass(), SceneColorPass(), SceneFrontPass(), TransparentPass(),
        LightHeatPass(), ShadowMapsPass(), *lens_passes(),
    ]  # fmt: skip


def tiled_deferred_passes() -> list[Pass]:
    """Lists of lights per tile, then one compute pass over the pixels."""
    return [
        *shadow_passes(), DepthPrepass(), MotionPass(),
        PlanarReflectionsPass(), AmbientOcclusionPass(),
        DeepGbufferPass(), RadiosityPass(), BouncesPass(), IndirectPass(), ReflectionsPass(),
        OpaquePass(), LightCullingPass(),
        TiledShadingPass(), OpaqueForwardPass(), SkyPass(), ShadowFloorPass(),
        LateMotionPass(), SceneColorPass(), SceneFrontPass(), TransparentPass(),
        LightHeatPass(), ShadowMapsPass(), *lens_passes(),
    ]  # fmt: skip
