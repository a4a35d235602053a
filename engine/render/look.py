"""FrameLook: what a frame shows of a scene besides its surfaces and lights, as plain numbers for the passes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.assets.scene import EnvironmentAsset
from engine.render.bloom import level_weights
from engine.render.facts import SceneFacts
from engine.render.gi.state import IndirectState
from engine.render.legends import Legend, depth_range, legend_of
from engine.render.occlusion import radius_of
from engine.render.settings import LIT_LOOK, ON_BLACK, RenderSettings
from engine.render.view import View
from engine.scene.scene import Scene

BLACK = (0.0, 0.0, 0.0)


class FrameLook:
    """Keeps what takes long to find while the scene stands still."""

    def __init__(self) -> None:
        self._ambient_radius: tuple[object, float] = ((), 1.0)
        self._indirect = IndirectState()

    def of(
        self, scene: Scene, view: View, facts: SceneFacts, environment: EnvironmentAsset, visible: NDArray[np.bool_]
    ) -> dict[str, Any]:
        """The values by name."""
        settings = view.settings
        return {
            "exposure": exposure_of(scene, view),
            "subject": id(scene),
            "background": (*(BLACK if settings.shading_view in ON_BLACK else environment.background_color), 1.0),
            "background_blur": max(environment.background_blur, settings.background_blur),
            "legend": _legend(scene, view, visible),
            **self._ambient(scene, view, facts),
            "indirect": self._indirect.look(scene, view, facts),
            "bloom_weights": level_weights(settings.bloom_radius, view.width, view.height)
            if facts.bloom.wanted
            else (1.0, 0.0),
        }

    def _ambient(self, scene: Scene, view: View, facts: SceneFacts) -> dict[str, float]:
        """How far and how strongly things hide the surroundings."""
        settings = view.settings
        if not facts.ambient_occlusion.wanted or settings.ao_radius > 0.0:
            return _reach(settings, settings.ao_radius or 1.0)
        key = (id(scene), scene.transform_rev, scene.instances.drawn_rev)
        if self._ambient_radius[0] != key:
            self._ambient_radius = (key, radius_of(settings, *scene.bounds()))
        return _reach(settings, self._ambient_radius[1])


def _reach(settings: RenderSettings, radius: float) -> dict[str, float]:
    thickness = radius * settings.ao_thickness
    return {"ambient_radius": radius, "ambient_thickness": thickness, "ambient_strength": settings.ao_strength}


def exposure_of(scene: Scene, view: View) -> float:
    """Stops, besides what is metered."""
    settings = view.settings
    if settings.shading_view not in LIT_LOOK:
        return 0.0
    return float(settings.exposure) + (0.0 if settings.auto_exposure else scene.look.exposure)


def tone_map_of(scene: Scene, view: View) -> str:
    """The curve of a frame; debug views show values as they are."""
    if view.settings.shading_view not in LIT_LOOK:
        return "none"
    chosen = view.settings.tone_map
    return scene.look.tone_map if chosen == "scene" else chosen


def _legend(scene: Scene, view: View, visible: NDArray[np.bool_]) -> Legend | None:
    if view.settings.shading_view != "depth":
        return legend_of(view.settings.shading_view)
    table = scene.instances
    return legend_of("depth", depth_range(view.camera, table.world_center[visible], table.world_radius[visible]))
