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
from engine.gpu.types import Device, SamplerDesc, Texture
from engine.materials.variant import VariantRequest
from engine.render.ahead import Enough
from engine.render.depth_range import fit_depth
from engine.render.environments import Environments, usable
from engine.render.exposure import Exposures
from engine.render.extra_passes import EXTRA
from engine.render.frame import Frame, RenderFrame
from engine.render.frame_facts import facts_of
from engine.render.hysteresis import Hysteresis
from engine.render.light_lists import LightLists
from engine.render.light_path import LightPath
from engine.render.light_tables import LightTables
from engine.render.lighting import Choice
from engine.render.look import FrameLook
from engine.render.motion.before import Before
from engine.render.motion.frame import FrameMotion
from engine.render.nonfinite import NumberCheck
from engine.render.occlusion import RESTING
from engine.render.pass_timer import PassTimer
from engine.render.paths.choice import PASSES
from engine.render.peek import Peek
from engine.render.programs import Programs
from engine.render.scene_rows import SceneRows
from engine.render.scene_variants import SceneVariants
from engine.render.settings import NONFINITE
from engine.render.temporal import gathered, shift_of
from engine.render.transforms import origin_near
from engine.render.view import View
from engine.render.view_block import VIEW_LAYOUT, fill_view_block
from engine.report.number_check import NumberReport
from engine.report.stats import FrameStats
from engine.resources.environment import DfgTable, EnvironmentMap
from engine.resources.material_store import MaterialRecord
from engine.resources.procedural import PLACE
from engine.resources.residency import Residency
from engine.scene.scene import Scene


class Renderer:
    """Renders one scene at a time; a change of scene object is noticed. `profile`: measure each pass (on a software
    rasteriser this waits for it after every pass)."""

    def __init__(self, device: Device, residency: Residency, *, profile: bool = True) -> None:
        self.device = device
        self.residency = residency
        self.profile = profile
        self.programs = Programs(device, residency.effects)
        #: path -> its passes, made when first taken
        self._extra_passes = EXTRA.revision
        self.graphs: dict[str, FrameGraph] = {"forward": FrameGraph(PASSES["forward"]())}
        self.environments = Environments(device)
        self.rows = SceneRows(device, residency)
        self.draws = self.rows.draws
        self.variants = SceneVariants(residency, self.programs, self.draws)
        #: whether its views' quality decides how large computed textures are, which all renderers share
        self.leads = True
        self.light_path = LightPath(device, self.rows)
        self._dfg = DfgTable(device)
        self._environment: EnvironmentMap | None = None
        self._look = FrameLook()
        self.before = Before(device, self.rows)
        self._view_buffer = device.buffer(VIEW_LAYOUT.size, label="view")
        self._pass_buffers: dict[str, Any] = {}
        self._point_sampler = device.sampler(SamplerDesc("clamp", "clamp", "clamp", "nearest", "nearest"))
        self._timer = PassTimer(device)
        #: pictures made so far
        self.frames = 0
        self._exposures = Exposures(device)
        #: holds on to facts that flicker
        self.hysteresis = Hysteresis()
        self._numbers: NumberCheck | None = None
        #: (which picture, the report) of the first one whose check found NaN or an infinity
        self.first_bad: tuple[int, NumberReport] | None = None
        #: a target that somebody wants to see as it is in the middle of a frame
        self.peek: Peek | None = None

    def render(self, scene: Scene, view: View, *, hdr: bool = False) -> Frame:
        """One picture of `scene`; `hdr`: the scene-linear one too. Bad assets show as magenta.

        Raises InputError for a camera that no picture can be taken with, ShaderError when a pass of our own does not
        compile, DeviceError."""
        *first, last = gathered(view, self.device.caps)
        for one in first:
            self._picture(scene, one, False, None)
        frame = self._picture(scene, last, hdr, None)
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
            self.rows.update(scene, view, origin)
        with self._timer.stage("visibility"):
            motion = self.before.begin(scene, view, origin)
            motion.jitter = shift_of(view, motion, device.caps)
            self.rows.look(scene, view, shifted=max(map(abs, motion.jitter)))
        frame = self._frame(scene, view, origin, hdr, motion)
        ahead = self.programs.ahead
        ahead.start(None if view.settings.wants_numbers else patience, frame.facts)
        if not self.variants.begun(frame.facts):
            self._give_up(view)
            return None
        self._compute_textures(view)
        graph = self.graph.compile(
            device, frame.facts, (view.width, view.height), force_all=view.settings.force_all, key=view.key
        )
        if not frame.motion.known:
            self.graph.reset_history(device, view.key)
        check = self._begin_check(view, graph)
        try:
            graph.execute(lambda item: _context(device, graph, item, frame), self._observer(graph, check))
            if ahead.skipping:  # that was the last slice
                ahead.skipping = False
                self.graph.reset_history(device, view.key)
                graph.execute(lambda item: _context(device, graph, item, frame), self._observer(graph, check))
        except Enough:
            ahead.skipping = True
            self._give_up(view)
            return None
        ahead.whole()
        self.before.end(self.path.path)
        numbers = check.finish() if check is not None else None
        if numbers is not None and numbers.first is not None and self.first_bad is None:
            self.first_bad = (self.frames, numbers)
        if check is not None and view.settings.view == NONFINITE:
            check.show(graph.texture("color"))
        stats = self._stats(graph.transient_bytes)
        if frame.facts.auto_exposure:
            frame.exposure.read(wait=view.seconds is None or device.caps.software)
            stats.counters["auto_exposure_ev"] = round(frame.exposure.stops, 3)
        device.end_frame()
        self.frames += 1
        hdr_texture = graph.texture("hdr_resolved") if hdr else None
        legend = frame.look["legend"]
        settled = not frame.facts.auto_exposure or frame.exposure.settled
        settled = settled and not (frame.facts.taa and frame.motion.frozen < 2 * view.settings.taa_frames)
        settled = settled and not (frame.facts.ambient_occlusion.temporal and frame.motion.frozen < RESTING)
        settled = settled and frame.motion.frozen >= frame.facts.indirect.rests_after
        return Frame(
            graph.texture("color"), hdr_texture, stats, graph, frame.facts, numbers, self.path, legend, settled
        )

    def _compute_textures(self, view: View) -> None:
        """Have the textures that effects compute up to date, of all that is drawn, seen or not."""
        textures, draws = self.residency.procedural, self.draws
        if self.leads:
            textures.quality = str(view.settings.quality)
        textures.update(self.residency.materials, lambda: draws.materials, id(self), draws.built_rev)

    def _give_up(self, view: View) -> None:
        self.before.lose(view.key)
        self._timer.drop()
        self.device.end_frame()

    @property
    def path(self) -> Choice:
        """By which path the last frame was lit."""
        return self.light_path.choice

    @property
    def light_lists(self) -> LightLists:
        return self.light_path.lists

    @property
    def graph(self) -> FrameGraph:
        """The passes of the last frame's path."""
        path = self.path.path
        if self._extra_passes != EXTRA.revision:
            self._extra_passes = EXTRA.revision
            for graph in self.graphs.values():
                graph.release()
            self.graphs.clear()
        if path not in self.graphs:
            self.graphs[path] = FrameGraph(PASSES[path]())
        return self.graphs[path]

    @property
    def seen(self) -> NDArray[np.bool_]:
        """bool[instances]: what the last picture's frustum held; empty before the first."""
        return self.rows.visible

    def requests(self, records: Mapping[int, MaterialRecord]) -> list[VariantRequest]:
        """The shader variants that the last frame would have asked for if these materials were as in `records`."""
        return list(self.variants.uses(records))

    def tables(self) -> dict[str, Texture]:
        """What the last frame was shaded with besides its targets and the materials: the surroundings, the split-sum
        table, the tables of lights."""
        if self._environment is None:
            return {}
        found = [self._environment.texture, self._dfg.texture]
        found += [texture for texture, _sampler in self.rows.light_tables.bindings().values()]
        return {texture.desc.label: texture for texture in found}

    def variant_uses(self) -> dict[VariantRequest, list[int]]:
        """The shader variants of the last frame's scene, seen or not, and the materials that want each."""
        return self.variants.uses(dict(enumerate(self.residency.materials.records)))

    @property
    def profiles(self) -> LightTables:
        """The files of the lights' IES profiles, which hot reload watches."""
        return self.rows.light_tables

    @property
    def light_findings(self) -> Findings:
        """What was wrong with the IES profiles of the last frame's scene, and which lights go without shadow."""
        shadows = self.rows.local_shadows.findings
        findings = self.rows.light_tables.findings
        return Findings(items=[*findings, *shadows]) if len(shadows) else findings

    @property
    def skin_findings(self) -> Findings:
        """Which skins of the last frame's scene are not blended as they should be."""
        return self.rows.skinning.findings

    def release(self) -> None:
        self.residency.procedural.forget(id(self))
        for graph in self.graphs.values():
            graph.release()
        for part in (
            self.programs, self.environments, self.rows, self._dfg, self.light_lists, self._exposures,
            self._view_buffer, self.before,
        ):  # fmt: skip
            part.release()
        for buffer in self._pass_buffers.values():
            buffer.release()
        self._pass_buffers.clear()
        if self._numbers is not None:
            self._numbers.release()
            self._numbers = None

    # --- parts of a frame ---

    def _frame(
        self, scene: Scene, view: View, origin: NDArray[np.float64], hdr: bool, motion: FrameMotion
    ) -> RenderFrame:
        settings, rows = view.settings, self.rows
        rotation = math.radians(settings.environment_rotation)
        environment = usable(scene.environment)
        env_map = self._environment = self.environments.get(environment)
        env_intensity = environment.intensity * settings.environment_intensity
        rows.light_tables.update(scene, everything=settings.force_all)
        rows.lights.update(
            scene, environment, origin, settings.sun_intensity, rotation, rows.light_tables.layers
        )  # fmt: skip
        block = fill_view_block(
            view, origin, env_map.irradiance_sh, env_map.mips, env_intensity,
            environment.rotation + rotation, rows.lights, motion.jitter,
        )  # fmt: skip
        sun_shadows = rows.sun_shadows(scene, view)
        rows.shadows.fill(block, view, origin, everywhere=settings.force_all)
        lit = environment.kind != "none" and env_intensity > 0.0
        facts = facts_of(
            scene, view, rows, self.device.caps, environment=environment, lit=lit, sun_shadows=sun_shadows, hdr=hdr
        )
        if facts.motion:
            facts = replace(facts, moving=self.before.find(motion))
        facts = self.hysteresis(scene, (view.key, hdr, view.width, view.height, settings.force_all), facts)
        facts = self.light_path.choose(view, facts, block)
        motion = self.before.on_path(self.path.path)
        rows.mirrors.update(
            scene, view, facts.planar, rows.draws, block, origin, rows.lights.bounds, motion.jitter,
            everything=facts.force_all,
        )  # fmt: skip
        self._view_buffer.write(block.tobytes())
        return RenderFrame(
            device=self.device, view=view, facts=facts, residency=self.residency, programs=self.programs,
            draws=rows.draws, environment=env_map, dfg=self._dfg, view_buffer=self._view_buffer,
            transforms=rows.transforms.buffer, lights=rows.lights.buffer,
            light_count=rows.lights.count, light_lists=self.light_lists, palettes=rows.palettes.buffer,
            morphs=rows.morphs.buffer,
            point_sampler=self._point_sampler, origin=origin, shadows=rows.shadows, shadow_rows=block,
            local_shadows=rows.local_shadows, mirrors=rows.mirrors, exposure=self._exposures.of(view.key),
            look=self._look.of(scene, view, facts, environment, rows.visible),
            pass_buffers=self._pass_buffers,
            light_textures=rows.light_tables.bindings(), motion=motion,
        )  # fmt: skip

    def _begin_check(self, view: View, graph: CompiledGraph) -> NumberCheck | None:
        """The check of this frame's numbers, begun, where the settings ask for one."""
        if not view.settings.wants_numbers:
            return None
        if self._numbers is None:
            self._numbers = NumberCheck(self.device)
        self._numbers.begin(graph, PLACE, self.residency.procedural.textures())
        return self._numbers

    def _observer(self, graph: CompiledGraph, check: NumberCheck | None) -> OnPass:
        """What goes round each pass: its timer and, after it, the check of its numbers and the look at a target."""
        peek = self.peek
        if check is None and peek is None:
            return self._on_pass

        @contextlib.contextmanager
        def observed(name: str) -> Iterator[None]:
            with self._on_pass(name):
                yield
            if check is not None:
                with self._timer.gpu_pass(f"check of {name}"):
                    check.after(graph, name)
            if peek is not None:
                peek.after(graph, name)

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
            **self.light_path.counters(wait=self.profile and self.device.caps.software),
            "graphs_compiled": sum(graph.compiles for graph in self.graphs.values()),
        }
        return stats


def _context(device: Device, graph: Any, item: Pass, frame: RenderFrame) -> PassContext:
    return PassContext(device, graph, item.name, frame.facts, frame)
