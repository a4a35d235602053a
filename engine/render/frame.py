"""RenderFrame: what the passes of one frame see; Frame: what the caller gets."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.framegraph.compiled import CompiledGraph
from engine.gpu.types import Bindings, Buffer, Device, Pipeline, RenderPass, Sampler, Texture
from engine.render.draw_list import DrawList
from engine.render.draw_states import Batch, DrawState
from engine.render.exposure import ExposureState
from engine.render.facts import SceneFacts
from engine.render.legends import Legend
from engine.render.light_lists import LightLists
from engine.render.lighting import Choice
from engine.render.motion.frame import FrameMotion
from engine.render.planar.mirrors import Mirrors
from engine.render.programs import Programs
from engine.render.shadows.local import LocalShadows
from engine.render.shadows.sun import SunShadows
from engine.render.view import View
from engine.report.number_check import NumberReport
from engine.report.stats import FrameStats
from engine.resources.environment import DfgTable, EnvironmentMap
from engine.resources.residency import Residency

# Binding numbers shared with the shaders' prelude (programs.py) and lib/environment.glsl.
VIEW_BINDING = 0
PASS_BINDING = 1
TRANSFORM_BINDING = 0
OBJECT_BINDING = 1
MATERIAL_BINDING = 2
LIGHT_BINDING = 3
PALETTE_BINDING = 4
LIGHT_LIST_BINDING = 5
MORPH_BINDING = 7
LIGHT_BOUNDS_BINDING = 10
LOCAL_SHADOW_BINDING = 11
ENVIRONMENT_UNIT = 8
DFG_UNIT = 9
INPUT_UNIT = 10
SHADOW_UNIT = 11
SHADOW_DEPTH_UNIT = 12
SHADOW_TINT_UNIT = 23
LIGHT_TILES_UNIT = 16
GBUFFER_UNIT = 17
DEPTH_UNIT = 20
SCENE_COLOR_UNIT = 24
SCENE_FRONT_UNIT = 17
AMBIENT_UNIT = 25
INDIRECT_UNIT = 28
REFLECTION_UNIT = 29
PLANAR_UNIT = 30
PLANAR_REACH_UNIT = 31
LOCAL_SHADOW_UNIT = 26
LOCAL_DEPTH_UNIT = 15
LOCAL_TINT_UNIT = 27
BLOOM_UNIT = 26
EXPOSURE_UNIT = 27


@dataclass(frozen=True, slots=True)
class OtherRole:
    """A role that a pass draws by itself. `program`: the pipeline of (draw state, pass of the technique); `uniforms`:
    its own blocks, by binding; `key`: what tells its pipelines from others of the same state."""

    role: str
    program: Callable[[DrawState, int], Pipeline]
    uniforms: Mapping[int, Any]
    key: Hashable


@dataclass(frozen=True, slots=True)
class SeenBy:
    """Another eye than the frame's: its view block, what it sees, as object ids and commands, and its light lists."""

    view: Buffer
    ids: Buffer
    commands: Buffer
    lists: LightLists


@dataclass(slots=True)
class RenderFrame:
    """Everything a pass may use besides its own textures."""

    device: Device
    view: View
    facts: SceneFacts
    residency: Residency
    programs: Programs
    draws: DrawList
    environment: EnvironmentMap
    dfg: DfgTable
    view_buffer: Buffer
    transforms: Buffer
    lights: Buffer
    light_count: int
    light_lists: LightLists
    palettes: Buffer
    morphs: Buffer
    point_sampler: Sampler
    origin: NDArray[np.float64]
    shadows: SunShadows
    shadow_rows: NDArray[np.void]
    exposure: ExposureState
    local_shadows: LocalShadows
    mirrors: Mirrors
    motion: FrameMotion = field(default_factory=FrameMotion)
    look: Mapping[str, Any] = field(default_factory=dict)
    pass_buffers: dict[str, Buffer] = field(default_factory=dict)
    #: what lib/lights.glsl looks up, by unit (light_tables.py)
    light_textures: Mapping[int, Any] = field(default_factory=dict)

    def pass_block(self, name: str, row: NDArray[np.void]) -> Buffer:
        """The uniform buffer of a pass, holding `row`."""
        data = row.tobytes()
        buffer = self.pass_buffers.get(name)
        if buffer is None:
            buffer = self.pass_buffers[name] = self.device.buffer(data, label=name)
        else:
            buffer.write(data)
        return buffer

    def view_bindings(
        self, textures: Mapping[int, Any] | None = None, uniforms: Mapping[int, Any] | None = None
    ) -> Bindings:
        """The view block and the environment, plus a pass's own inputs."""
        return Bindings(
            uniforms={VIEW_BINDING: self.view_buffer, **(uniforms or {})},
            textures={
                ENVIRONMENT_UNIT: (self.environment.texture, self.environment.sampler),
                DFG_UNIT: (self.dfg.texture, self.dfg.sampler),
                **(textures or {}),
            },
        )

    def pass_bindings(
        self, textures: Mapping[int, Any], uniforms: Mapping[int, Any], images: Mapping[int, Any]
    ) -> Bindings:
        """The view block and a compute pass's own inputs and outputs."""
        return Bindings({VIEW_BINDING: self.view_buffer, **uniforms}, {}, dict(textures), dict(images))

    def draw_batches(
        self, render_pass: RenderPass, batches: list[Batch], samples: int, inputs: Mapping[int, Any] | None = None,
        depth_only: bool = False, other: OtherRole | None = None, seen: SeenBy | None = None,
    ) -> None:  # fmt: skip
        """Draw batches with their pipelines, arenas and materials: one multi-draw each. `inputs`: more textures.
        `other`: the role of a pass with pipelines of its own; `seen`: by whom, if not by the frame's camera."""
        seen = seen or SeenBy(self.view_buffer, self.draws.ids, self.draws.commands, self.light_lists)
        blocks = {VIEW_BINDING: seen.view, **self.mirrors.uniforms, **(other.uniforms if other else {})}
        for batch in batches:
            state = batch.state
            arena = self.residency.arenas[state.arena]
            render_pass.set_vertex_buffers({**arena.streams, "object": seen.ids}, arena.indices)
            materials = self.residency.materials
            render_pass.set_bindings(
                Bindings(
                    uniforms=blocks,
                    storage={
                        TRANSFORM_BINDING: self.transforms,
                        OBJECT_BINDING: self.draws.objects,
                        MATERIAL_BINDING: materials.buffer(state.effect),
                        LIGHT_BINDING: self.lights,
                        LOCAL_SHADOW_BINDING: self.local_shadows.buffer,
                        PALETTE_BINDING: self.palettes,
                        MORPH_BINDING: self.morphs,
                        **seen.lists.shading_storage,
                    },
                    textures={
                        **materials.bindings(state.group, self.view.settings.anisotropy),
                        ENVIRONMENT_UNIT: (self.environment.texture, self.environment.sampler),
                        DFG_UNIT: (self.dfg.texture, self.dfg.sampler),
                        **self.light_textures,
                        **(inputs or {}),
                    },
                )
            )
            role = "depth" if depth_only else (other.role if other else "")
            for index in range(self.programs.passes(state, self.facts, role)):
                if not self.programs.ahead.wants((state, other.key if other else depth_only, index)):
                    continue
                if other is not None:
                    render_pass.set_pipeline(other.program(state, index))
                elif depth_only:
                    render_pass.set_pipeline(self.programs.depth(state, arena, self.facts, index))
                else:
                    render_pass.set_pipeline(self.programs.surface(state, arena, self.facts, samples, index))
                render_pass.multi_draw_indexed_indirect(seen.commands, batch.first, batch.count)

    def light_bindings(
        self, textures: Mapping[int, Any] | None = None, uniforms: Mapping[int, Any] | None = None,
        storage: Mapping[int, Any] | None = None, images: Mapping[int, Any] | None = None,
    ) -> Bindings:  # fmt: skip
        """The view block and the light table, plus a pass's own inputs: for passes that light the G-buffer."""
        return Bindings(
            uniforms={VIEW_BINDING: self.view_buffer, **(uniforms or {})},
            storage={
                LIGHT_BINDING: self.lights, LOCAL_SHADOW_BINDING: self.local_shadows.buffer,
                **self.light_lists.shading_storage, **(storage or {}),
            },
            textures={DFG_UNIT: (self.dfg.texture, self.dfg.sampler), **self.light_textures, **(textures or {})},
            images=images or {},
        )  # fmt: skip

    def draw_casters(
        self, render_pass: RenderPass, batches: list[Batch], view_buffer: Buffer, *, lamps: bool = False,
        other: OtherRole | None = None,
    ) -> None:  # fmt: skip
        """Draw the depth of casters as `view_buffer` (a view block) sees them. `lamps`: `batches` are lamp_batches;
        `other`: the role of a pass with pipelines of its own, which draws tint_batches, or with `lamps`
        lamp_tint_batches."""
        draws = self.draws
        ids, commands = (draws.lamp_ids, draws.lamp_commands) if lamps else (draws.caster_ids, draws.caster_commands)
        if other is not None:
            ids, commands = draws.tint_ids, draws.tint_commands
        if other is not None and lamps:
            ids, commands = draws.lamp_tint_ids, draws.lamp_tint_commands
        role = other.role if other else "shadow"
        for batch in batches:
            state = batch.state
            arena = self.residency.arenas[state.arena]
            render_pass.set_vertex_buffers({**arena.streams, "object": ids}, arena.indices)
            materials = self.residency.materials
            render_pass.set_bindings(
                Bindings(
                    uniforms={VIEW_BINDING: view_buffer},
                    storage={
                        TRANSFORM_BINDING: self.transforms,
                        OBJECT_BINDING: self.draws.objects,
                        MATERIAL_BINDING: materials.buffer(state.effect),
                        PALETTE_BINDING: self.palettes,
                        MORPH_BINDING: self.morphs,
                    },
                    textures=materials.bindings(state.group) if state.group >= 0 else {},
                )
            )
            for index in range(self.programs.passes(state, self.facts, role)):
                if not self.programs.ahead.wants((state, role, index)):
                    continue
                if other is not None:
                    render_pass.set_pipeline(other.program(state, index))
                else:
                    render_pass.set_pipeline(self.programs.shadow(state, arena, self.facts, index))
                render_pass.multi_draw_indexed_indirect(commands, batch.first, batch.count)


@dataclass(slots=True)
class Frame:
    """`color`: rgba8, sRGB-encoded, top row first. `hdr`: rgba32f scene-linear where it was asked for, else None.

    Both belong to the renderer and hold until its next frame."""

    color: Texture
    hdr: Texture | None
    stats: FrameStats
    graph: CompiledGraph
    facts: SceneFacts
    #: what the check of the numbers found, where the settings asked for one
    numbers: NumberReport | None = None
    #: by which path local lights were added, and why
    path: Choice = field(default_factory=lambda: Choice("forward", 1, ""))
    #: what the colours of its debug view mean, where they are a ramp
    legend: Legend | None = None
    #: False while the exposure is on its way: the next picture of the same scene is another
    settled: bool = True
