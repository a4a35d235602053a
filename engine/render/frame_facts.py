"""The facts of a frame: what the scene has that this view shows."""

from __future__ import annotations

from engine.assets.scene import EnvironmentAsset
from engine.gpu.types import Caps
from engine.render.bloom import bloom_of
from engine.render.facts import SceneFacts
from engine.render.focus import dof_wanted
from engine.render.gi.choice import indirect_of
from engine.render.look import tone_map_of
from engine.render.occlusion import occlusion_of
from engine.render.planar.choice import planar_of
from engine.render.refraction import refraction_of
from engine.render.scene_rows import SceneRows
from engine.render.settings import LIT_LOOK, ON_BLACK
from engine.render.shadows.floor import floor_wanted
from engine.render.shadows.quality import ShadowQuality, filter_for
from engine.render.temporal import follows, taa_wanted
from engine.render.view import View
from engine.scene.scene import Scene


def facts_of(
    scene: Scene, view: View, rows: SceneRows, caps: Caps, *, environment: EnvironmentAsset, lit: bool,
    sun_shadows: bool, hdr: bool,
) -> SceneFacts:  # fmt: skip
    """Before hysteresis and before a path is chosen. `lit`: the environment gives light; `hdr`: linear output is asked
    for. Brings the shadows of local lights up to date."""
    settings, draws = view.settings, rows.draws
    background = environment.background if settings.background == "scene" else settings.background
    return SceneFacts(
        opaque=draws.has_solid,
        transparent=draws.has_blended,
        transmission=draws.has_transmissive,
        refraction=refraction_of(settings, draws.has_transmissive),
        suns=rows.lights.sun_count > 0,
        local_lights=rows.lights.count > 0,
        environment=lit,
        background=lit and background == "environment" and settings.shading_view not in ON_BLACK,
        tone_map=tone_map_of(scene, view),
        samples=caps.samples_for(settings.samples),
        debug_view=settings.shading_view,
        hdr_output=hdr,
        force_all=settings.force_all,
        quality=str(settings.quality),
        stencil=draws.uses_stencil,
        ambient_occlusion=(
            hidden := occlusion_of(settings, lit=lit, solid=draws.has_solid, live=view.seconds is not None)
        ),
        indirect=(light := indirect_of(settings, solid=draws.has_solid, lit=lit, live=follows(view))),
        planar=planar_of(settings, rows.mirrors.planes.count, rows.lights.count),
        auto_exposure=settings.auto_exposure and settings.shading_view in LIT_LOOK,
        taa=(taa := taa_wanted(view, caps)),
        motion=taa or hidden.temporal or light.smooth,
        depth_of_field=dof_wanted(view, caps),
        bloom=bloom_of(settings, view.width, view.height, shown=settings.shading_view in LIT_LOOK),
        area_lights=rows.light_tables.area,
        light_profiles=rows.light_tables.profiles,
        sun_shadows=sun_shadows,
        translucent_shadows=sun_shadows and rows.translucent_shadows(scene, view),
        local_shadows=(lamp_shadows := rows.lamp_shadows(scene, view)),
        shadow_floor=floor_wanted(settings) and (sun_shadows or lamp_shadows > 0 or hidden.wanted),
        soft_lamps=rows.local_shadows.soft,
        translucent_lamps=lamp_shadows > 0 and rows.translucent_shadows(scene, view),
        # these views are of what would be hidden
        depth_asked=settings.depth_first and draws.has_solid and settings.shading_view not in ("wireframe", "overdraw"),
        shadow_quality=ShadowQuality(
            filter_for(settings.shadow_filter),
            settings.shadow_cascades,
            settings.shadow_size,
            str(settings.shadow_precision),
        ).used(),
    )
