"""Renderer: scene + view -> picture. Holds what lives between frames: graph, programs, buffers."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.framegraph.graph import FrameGraph
from engine.framegraph.passes import Pass, PassContext
from engine.gpu.types import Device, SamplerDesc
from engine.materials.variant import VariantRequest
from engine.math.frustum import planes_from_matrix
from engine.render.draw_list import DrawList
from engine.render.environments import Environments, usable
from engine.render.facts import SceneFacts
from engine.render.frame import Frame, RenderFrame
from engine.render.light_rows import LightRows
from engine.render.palettes import PaletteRows
from engine.render.pass_timer import PassTimer
from engine.render.paths.forward import forward_passes
from engine.render.programs import Programs
from engine.render.shadows.quality import ShadowQuality, filter_for
from engine.render.shadows.sun import SunShadows
from engine.render.transforms import TransformRows, origin_near
from engine.render.view import View
from engine.render.view_block import VIEW_LAYOUT, fill_view_block
from engine.report.stats import FrameStats
from engine.resources.environment import DfgTable
from engine.resources.material_store import MaterialRecord
from engine.resources.residency import Residency
from engine.scene.culling import visible_instances
from engine.scene.scene import Scene


class Renderer:
    """Renders one scene at a time; a change of scene object is noticed. `profile`: measure each pass (on a software
    rasteriser this waits for it after every pass)."""

    def __init__(self, device: Device, residency: Residency, *, profile: bool = True) -> None:
        self.device = device
        self.residency = residency
        self.profile = profile
        self.programs = Programs(device, residency.effects)
        self.graph = FrameGraph(forward_passes())
        self.environments = Environments(device)
        self.draws = DrawList(device, residency)
        self._dfg = DfgTable(device)
        self._transforms = TransformRows(device)
        self._lights = LightRows(device)
        self._palettes = PaletteRows(device)
        self._view_buffer = device.buffer(VIEW_LAYOUT.size, label="view")
        self._pass_buffers: dict[str, Any] = {}
        self._point_sampler = device.sampler(SamplerDesc("clamp", "clamp", "clamp", "nearest", "nearest"))
        self._timer = PassTimer(device)
        self._seen: tuple[int, int] = (-1, -1)
        #: pictures made so far
        self.frames = 0
        self._visibility_key: tuple[object, ...] = ()
        self._visible: NDArray[np.bool_] = np.zeros(0, np.bool_)
        self._shadows = SunShadows()

    def render(self, scene: Scene, view: View, *, hdr: bool = False) -> Frame:
        """One picture of `scene`; `hdr`: the scene-linear one too. Bad assets show as magenta.

        Raises InputError for a camera that no picture can be taken with, ShaderError when a pass of our own does not
        compile, DeviceError."""
        view.camera.check(view.aspect)
        device = self.device
        device.begin_frame()
        device.counters.reset()
        self._timer.begin(self.profile)
        with self._timer.stage("update"):
            scene.update()
            origin = origin_near(view.camera.position, view.camera.znear)
            self._transforms.update(scene, origin, self._changed_rows(scene))
            self._palettes.update(scene, origin)
        with self._timer.stage("visibility"):
            self._visibility(scene, view)
        frame = self._frame(scene, view, origin, hdr)
        graph = self.graph.compile(
            device, frame.facts, (view.width, view.height), force_all=view.settings.force_all, key=hdr
        )
        graph.execute(lambda item: _context(device, graph, item, frame), self._on_pass)
        stats = self._stats(graph.transient_bytes)
        device.end_frame()
        self.frames += 1
        hdr_texture = graph.texture("hdr_resolved") if hdr else None
        return Frame(graph.texture("color"), hdr_texture, stats, graph, frame.facts)

    def requests(self, records: Mapping[int, MaterialRecord]) -> list[VariantRequest]:
        """The shader variants that the last frame would have asked for if these materials were as in `records`."""
        return self.programs.requests(self.draws.states_of(records), records)

    def variant_uses(self) -> dict[VariantRequest, list[int]]:
        """The shader variants of the last frame's scene, seen or not, and the materials that want each."""
        records = dict(enumerate(self.residency.materials.records))
        return self.programs.uses(self.draws.states_of(records), records)

    def release(self) -> None:
        self.graph.release()
        for part in (
            self.programs,
            self.environments,
            self.draws,
            self._dfg,
            self._transforms,
            self._lights,
            self._palettes,
            self._view_buffer,
        ):
            part.release()
        for buffer in self._pass_buffers.values():
            buffer.release()
        self._pass_buffers.clear()

    # --- parts of a frame ---

    def _changed_rows(self, scene: Scene) -> NDArray[np.intp] | None:
        """Node rows whose world moved since this renderer last looked; None = all."""
        seen_scene, seen_rev = self._seen
        rev = scene.transform_rev
        self._seen = (id(scene), rev)
        if seen_scene != id(scene):
            return None
        if seen_rev == rev:
            return np.zeros(0, np.intp)
        changed: NDArray[np.intp] = np.flatnonzero(scene.nodes.world_rev > seen_rev)
        return changed

    def _visibility(self, scene: Scene, view: View) -> None:
        rebuilt = self.draws.build(scene)
        key = (id(scene), scene.transform_rev, scene.instances.drawn_rev, view.camera.key(), view.aspect)
        if not rebuilt and key == self._visibility_key:
            return
        self._visibility_key = key
        planes = planes_from_matrix(view.camera.clip_from_world(view.aspect))
        visible = visible_instances(scene, planes)
        pose = view.camera.world_from_camera
        self.draws.update(scene, visible, pose[:3, 3], -pose[:3, 2])
        self._visible = visible

    def _sun_shadows(self, scene: Scene, view: View) -> bool:
        """Whether the frame's first sun casts shadows; if so, cascades and casters are up to date."""
        draws, drawn = self.draws, scene.instances.drawn
        wanted = view.settings.shadows and self._lights.sun_count > 0
        shown = wanted and bool((draws.casting & drawn).any()) and bool((draws.receiving & drawn).any())
        direction = self._lights.suns[0, 0, :3].copy() if shown else None
        state = (draws.built_rev, self.residency.effects.revision, self.residency.materials.values_rev)
        if self._shadows.update(
            scene, view, direction, self._visible, draws.casting & drawn, draws.receiving & drawn, state
        ):
            draws.update_casters(self._shadows.casters)
        return shown

    def _frame(self, scene: Scene, view: View, origin: NDArray[np.float64], hdr: bool) -> RenderFrame:
        settings = view.settings
        rotation = math.radians(settings.environment_rotation)
        environment = usable(scene.environment)
        env_map = self.environments.get(environment)
        env_intensity = environment.intensity * settings.environment_intensity
        self._lights.update(scene, environment, origin, settings.sun_intensity, rotation)
        block = fill_view_block(
            view, origin, env_map.irradiance_sh, env_map.mips, env_intensity,
            environment.rotation + rotation, self._lights,
        )  # fmt: skip
        sun_shadows = self._sun_shadows(scene, view)
        self._shadows.fill(block, view, origin, everywhere=settings.force_all)
        self._view_buffer.write(block.tobytes())
        background = environment.background if settings.background == "scene" else settings.background
        lit = environment.kind != "none" and env_intensity > 0.0
        facts = SceneFacts(
            opaque=self.draws.has_solid,
            transparent=self.draws.has_blended,
            suns=self._lights.sun_count > 0,
            local_lights=self._lights.count > 0,
            environment=lit,
            background=lit and background == "environment",
            tone_map=_tone_map(scene, view),
            samples=min(settings.samples, self.device.caps.max_samples),
            debug_view=settings.view,
            hdr_output=hdr,
            force_all=settings.force_all,
            sun_shadows=sun_shadows,
            shadow_quality=ShadowQuality(
                filter_for(settings.shadow_filter, software=self.device.caps.software),
                settings.shadow_cascades,
                settings.shadow_size,
            ),
        )
        return RenderFrame(
            device=self.device, view=view, facts=facts, residency=self.residency, programs=self.programs,
            draws=self.draws, environment=env_map, dfg=self._dfg, view_buffer=self._view_buffer,
            transforms=self._transforms.buffer, lights=self._lights.buffer, palettes=self._palettes.buffer,
            point_sampler=self._point_sampler, origin=origin, shadows=self._shadows, shadow_rows=block,
            look={
                "exposure": scene.look.exposure + settings.exposure if settings.view == "lit" else 0.0,
                "background": (*environment.background_color, 1.0),
                "background_blur": max(environment.background_blur, settings.background_blur),
            },
            pass_buffers=self._pass_buffers,
        )  # fmt: skip

    @contextlib.contextmanager
    def _on_pass(self, name: str) -> Iterator[None]:
        with self._timer.gpu_pass(name):
            yield

    def _stats(self, transient_bytes: int) -> FrameStats:
        counters = self.device.counters
        counters.instances = self.draws.instances_drawn
        counters.triangles = self.draws.triangles_drawn
        stats = self._timer.finish()
        stats.counters = {
            **counters.snapshot(),
            "texture_bytes": self.residency.texture_bytes,
            "geometry_bytes": sum(arena.byte_size for arena in self.residency.arenas),
            "transient_bytes": transient_bytes,
        }
        return stats


def _context(device: Device, graph: Any, item: Pass, frame: RenderFrame) -> PassContext:
    return PassContext(device, graph, item.name, frame.facts, frame)


def _tone_map(scene: Scene, view: View) -> str:
    if view.settings.view != "lit":
        return "none"  # debug views show values as they are
    chosen = view.settings.tone_map
    return scene.look.tone_map if chosen == "scene" else chosen
