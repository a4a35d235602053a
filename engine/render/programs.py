"""Programs: pipelines by what a batch or a pass needs; the generated blocks in front of every shader."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from engine.core.errors import ShaderError
from engine.core.watched import Watched
from engine.gpu.glsl_layout import BlockLayout
from engine.gpu.preprocess import flatten
from engine.gpu.types import (
    BlendState,
    ComputePipelineDesc,
    DepthState,
    Device,
    Pipeline,
    RasterState,
    RenderPipelineDesc,
    ShaderSource,
)
from engine.materials.effect import Effect
from engine.materials.library import EffectLibrary
from engine.materials.variant import VariantRequest, shader_file, shadowing
from engine.render.draw_list import DrawState, arena_streams, caster_state, casts_shadow
from engine.render.facts import SceneFacts
from engine.render.gbuffer import LAYOUTS
from engine.render.light_rows import light_glsl
from engine.render.view_block import VIEW_LAYOUT
from engine.resources.arena import MeshArena
from engine.resources.material_store import MaterialRecord

#: uniform and storage blocks that surface shaders see; the bindings are those of engine.render.frame
SCENE_PRELUDE = (
    VIEW_LAYOUT.block_glsl("ViewBlock", 0, "view")
    + "\nlayout(std430, binding = 0) readonly buffer TransformBlock { vec4 transforms[]; };"
    + "\nlayout(std430, binding = 1) readonly buffer ObjectBlock { uvec4 objects[]; };\n"
    + light_glsl(3)
    + "layout(std430, binding = 4) readonly buffer PaletteBlock { vec4 palette[]; };\n"
)
VIEW_PRELUDE = VIEW_LAYOUT.block_glsl("ViewBlock", 0, "view") + "\n"
LIGHT_PRELUDE = VIEW_PRELUDE + light_glsl(3)

PREMULTIPLIED = BlendState("one", "one_minus_src_alpha", "add", "one", "one_minus_src_alpha", "add")
ADDITIVE = BlendState("one", "one", "add", "one", "one", "add")
#: debug views that look at texture coordinates, also of what has no texture
UV_VIEWS = frozenset({"texel_density", "uv_checker"})

#: the vertex shader of all full-screen passes
FULLSCREEN = "passes/fullscreen.vert"
BOTH_FACES = RasterState("none")


@dataclass(frozen=True, slots=True)
class _ScreenRequest:
    """What makes the pipeline of a pass what it is; a `fragment` named *.comp is a compute shader."""

    fragment: str
    prelude: str
    defines: tuple[tuple[str, int], ...]
    depth: DepthState | None = None
    blend: BlendState | None = None
    vertex: str = FULLSCREEN
    raster: RasterState = BOTH_FACES

    @property
    def stages(self) -> tuple[str, ...]:
        return () if self.fragment.endswith(".comp") else (self.vertex,)


@dataclass(slots=True)
class _PassShader:
    """A fragment shader of shaders/passes: its pipelines, and the contents of the files they are made from."""

    pipelines: dict[_ScreenRequest, Pipeline] = field(default_factory=dict)
    texts: dict[Path, str] = field(default_factory=dict)


class Programs:
    """Caches by key: one dict look-up a batch in the steady state. `errors`: what failed to compile and is drawn in
    magenta, by variant. `pass_errors`: fragment shader of a pass -> why its newest files are not in use."""

    def __init__(self, device: Device, effects: EffectLibrary) -> None:
        self._device = device
        self._effects = effects
        self._surface: dict[tuple[object, ...], Pipeline] = {}
        self._depth: dict[tuple[object, ...], Pipeline] = {}
        self._shadow: dict[tuple[object, ...], Pipeline] = {}
        self._revision = effects.revision
        self._facts: SceneFacts | None = None
        self._arenas: dict[int, MeshArena] = {}
        self._passes: dict[str, _PassShader] = {}
        self._watched = Watched()
        self.errors: dict[str, ShaderError] = {}
        self.pass_errors: dict[str, ShaderError] = {}

    def forget(self) -> None:
        """Ask the library again for every pipeline (after a hot reload)."""
        self._surface.clear()
        self._depth.clear()
        self._shadow.clear()
        self.errors.clear()
        self._revision = self._effects.revision

    def release(self) -> None:
        """Let the pipelines of the passes go; the library owns those of surfaces."""
        self.forget()
        for shader in self._passes.values():
            for pipeline in shader.pipelines.values():
                pipeline.release()
        self._passes.clear()

    # --- surfaces ---

    def surface(self, state: DrawState, arena: MeshArena, facts: SceneFacts, samples: int) -> Pipeline:
        if self._revision != self._effects.revision:
            self.forget()
        key = (
            state.effect, state.features, state.arena, state.topology, state.cull, state.front_ccw, state.blended,
            facts.environment, facts.suns, facts.local_lights, facts.debug_view, facts.force_all,
            facts.sun_shadows, facts.shadow_quality.filter, facts.lighting, facts.samples > 1,
            facts.alpha_to_coverage and facts.samples,
        )  # fmt: skip
        pipeline = self._surface.get(key)
        if pipeline is None:
            self._arenas[state.arena] = arena
            effect = self._effects.get(state.effect)
            pipeline, error = self._effects.of_request(self._device, _request(state, arena, facts, effect), effect)
            if error is not None:
                self.errors[f"{state.effect}: {', '.join(sorted(state.features))}"] = error
            self._surface[key] = pipeline
        self._facts = facts
        return pipeline

    def shadow(self, state: DrawState, arena: MeshArena) -> Pipeline:
        """The pipeline that draws the depth of a caster; one that does not compile draws it uncut."""
        if self._revision != self._effects.revision:
            self.forget()
        key = (state.effect, state.features, state.arena, state.topology)
        pipeline = self._shadow.get(key)
        if pipeline is None:
            effect = self._effects.get(state.effect)
            self._arenas[state.arena] = arena
            request = _shadow_request(state, arena, effect)
            pipeline, error = self._effects.of_request(self._device, request, effect)
            if error is not None:
                self.errors[f"{state.effect} shadow: {', '.join(sorted(state.features))}"] = error
            self._shadow[key] = pipeline
        return pipeline

    def depth(self, state: DrawState, arena: MeshArena, facts: SceneFacts) -> Pipeline:
        """The pipeline that draws a solid batch's depth alone."""
        if self._revision != self._effects.revision:
            self.forget()
        key = (
            state.effect, state.features, state.arena, state.topology, state.cull, state.front_ccw, facts.samples,
            facts.alpha_to_coverage,
        )  # fmt: skip
        pipeline = self._depth.get(key)
        if pipeline is None:
            effect = self._effects.get(state.effect)
            self._arenas[state.arena] = arena
            request = _depth_request(state, arena, facts, effect)
            pipeline, error = self._effects.of_request(self._device, request, effect)
            if error is not None:
                self.errors[f"{state.effect} depth: {', '.join(sorted(state.features))}"] = error
            self._depth[key] = pipeline
        return pipeline

    def has_role(self, state: DrawState, role: str) -> bool:
        """Whether the effect of a batch has a technique of that name."""
        return role in self._effects.get(state.effect).techniques

    def requests(
        self, states: Iterable[tuple[int, DrawState]], records: Mapping[int, MaterialRecord]
    ) -> list[VariantRequest]:
        """What `surface` and `shadow` would ask of the library for these (material, state), by the last facts."""
        return list(self.uses(states, records))

    def uses(
        self, states: Iterable[tuple[int, DrawState]], records: Mapping[int, MaterialRecord]
    ) -> dict[VariantRequest, list[int]]:
        """As `requests`, with the materials that want each."""
        found: dict[VariantRequest, list[int]] = {}
        for material, state in states if self._facts is not None else ():
            if state.arena in self._arenas and self._facts is not None:
                arena, effect = self._arenas[state.arena], records[material].effect
                requests = [_request(state, arena, self._facts, effect)]
                if self._depth and not state.blended and "depth" in effect.techniques:
                    requests.append(_depth_request(state, arena, self._facts, effect))
                if self._shadow and casts_shadow(state, effect):
                    requests.append(_shadow_request(caster_state(state, effect), arena, effect))
                for request in requests:
                    materials = found.setdefault(request, [])
                    if material not in materials:
                        materials.append(material)
        return found

    # --- passes ---

    def screen(
        self, fragment: str, *, block: BlockLayout | None = None, block_name: str = "",
        defines: Mapping[str, int] | None = None, depth: DepthState | None = None, blend: BlendState | None = None,
        vertex: str = FULLSCREEN, raster: RasterState = BOTH_FACES, lights: bool = False,
    ) -> Pipeline:  # fmt: skip
        """The pipeline of a full-screen triangle with passes/<fragment>; `block` becomes a uniform block at binding 1,
        named as the instance `block_name`. `vertex`: another shader in the place of the triangle; `lights`: the table
        of local lights is declared. Raises ShaderError where no version of the shader ever compiled."""
        prelude = _pass_prelude(block, block_name, lights)
        items = tuple(sorted((defines or {}).items()))
        return self._pass(_ScreenRequest(fragment, prelude, items, depth, blend, vertex, raster))

    def compute(
        self, shader: str, *, block: BlockLayout | None = None, block_name: str = "",
        defines: Mapping[str, int] | None = None, lights: bool = False,
    ) -> Pipeline:  # fmt: skip
        """The pipeline of passes/<shader>, a compute shader (*.comp); the rest as in `screen`."""
        prelude = _pass_prelude(block, block_name, lights)
        return self._pass(_ScreenRequest(shader, prelude, tuple(sorted((defines or {}).items()))))

    def _pass(self, request: _ScreenRequest) -> Pipeline:
        shader = self._passes.setdefault(request.fragment, _PassShader())
        pipeline = shader.pipelines.get(request)
        if pipeline is None:
            pipeline = shader.pipelines[request] = self._first(request, shader)
        return pipeline

    def _first(self, request: _ScreenRequest, shader: _PassShader) -> Pipeline:
        """A pipeline that was not asked for before; where the project's own shader never was good, the built-in one."""
        search = self._effects.search
        try:
            return self._compile(request, shader.texts, search)
        except ShaderError as error:
            self.pass_errors[request.fragment] = error
            if not shader.pipelines:
                shader.texts.clear()
            if len(search) == 1:
                raise
            return self._compile(request, {}, search[-1:])

    def has_own(self, fragment: str) -> bool:
        """Whether the newest version of a pass's shader was good once."""
        return fragment in self._passes and bool(self._passes[fragment].texts)

    def changed(self) -> bool:
        """Whether a file of a pass is not as it was when `poll` last looked."""
        return bool(self._watched.changed())

    def invalidate(self) -> None:
        """Make the next `poll` compile all passes."""
        self._watched.invalidate()

    def poll(self) -> list[str]:
        """Compile aside the passes whose files changed; the names of those taken over. All pipelines of a shader change
        together or none: then `pass_errors` says why."""
        changed = self._watched.take()
        if not changed:
            return []
        taken = []
        for fragment, shader in self._passes.items():
            touched = changed & self._files(fragment, shader)
            if (touched or fragment in self.pass_errors) and self._reload(fragment, shader):
                taken.append(fragment)
        return taken

    def _reload(self, fragment: str, shader: _PassShader) -> bool:
        texts: dict[Path, str] = {}
        made: dict[_ScreenRequest, Pipeline] = {}
        try:
            for request in shader.pipelines:
                made[request] = self._compile(request, texts, self._effects.search)
        except ShaderError as error:
            for pipeline in made.values():
                pipeline.release()
            self.pass_errors[fragment] = error
            return False
        for pipeline in shader.pipelines.values():
            pipeline.release()
        shader.pipelines, shader.texts = made, texts
        self.pass_errors.pop(fragment, None)
        return True

    def _files(self, fragment: str, shader: _PassShader) -> set[Path]:
        search = self._effects.search
        stages = {stage for request in shader.pipelines for stage in request.stages}
        names = {f"passes/{fragment}", *stages}
        files = {*(shader_file(name, search) for name in names), *shader.texts}
        return files.union(shadowing(files, search))

    def _compile(self, request: _ScreenRequest, texts: dict[Path, str], search: Sequence[Path]) -> Pipeline:
        name = f"passes/{request.fragment}"
        defines = dict(request.defines)

        def stage(file: str, kind: str) -> ShaderSource:
            path = shader_file(file, search, texts)
            plain = file == FULLSCREEN  # it needs no blocks, and stays one text for all
            prelude = "" if plain else request.prelude
            return flatten(path, kind, search=search, prelude=prelude, defines={} if plain else defines, texts=texts)

        try:
            if not request.stages:
                return self._device.compute_pipeline(ComputePipelineDesc(request.fragment, stage(name, "compute")))
            desc = RenderPipelineDesc(
                request.fragment, stage(request.vertex, "vertex"), stage(name, "fragment"), (), "triangles",
                request.depth, (request.blend,), request.raster,
            )  # fmt: skip
            return self._device.render_pipeline(desc)
        finally:
            files = {*(shader_file(file, search) for file in (name, *request.stages)), *texts}
            self._watched.add(files.union(shadowing(files, search), (file.parent for file in files)))


def _pass_prelude(block: BlockLayout | None, block_name: str, lights: bool) -> str:
    prelude = LIGHT_PRELUDE if lights else VIEW_PRELUDE
    if block is not None:
        prelude += block.block_glsl(f"PassBlock_{block_name}", 1, block_name) + "\n"
    return prelude


def _shadow_request(state: DrawState, arena: MeshArena, effect: Effect) -> VariantRequest:
    streams = tuple(s for s in arena_streams(arena, effect, state.features) if s not in ("normal", "tangent"))
    return VariantRequest(
        state.effect, "shadow", state.features, arena.attributes(streams), topology=state.topology, targets=0,
        prelude=SCENE_PRELUDE,
    )  # fmt: skip


def _depth_request(state: DrawState, arena: MeshArena, facts: SceneFacts, effect: Effect) -> VariantRequest:
    streams = tuple(s for s in arena_streams(arena, effect, state.features) if s not in ("normal", "tangent"))
    return VariantRequest(
        state.effect, "depth", effect.active("depth", state.features), arena.attributes(streams),
        topology=state.topology, cull=state.cull, front_ccw=state.front_ccw, targets=0, prelude=SCENE_PRELUDE,
        defines=_coverage(state, facts),
    )  # fmt: skip


def _coverage(state: DrawState, facts: SceneFacts) -> tuple[tuple[str, int], ...]:
    """The macro of alpha to coverage, for what is cut out."""
    wanted = facts.alpha_to_coverage and "alpha_test" in state.features
    return (("ALPHA_TO_COVERAGE", facts.samples),) if wanted else ()


def _local_lights(state: DrawState, facts: SceneFacts, effect: Effect, role: str) -> int:
    """The macro LOCAL_LIGHTS (shaders/lib/local_lights.glsl)."""
    lighting = facts.lighting
    if role == "gbuffer" or not (facts.local_lights or facts.force_all):
        return 0
    if lighting.path == "forward":
        return 1
    if state.blended:
        return 2
    # what is not in the depth that the lists were made from reads none of them
    return 2 if lighting.path == "forward-plus" and "depth" in effect.techniques else 1


def _request(state: DrawState, arena: MeshArena, facts: SceneFacts, effect: Effect) -> VariantRequest:
    streams = arena_streams(arena, effect, state.features)
    if facts.debug_view in UV_VIEWS and "uv0" in arena.layout and "uv0" not in streams:
        streams = (*streams, "uv0")
    lighting = facts.lighting
    role = "gbuffer" if lighting.deferred and not state.blended and "gbuffer" in effect.techniques else "forward"
    defines = {
        "HAS_UV0": int("uv0" in streams), "BLENDED": int(state.blended), **facts.variant_defines(),
        "LOOP_STEPS": lighting.steps, "GBUFFER": int(role == "gbuffer"), "GBUFFER_LAYOUT": lighting.gbuffer,
        "LOCAL_LIGHTS": _local_lights(state, facts, effect, role),
    }  # fmt: skip
    defines |= dict(_coverage(state, facts))
    # nothing but local lights asks for it
    defines["MULTISAMPLED"] = int(facts.samples > 1 and defines["LOCAL_LIGHTS"] > 0)
    request = VariantRequest(
        state.effect, role, state.features, arena.attributes(streams), topology=state.topology, cull=state.cull,
        front_ccw=state.front_ccw, depth_write=not state.blended, prelude=SCENE_PRELUDE,
        targets=1 + len(LAYOUTS[lighting.gbuffer]) * (role == "gbuffer"),
        defines=tuple(sorted(defines.items())),
    )  # fmt: skip
    if facts.debug_view == "wireframe":
        request = replace(request, fill="wireframe")
    if facts.debug_view == "overdraw":
        return replace(request, blend=ADDITIVE)
    return replace(request, blend=PREMULTIPLIED) if state.blended else request
