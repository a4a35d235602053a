"""Renderer: scene + view -> picture. Holds what lives between frames: graph, programs, buffers."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.findings import Findings
from engine.framegraph.compiled import CompiledGraph, OnPass
from engine.framegraph.graph import FrameGraph
from engine.framegraph.passes import Pass, PassContext
from engine.gpu.types import Device, SamplerDesc
from engine.materials.variant import VariantRequest
from engine.math.frustum import planes_from_matrix
from engine.render.ahead import Enough
from engine.render.bloom import bloom_of, level_weights
from engine.render.depth_range import fit_depth
from engine.render.draw_list import DrawList
from engine.render.environments import Environments, usable
from engine.render.exposure import ExposureState
from engine.render.facts import SceneFacts
from engine.render.frame import Frame, RenderFrame
from engine.render.gbuffer import bytes_per_pixel, layout_of, widest
from engine.render.hysteresis import Hysteresis
from engine.render.legends import Legend, depth_range, legend_of
from engine.render.light_lists import LightLists
from engine.render.light_rows import LightRows
from engine.render.light_tables import LightTables
from engine.render.lighting import Choice, loop_steps
from engine.render.morphs import MorphRows
from engine.render.nonfinite import NumberCheck
from engine.render.occlusion import occlusion_of, radius_of
from engine.render.palettes import PaletteRows, SkinningCheck
from engine.render.pass_timer import PassTimer
from engine.render.paths.choice import PASSES, choose, lighting_of
from engine.render.paths.cost import CostModel
from engine.render.paths.cost import load as load_costs
from engine.render.programs import Programs
from engine.render.scene_variants import SceneVariants
from engine.render.settings import LIT_LOOK, NONFINITE, ON_BLACK
from engine.render.shadows.local import LocalShadows
from engine.render.shadows.quality import ShadowQuality, filter_for
from engine.render.shadows.sun import SunShadows
from engine.render.transforms import TransformRows, origin_near
from engine.render.view import View
from engine.render.view_block import VIEW_LAYOUT, fill_view_block
from engine.report.number_check import NumberReport
from engine.report.stats import FrameStats
from engine.resources.environment import DfgTable
from engine.resources.material_store import MaterialRecord
from engine.resources.procedural import PLACE
from engine.resources.residency import Residency
from engine.scene.culling import visible_instances
from engine.scene.scene import Scene

BLACK = (0.0, 0.0, 0.0)


class Renderer:
    """Renders one scene at a time; a change of scene object is noticed. `profile`: measure each pass (on a software
    rasteriser this waits for it after every pass)."""

    def __init__(self, device: Device, residency: Residency, *, profile: bool = True) -> None:
        self.device = device
        self.residency = residency
        self.profile = profile
        self.programs = Programs(device, residency.effects)
        #: path -> its passes, made when first taken
        self.graphs: dict[str, FrameGraph] = {"forward": FrameGraph(PASSES["forward"]())}
        #: of the last frame
        self.path: Choice = Choice("forward", 1, "")
        self.cost_model: CostModel = load_costs(device.caps)
        self.environments = Environments(device)
        self.draws = DrawList(device, residency)
        self.variants = SceneVariants(residency, self.programs, self.draws)
        #: whether its views' quality decides how large computed textures are, which all renderers share
        self.leads = True
        self._dfg = DfgTable(device)
        self._transforms = TransformRows(device)
        self._lights = LightRows(device)
        self._light_tables = LightTables(device)
        self.light_lists = LightLists(device)
        self._layout: tuple[object, int] = ((), 0)
        self._gbuffer_bytes = 0
        self._skinning = SkinningCheck(residency)
        self._palettes = PaletteRows(device)
        self._morphs = MorphRows(device, residency)
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
        self._local_shadows = LocalShadows(device)
        self._ambient_radius: tuple[object, float] = ((), 1.0)
        self._exposure = ExposureState(device)
        #: holds on to facts that flicker
        self.hysteresis = Hysteresis()
        self._numbers: NumberCheck | None = None
        #: (which picture, the report) of the first one whose check found NaN or an infinity
        self.first_bad: tuple[int, NumberReport] | None = None

    def render(self, scene: Scene, view: View, *, hdr: bool = False) -> Frame:
        """One picture of `scene`; `hdr`: the scene-linear one too. Bad assets show as magenta.

        Raises InputError for a camera that no picture can be taken with, ShaderError when a pass of our own does not
        compile, DeviceError."""
        frame = self._picture(scene, view, hdr, None)
        assert frame is not None, "without a limit it is always finished"
        return frame

    def follow(self, scene: Scene, view: View, patience: float) -> Frame | None:
        """As `render`, but it spends no more than about `patience` seconds on programs that are new to the driver. None
        while there are more: what the last frame gave stays as it is; `programs.ahead` says how far it is."""
        return self._picture(scene, view, False, patience)

    def _picture(self, scene: Scene, view: View, hdr: bool, patience: float | None) -> Frame | None:
        view.camera.check(view.aspect)
        device = self.device
        device.begin_frame()
        device.counters.reset()
        self._timer.begin(self.profile)
        with self._timer.stage("update"):
            scene.update()
            view = fit_depth(view, scene)
            origin = origin_near(view.camera.position, view.camera.znear)
            self._transforms.update(scene, origin, self._changed_rows(scene))
            self._skinning.check(scene)
            self._palettes.update(scene, origin)
            self._morphs.update(scene, everything=view.settings.force_all)
        with self._timer.stage("visibility"):
            self._visibility(scene, view)
        frame = self._frame(scene, view, origin, hdr)
        ahead = self.programs.ahead
        ahead.start(None if view.settings.wants_numbers else patience, frame.facts)
        if not self.variants.begun(frame.facts):
            self._give_up()
            return None
        self._compute_textures(view)
        graph = self.graph.compile(
            device, frame.facts, (view.width, view.height), force_all=view.settings.force_all, key=hdr
        )
        check = self._begin_check(view, graph)
        try:
            graph.execute(lambda item: _context(device, graph, item, frame), self._observer(graph, check))
            if ahead.skipping:  # that was the last slice
                ahead.skipping = False
                graph.execute(lambda item: _context(device, graph, item, frame), self._observer(graph, check))
        except Enough:
            ahead.skipping = True
            self._give_up()
            return None
        ahead.whole()
        numbers = check.finish() if check is not None else None
        if numbers is not None and numbers.first is not None and self.first_bad is None:
            self.first_bad = (self.frames, numbers)
        if check is not None and view.settings.view == NONFINITE:
            check.show(graph.texture("color"))
        stats = self._stats(graph.transient_bytes)
        if frame.facts.auto_exposure:
            self._exposure.read(wait=view.seconds is None or device.caps.software)
            stats.counters["auto_exposure_ev"] = round(self._exposure.stops, 3)
        device.end_frame()
        self.frames += 1
        hdr_texture = graph.texture("hdr_resolved") if hdr else None
        legend = frame.look["legend"]
        settled = not frame.facts.auto_exposure or self._exposure.settled
        return Frame(
            graph.texture("color"), hdr_texture, stats, graph, frame.facts, numbers, self.path, legend, settled
        )

    def _compute_textures(self, view: View) -> None:
        """Have the textures that effects compute up to date, of all that is drawn, seen or not."""
        textures, draws = self.residency.procedural, self.draws
        if self.leads:
            textures.quality = str(view.settings.quality)
        textures.update(self.residency.materials, lambda: draws.materials, id(self), draws.built_rev)

    def _give_up(self) -> None:
        self._timer.drop()
        self.device.end_frame()

    @property
    def graph(self) -> FrameGraph:
        """The passes of the last frame's path."""
        path = self.path.path
        if path not in self.graphs:
            self.graphs[path] = FrameGraph(PASSES[path]())
        return self.graphs[path]

    @property
    def seen(self) -> NDArray[np.bool_]:
        """bool[instances]: what the last picture's frustum held; empty before the first."""
        return self._visible

    def requests(self, records: Mapping[int, MaterialRecord]) -> list[VariantRequest]:
        """The shader variants that the last frame would have asked for if these materials were as in `records`."""
        return list(self.variants.uses(records))

    def variant_uses(self) -> dict[VariantRequest, list[int]]:
        """The shader variants of the last frame's scene, seen or not, and the materials that want each."""
        return self.variants.uses(dict(enumerate(self.residency.materials.records)))

    @property
    def profiles(self) -> LightTables:
        """The files of the lights' IES profiles, which hot reload watches."""
        return self._light_tables

    @property
    def light_findings(self) -> Findings:
        """What was wrong with the IES profiles of the last frame's scene, and which lights go without shadow."""
        shadows = self._local_shadows.findings
        return Findings(items=[*self._light_tables.findings, *shadows]) if len(shadows) else self._light_tables.findings

    @property
    def skin_findings(self) -> Findings:
        """Which skins of the last frame's scene are not blended as they should be."""
        return self._skinning.findings

    def release(self) -> None:
        self.residency.procedural.forget(id(self))
        for graph in self.graphs.values():
            graph.release()
        for part in (
            self.programs,
            self.environments,
            self.draws,
            self._dfg,
            self._transforms,
            self._lights,
            self._light_tables,
            self.light_lists,
            self._palettes,
            self._morphs,
            self._exposure,
            self._view_buffer,
            self._local_shadows,
        ):
            part.release()
        for buffer in self._pass_buffers.values():
            buffer.release()
        self._pass_buffers.clear()
        if self._numbers is not None:
            self._numbers.release()
            self._numbers = None

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
        rebuilt = self.draws.build(scene, everything=view.settings.force_all)
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
        if self._shadows.update(
            scene, view, direction, self._visible, draws.casting & drawn, draws.receiving & drawn,
            self._look_of_casters(view),
        ):  # fmt: skip
            draws.update_casters(self._shadows.casters)
        return shown

    def _lamp_shadows(self, scene: Scene, view: View) -> int:
        """The width of the map of local lights' shadows, 0 where none casts; its tiles and casters are up to date."""
        draws, drawn, shadows = self.draws, scene.instances.drawn, self._local_shadows
        if shadows.update(
            scene, view, self._lights.world, draws.casting & drawn,
            receiving=bool((draws.receiving & drawn).any()), state=self._look_of_casters(view),
        ):  # fmt: skip
            draws.update_lamp_casters(shadows.casters)
        return shadows.atlas

    def _look_of_casters(self, view: View) -> tuple[object, ...]:
        """What else than where they are changes a shadow map."""
        materials = self.residency.materials
        return (self.draws.built_rev, self.residency.effects.revision, materials.values_rev, str(view.settings.quality))

    def _frame(self, scene: Scene, view: View, origin: NDArray[np.float64], hdr: bool) -> RenderFrame:
        settings = view.settings
        rotation = math.radians(settings.environment_rotation)
        environment = usable(scene.environment)
        env_map = self.environments.get(environment)
        env_intensity = environment.intensity * settings.environment_intensity
        tables = self._light_tables
        tables.update(scene, everything=settings.force_all)
        self._lights.update(scene, environment, origin, settings.sun_intensity, rotation, tables.layers)
        block = fill_view_block(
            view, origin, env_map.irradiance_sh, env_map.mips, env_intensity,
            environment.rotation + rotation, self._lights,
        )  # fmt: skip
        sun_shadows = self._sun_shadows(scene, view)
        self._shadows.fill(block, view, origin, everywhere=settings.force_all)
        background = environment.background if settings.background == "scene" else settings.background
        lit = environment.kind != "none" and env_intensity > 0.0
        facts = SceneFacts(
            opaque=self.draws.has_solid,
            transparent=self.draws.has_blended,
            transmission=self.draws.has_transmissive,
            suns=self._lights.sun_count > 0,
            local_lights=self._lights.count > 0,
            environment=lit,
            background=lit and background == "environment" and settings.shading_view not in ON_BLACK,
            tone_map=_tone_map(scene, view),
            samples=self.device.caps.samples_for(settings.samples),
            debug_view=settings.shading_view,
            hdr_output=hdr,
            force_all=settings.force_all,
            quality=str(settings.quality),
            stencil=self.draws.uses_stencil,
            ambient_occlusion=occlusion_of(settings, lit=lit, solid=self.draws.has_solid),
            auto_exposure=settings.auto_exposure and settings.shading_view in LIT_LOOK,
            bloom=bloom_of(settings, view.width, view.height, shown=settings.shading_view in LIT_LOOK),
            area_lights=tables.area,
            light_profiles=tables.profiles,
            sun_shadows=sun_shadows,
            local_shadows=self._lamp_shadows(scene, view),
            shadow_quality=ShadowQuality(
                filter_for(settings.shadow_filter, software=self.device.caps.software),
                settings.shadow_cascades,
                settings.shadow_size,
                str(settings.shadow_precision),
            ).used(),
        )
        facts = self.hysteresis(scene, (hdr, view.width, view.height, settings.force_all), facts)
        facts = self._light_path(view, facts, block)
        self._view_buffer.write(block.tobytes())
        return RenderFrame(
            device=self.device, view=view, facts=facts, residency=self.residency, programs=self.programs,
            draws=self.draws, environment=env_map, dfg=self._dfg, view_buffer=self._view_buffer,
            transforms=self._transforms.buffer, lights=self._lights.buffer,
            light_count=self._lights.count, light_lists=self.light_lists, palettes=self._palettes.buffer,
            morphs=self._morphs.buffer,
            point_sampler=self._point_sampler, origin=origin, shadows=self._shadows, shadow_rows=block,
            local_shadows=self._local_shadows, exposure=self._exposure,
            look={
                "exposure": _exposure(scene, view),
                "subject": id(scene),
                "background": (*(BLACK if settings.shading_view in ON_BLACK else environment.background_color), 1.0),
                "background_blur": max(environment.background_blur, settings.background_blur),
                "legend": self._legend(scene, view),
                **self._ambient(scene, view, facts),
                "bloom_weights": level_weights(settings.bloom_radius, view.width, view.height)
                if facts.bloom.wanted
                else (1.0, 0.0),
            },
            pass_buffers=self._pass_buffers,
            light_textures=tables.bindings(),
        )  # fmt: skip

    def _ambient(self, scene: Scene, view: View, facts: SceneFacts) -> dict[str, float]:
        """How far and how strongly things hide the surroundings."""
        settings = view.settings
        if not facts.ambient_occlusion.wanted or settings.ao_radius > 0.0:
            return {"ambient_radius": settings.ao_radius or 1.0, "ambient_strength": settings.ao_strength}
        key = (id(scene), scene.transform_rev, scene.instances.drawn_rev)
        if self._ambient_radius[0] != key:
            self._ambient_radius = (key, radius_of(settings, *scene.bounds()))
        return {"ambient_radius": self._ambient_radius[1], "ambient_strength": settings.ao_strength}

    def _legend(self, scene: Scene, view: View) -> Legend | None:
        if view.settings.shading_view != "depth":
            return legend_of(view.settings.shading_view)
        table = scene.instances
        return legend_of(
            "depth", depth_range(view.camera, table.world_center[self._visible], table.world_radius[self._visible])
        )

    def _light_path(self, view: View, facts: SceneFacts, block: NDArray[np.void]) -> SceneFacts:
        """Choose the path and have its buffers ready; returns the facts with both."""
        settings, lights = view.settings, self._lights.count
        used = facts.local_lights or facts.force_all
        stored = settings.shading_view.startswith("gbuffer_")
        self.path = choice = choose(
            settings, local_lights=facts.local_lights, lights=lights, pixels=view.width * view.height,
            samples=facts.samples, model=self.cost_model, force_all=facts.force_all,
        )  # fmt: skip
        lighting = lighting_of(
            settings, choice, self._gbuffer_layout() if used or stored else 1, used=used,
            steps=loop_steps(lights, software=self.device.caps.software),
            forward_only=any("gbuffer" not in self._techniques(name) for name in self.draws.solid_effects),
        )  # fmt: skip
        self._gbuffer_bytes = view.width * view.height * bytes_per_pixel(lighting.gbuffer) * lighting.deferred
        if lighting.path == "forward":
            self.light_lists.forget()
        else:
            self.light_lists.upload_bounds(self._lights.bounds)
            self.light_lists.prepare(lighting, view.width, view.height, lights)
            block["tiles"], block["clusters"] = self.light_lists.view_fields(lighting, view.camera.znear)
        smooth = bool(settings.alpha_to_coverage) and choice.samples > 1 and self.draws.has_cutouts
        fxaa = settings.antialias == "fxaa" and choice.samples == 1 and settings.shading_view in LIT_LOOK
        return replace(facts, lighting=lighting, samples=choice.samples, alpha_to_coverage=smooth, fxaa=fxaa)

    def _techniques(self, effect: str) -> Mapping[str, object]:
        return self.residency.effects.get(effect).techniques

    def _gbuffer_layout(self) -> int:
        """The narrowest layout that holds all materials that the scene draws."""
        materials = self.residency.materials
        key = (self.draws.built_rev, materials.values_rev)
        if self._layout[0] != key:
            rows: dict[str, list[int]] = {}
            for material in self.draws.materials:
                record = materials.records[material]
                rows.setdefault(record.effect.name, []).append(record.row)
            layouts = [layout_of(materials.rows_of(effect)[used]) for effect, used in rows.items()]
            self._layout = (key, widest(layouts))
        return self._layout[1]

    def _begin_check(self, view: View, graph: CompiledGraph) -> NumberCheck | None:
        """The check of this frame's numbers, begun, where the settings ask for one."""
        if not view.settings.wants_numbers:
            return None
        if self._numbers is None:
            self._numbers = NumberCheck(self.device)
        self._numbers.begin(graph, PLACE, self.residency.procedural.textures())
        return self._numbers

    def _observer(self, graph: CompiledGraph, check: NumberCheck | None) -> OnPass:
        """What goes round each pass: its timer and, after it, the check of its numbers."""
        if check is None:
            return self._on_pass

        @contextlib.contextmanager
        def observed(name: str) -> Iterator[None]:
            with self._on_pass(name):
                yield
            with self._timer.gpu_pass(f"check of {name}"):
                check.after(graph, name)

        return observed

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
            **self._light_counters(),
            "graphs_compiled": sum(graph.compiles for graph in self.graphs.values()),
        }
        return stats

    def _light_counters(self) -> dict[str, int]:
        """What the light lists of this frame did; nothing where it has none."""
        lists = self.light_lists
        if not lists.columns:
            return {}
        stats = lists.read(wait=self.profile and self.device.caps.software)
        counters = {
            "light_lists": stats.tiles, "lights_tested": stats.tested, "lights_kept": stats.kept,
            "light_list_overflows": stats.overflow, "light_list_bytes": lists.bytes,
            "gbuffer_bytes": self._gbuffer_bytes,
        }  # fmt: skip
        if stats.needed < 0:
            return counters
        return {**counters, "lights_needed": stats.needed, "lights_needed_by_pixels": stats.in_pixels}


def _context(device: Device, graph: Any, item: Pass, frame: RenderFrame) -> PassContext:
    return PassContext(device, graph, item.name, frame.facts, frame)


def _exposure(scene: Scene, view: View) -> float:
    """Stops, besides what is metered."""
    settings = view.settings
    if settings.shading_view not in LIT_LOOK:
        return 0.0
    return float(settings.exposure) + (0.0 if settings.auto_exposure else scene.look.exposure)


def _tone_map(scene: Scene, view: View) -> str:
    if view.settings.shading_view not in LIT_LOOK:
        return "none"  # debug views show values as they are
    chosen = view.settings.tone_map
    return scene.look.tone_map if chosen == "scene" else chosen
