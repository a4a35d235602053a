"""SceneRows: what the device holds of a scene from frame to frame, brought up to date for a view."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from engine.gpu.types import Device
from engine.math.frustum import planes_from_matrix
from engine.render.draw_list import DrawList
from engine.render.light_rows import LightRows
from engine.render.light_tables import LightTables
from engine.render.morphs import MorphRows
from engine.render.palettes import PaletteRows, SkinningCheck
from engine.render.planar.mirrors import Mirrors
from engine.render.shadows.floor import ShadowFloor, floor_wanted
from engine.render.shadows.local import LocalShadows
from engine.render.shadows.sun import SunShadows
from engine.render.transforms import TransformRows
from engine.render.view import View
from engine.resources.residency import Residency
from engine.scene.culling import visible_instances
from engine.scene.scene import Scene


class SceneRows:
    """Of one scene at a time; a change of scene object is noticed. `visible` bool[instances]: what the last view's
    frustum held; empty before the first."""

    def __init__(self, device: Device, residency: Residency) -> None:
        self.residency = residency
        self.draws = DrawList(device, residency)
        self.transforms = TransformRows(device)
        self.lights = LightRows(device)
        self.light_tables = LightTables(device)
        self.skinning = SkinningCheck(residency)
        self.palettes = PaletteRows(device)
        self.morphs = MorphRows(device, residency)
        self.shadows = SunShadows()
        self.floor = ShadowFloor(residency)
        self.local_shadows = LocalShadows(device)
        self.mirrors = Mirrors(device, residency)
        self.visible: NDArray[np.bool_] = np.zeros(0, np.bool_)
        self._visibility_key: tuple[object, ...] = ()
        self._seen: tuple[int, int] = (-1, -1)

    def update(self, scene: Scene, view: View, origin: NDArray[np.float64]) -> None:
        """Transforms, palettes and morph weights of now, relative to `origin`."""
        self.transforms.update(scene, origin, self._changed_rows(scene))
        self.skinning.check(scene)
        self.palettes.update(scene, origin)
        self.morphs.update(scene, everything=view.settings.force_all)
        self.mirrors.planes.update(scene)

    def look(self, scene: Scene, view: View, *, shifted: float = 0.0) -> None:
        """What the view sees, as batches. `shifted`: by so many pixels, so that as many more count on each side."""
        margin = 2.0 * math.ceil(shifted)
        rebuilt = self.draws.build(scene, everything=view.settings.force_all)
        key = (id(scene), scene.transform_rev, scene.instances.drawn_rev, view.camera.key(), view.aspect, margin)
        if not rebuilt and key == self._visibility_key:
            return
        self._visibility_key = key
        clip = view.camera.clip_from_world(view.aspect)
        if margin:
            clip = np.diag([view.width / (view.width + margin), view.height / (view.height + margin), 1.0, 1.0]) @ clip
        planes = planes_from_matrix(clip)
        visible = visible_instances(scene, planes)
        pose = view.camera.world_from_camera
        self.draws.update(scene, visible, pose[:3, 3], -pose[:3, 2])
        self.visible = visible

    def sun_shadows(self, scene: Scene, view: View) -> bool:
        """Whether the frame's first sun casts shadows; if so, cascades and casters are up to date."""
        draws, drawn = self.draws, scene.instances.drawn
        wanted = view.settings.shadows and self.lights.sun_count > 0
        casting, look = draws.casting & drawn, self._look_of_casters(view)
        tinted = wanted and self.translucent_shadows(scene, view)
        if tinted:
            casting, look = casting | (draws.tinting & drawn), (*look, "tints")
        floor = self.shadows.floor = self._floor(scene, view)
        receives = floor is not None or bool((draws.receiving & drawn).any())
        shown = wanted and bool(casting.any()) and receives
        direction = self.lights.suns[0, 0, :3].copy() if shown else None
        if self.shadows.update(
            scene, view, direction, self.visible, casting, draws.receiving & drawn, look
        ):  # fmt: skip
            draws.update_casters(self.shadows.casters)
            if tinted:
                draws.update_tints(self.shadows.casters)
        return shown

    def translucent_shadows(self, scene: Scene, view: View) -> bool:
        """Whether the view wants blended casters to tint light, and the scene has any."""
        return bool(view.settings.translucent_shadows) and bool((self.draws.tinting & scene.instances.drawn).any())

    def lamp_shadows(self, scene: Scene, view: View) -> int:
        """The width of the map of local lights' shadows, 0 where none casts; its tiles and casters are up to date."""
        draws, drawn, shadows = self.draws, scene.instances.drawn, self.local_shadows
        casting, look = draws.casting & drawn, self._look_of_casters(view)
        tinted = self.translucent_shadows(scene, view)
        if tinted:
            casting, look = casting | (draws.tinting & drawn), (*look, "tints")
        if shadows.update(
            scene, view, self.lights.world, casting,
            receiving=floor_wanted(view.settings) or bool((draws.receiving & drawn).any()),
            state=look,
        ):  # fmt: skip
            draws.update_lamp_casters(shadows.casters)
            if tinted:
                draws.update_lamp_tints(shadows.casters)
        return shadows.atlas

    def _floor(self, scene: Scene, view: View) -> float | None:
        """World y of the floor that only shadows are seen of, where one is wanted."""
        if not floor_wanted(view.settings):
            return None
        return self.floor.height(scene) + float(view.settings.shadow_floor_offset)

    def release(self) -> None:
        for part in (
            self.draws, self.transforms, self.lights, self.light_tables, self.palettes, self.morphs, self.local_shadows,
            self.mirrors,
        ):  # fmt: skip
            part.release()

    def _changed_rows(self, scene: Scene) -> NDArray[np.intp] | None:
        """Node rows whose world moved since this was last asked; None = all."""
        seen_scene, seen_rev = self._seen
        rev = scene.transform_rev
        self._seen = (id(scene), rev)
        if seen_scene != id(scene):
            return None
        if seen_rev == rev:
            return np.zeros(0, np.intp)
        changed: NDArray[np.intp] = np.flatnonzero(scene.nodes.world_rev > seen_rev)
        return changed

    def _look_of_casters(self, view: View) -> tuple[object, ...]:
        """What else than where they are changes a shadow map."""
        materials = self.residency.materials
        return (self.draws.built_rev, self.residency.effects.revision, materials.values_rev, str(view.settings.quality))
