"""Programs: pipelines by what a batch or a pass needs; the generated blocks in front of every shader."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
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
from engine.materials.features import kept
from engine.materials.library import EffectLibrary
from engine.materials.variant import VariantRequest, shader_file, shadowing
from engine.materials.versions import includes
from engine.render.ahead import Ahead
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
    #: of the last good version, where `poll` took another over that nobody settled
    before: dict[Path, str] = field(default_factory=dict)
    #: of the version that `go_back` took out of use, and why
    refused: tuple[dict[Path, str], ShaderError] | None = None


class Programs:
    """Caches by key: one dict look-up a batch in the steady state. `errors`: what failed to compile and is drawn in
    magenta, by variant. `pass_errors`: fragment shader of a pass -> why its newest files are not in use."""

    def __init__(self, device: Device, effects: EffectLibrary) -> None:
        self._device = device
        self._effects = effects
        self._surface: dict[tuple[object, ...], Pipeline] = {}
        self._depth: dict[tuple[object, ...], Pipeline] = {}
        self._shadow: dict[tuple[object, ...], Pipeline] = {}
        self._counts: dict[tuple[object, ...], int] = {}
        self._revision = effects.revision
        self._facts: SceneFacts | None = None
        self._macros_of: tuple[SceneFacts | None, tuple[object, ...]] = (None, ())
        self._arenas: dict[int, MeshArena] = {}
        self._passes: dict[str, _PassShader] = {}
        self._watched = Watched()
        self.errors: dict[str, ShaderError] = {}
        self.pass_errors: dict[str, ShaderError] = {}
        self.ahead = Ahead()

    def forget(self) -> None:
        """Ask the library again for every pipeline (after a hot reload)."""
        self._surface.clear()
        self._depth.clear()
        self._shadow.clear()
        self._counts.clear()
        self.errors.clear()
        self._revision = self._effects.revision
        self.ahead.forget()

    def release(self) -> None:
        """Let the pipelines of the passes go; the library owns those of surfaces."""
        self.forget()
        for shader in self._passes.values():
            for pipeline in shader.pipelines.values():
                pipeline.release()
        self._passes.clear()

    # --- surfaces ---

    def passes(self, state: DrawState, facts: SceneFacts, role: str = "") -> int:
        """How often a batch is drawn: the passes of its technique for `role` ('': forward or G-buffer)."""
        if self._revision != self._effects.revision:
            self.forget()
        key = (state.effect, state.level, facts.quality, role or (facts.lighting.deferred, state.blended))
        count = self._counts.get(key)
        if count is None:
            effect = self._effects.get(state.effect)
            count = self._counts[key] = self._count(effect, role or _surface_role(state, facts, effect), state, facts)
        return count

    def _count(self, effect: Effect, role: str, state: DrawState, facts: SceneFacts) -> int:
        technique, _ = effect.technique(role).at(_level(state, facts), self._device.caps)
        return len(technique.passes) if technique is not None else 1

    def surface(self, state: DrawState, arena: MeshArena, facts: SceneFacts, samples: int, index: int = 0) -> Pipeline:
        """The pipeline of a batch; `index`: which of its passes."""
        if self._revision != self._effects.revision:
            self.forget()
        key = (
            state.effect, state.features, state.arena, state.topology, state.cull, state.front_ccw, state.blended,
            state.veil, self._macros(facts), facts.lighting, facts.samples > 1,
            facts.alpha_to_coverage and facts.samples, state.level, facts.quality, index,
        )  # fmt: skip
        pipeline = self._surface.get(key)
        if pipeline is None:
            self._arenas[state.arena] = arena
            effect = self._effects.get(state.effect)
            request = replace(_request(state, arena, facts, effect), index=index)
            pipeline, error = self._effects.of_request(self._device, request, effect)
            if error is not None:
                self.errors[f"{state.effect}: {', '.join(sorted(state.features))}"] = error
            self._surface[key] = pipeline
        self._facts = facts
        return pipeline

    def _macros(self, facts: SceneFacts) -> tuple[object, ...]:
        """What of the facts goes into the text of surface shaders, made once a frame."""
        if facts is not self._macros_of[0]:
            more = (facts.local_lights, facts.debug_view, facts.force_all)
            self._macros_of = (facts, (*facts.variant_defines().values(), *more))
        return self._macros_of[1]

    def shadow(self, state: DrawState, arena: MeshArena, facts: SceneFacts, index: int = 0) -> Pipeline:
        """The pipeline that draws the depth of a caster; one that does not compile draws it uncut."""
        if self._revision != self._effects.revision:
            self.forget()
        key = (state.effect, state.features, state.arena, state.topology, state.level, facts.quality, index)
        pipeline = self._shadow.get(key)
        if pipeline is None:
            effect = self._effects.get(state.effect)
            self._arenas[state.arena] = arena
            request = replace(_shadow_request(state, arena, effect, facts), index=index)
            pipeline, error = self._effects.of_request(self._device, request, effect)
            if error is not None:
                self.errors[f"{state.effect} shadow: {', '.join(sorted(state.features))}"] = error
            self._shadow[key] = pipeline
        return pipeline

    def depth(self, state: DrawState, arena: MeshArena, facts: SceneFacts, index: int = 0) -> Pipeline:
        """The pipeline that draws a solid batch's depth alone."""
        if self._revision != self._effects.revision:
            self.forget()
        key = (
            state.effect, state.features, state.arena, state.topology, state.cull, state.front_ccw, facts.samples,
            facts.alpha_to_coverage, state.level, facts.quality, index,
        )  # fmt: skip
        pipeline = self._depth.get(key)
        if pipeline is None:
            effect = self._effects.get(state.effect)
            self._arenas[state.arena] = arena
            request = replace(_depth_request(state, arena, facts, effect), index=index)
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
                facts, arena, effect = self._facts, self._arenas[state.arena], records[material].effect
                requests = _requests(state, arena, facts, effect, depth=bool(self._depth), shadow=bool(self._shadow))
                counts = [self._count(effect, request.role, state, facts) for request in requests]
                every = [
                    replace(request, index=index)
                    for request, count in zip(requests, counts, strict=True)
                    for index in range(count)
                ]
                for request in every:
                    materials = found.setdefault(request, [])
                    if material not in materials:
                        materials.append(material)
        return found

    def begun(
        self, key: Hashable, states: Callable[[], Iterable[tuple[int, DrawState]]], facts: SceneFacts,
        arenas: Sequence[MeshArena],
    ) -> bool:  # fmt: skip
        """Whether all that these (material, state) need can be had without a wait; if not, it is begun. See Ahead."""

        def wanted() -> list[VariantRequest]:
            found: dict[VariantRequest, None] = {}
            shadowed = facts.sun_shadows or facts.local_shadows > 0
            for _, state in states():
                effect = self._effects.get(state.effect)
                asked = _requests(state, arenas[state.arena], facts, effect, depth=facts.local_lights, shadow=shadowed)
                for request in asked:
                    for index in range(self._count(effect, request.role, state, facts)):
                        found[replace(request, index=index)] = None
            return list(found)

        if self._revision != self._effects.revision:
            self.forget()
        return self.ahead.begun(key, wanted, self._device, self._effects)

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
            self.ahead.wants(request)
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
        """Make the next `poll` compile all passes, also what was refused."""
        self._watched.invalidate()
        for shader in self._passes.values():
            shader.refused = None

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
            if shader.refused is not None and includes(shader.refused[0], texts):
                raise shader.refused[1]
        except ShaderError as error:
            for pipeline in made.values():
                pipeline.release()
            self.pass_errors[fragment] = error
            return False
        for pipeline in shader.pipelines.values():
            pipeline.release()
        shader.before = shader.before or shader.texts
        shader.pipelines, shader.texts, shader.refused = made, texts, None
        self.pass_errors.pop(fragment, None)
        return True

    def versions(self, fragment: str) -> tuple[dict[Path, str], dict[Path, str]] | None:
        """The files of (the last good version, the one that `poll` took over since), as EffectLibrary.versions."""
        shader = self._passes.get(fragment)
        return (shader.before, shader.texts) if shader is not None and shader.before else None

    def settle(self, fragment: str) -> None:
        """The version in use is the good one now."""
        if fragment in self._passes:
            self._passes[fragment].before = {}

    def go_back(self, fragment: str, error: ShaderError) -> bool:
        """Run the version before; `pass_errors` has `error` until the files change. False where there is none."""
        versions = self.versions(fragment)
        if versions is None:
            return False
        self._run(fragment, versions[0])
        self._passes[fragment].refused = (versions[1], error)
        self.pass_errors[fragment] = error
        return True

    def go_forward(self, fragment: str) -> bool:
        """Run the version that `go_back` took out of use all the same. False where that is not what stands."""
        shader = self._passes.get(fragment)
        if shader is None or shader.refused is None or self.pass_errors.get(fragment) is not shader.refused[1]:
            return False
        del self.pass_errors[fragment]
        self._run(fragment, shader.refused[0])
        shader.refused = None
        return True

    def _run(self, fragment: str, texts: dict[Path, str]) -> None:
        """Another version, made from its texts when it is asked for."""
        shader = self._passes[fragment]
        for pipeline in shader.pipelines.values():
            pipeline.release()
        shader.pipelines, shader.texts, shader.before = {}, dict(texts), {}

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


def _level(state: DrawState, facts: SceneFacts) -> str:
    """By hand, else by the quality setting."""
    return state.level or facts.quality


def _surface_role(state: DrawState, facts: SceneFacts, effect: Effect) -> str:
    deferred = facts.lighting.deferred and not state.blended and "gbuffer" in effect.techniques
    return "gbuffer" if deferred else "forward"


def _requests(
    state: DrawState, arena: MeshArena, facts: SceneFacts, effect: Effect, *, depth: bool, shadow: bool
) -> list[VariantRequest]:
    """What a batch of that state is drawn with: its surface, and where the frame has such passes depth and shadow."""
    requests = [_request(state, arena, facts, effect)]
    if depth and not state.blended and "depth" in effect.techniques:
        requests.append(_depth_request(state, arena, facts, effect))
    if shadow and casts_shadow(state, effect):
        requests.append(_shadow_request(caster_state(state, effect), arena, effect, facts))
    return requests


def _shadow_request(state: DrawState, arena: MeshArena, effect: Effect, facts: SceneFacts) -> VariantRequest:
    streams = arena_streams(arena, effect, state.features, "shadow")
    return VariantRequest(
        state.effect, "shadow", state.features, arena.attributes(streams), topology=state.topology, targets=0,
        prelude=SCENE_PRELUDE, level=_level(state, facts),
    )  # fmt: skip


def _depth_request(state: DrawState, arena: MeshArena, facts: SceneFacts, effect: Effect) -> VariantRequest:
    streams = arena_streams(arena, effect, state.features, "depth")
    return VariantRequest(
        state.effect, "depth", kept(effect.active("depth", state.features), state.features), arena.attributes(streams),
        topology=state.topology, cull=state.cull, front_ccw=state.front_ccw, targets=0, prelude=SCENE_PRELUDE,
        defines=_coverage(state, facts), level=_level(state, facts),
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
    role = _surface_role(state, facts, effect)
    streams = arena_streams(arena, effect, state.features, role)
    if facts.debug_view in UV_VIEWS and "uv0" in arena.layout and "uv0" not in streams:
        streams = (*streams, "uv0")
    lighting = facts.lighting
    defines = {
        "HAS_UV0": int("uv0" in streams), "BLENDED": int(state.blended), **facts.variant_defines(),
        "LOOP_STEPS": lighting.steps, "GBUFFER": int(role == "gbuffer"), "GBUFFER_LAYOUT": lighting.gbuffer,
        "LOCAL_LIGHTS": _local_lights(state, facts, effect, role),
    }  # fmt: skip
    defines |= dict(_coverage(state, facts))
    if state.transmissive and not state.veil:
        defines["SOLID"] = 1  # what is seen through it is its colour, not its alpha
    # nothing but local lights asks for it
    defines["MULTISAMPLED"] = int(facts.samples > 1 and defines["LOCAL_LIGHTS"] > 0)
    request = VariantRequest(
        state.effect, role, state.features, arena.attributes(streams), topology=state.topology, cull=state.cull,
        front_ccw=state.front_ccw, depth_write=False if state.veil else None, prelude=SCENE_PRELUDE,
        targets=1 + len(LAYOUTS[lighting.gbuffer]) * (role == "gbuffer"),
        defines=tuple(sorted(defines.items())), level=_level(state, facts), blended=state.blended,
    )  # fmt: skip
    if facts.debug_view == "wireframe":
        request = replace(request, fill="wireframe")
    if facts.debug_view == "overdraw":
        return replace(request, blend=ADDITIVE)
    return request
