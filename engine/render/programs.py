"""Programs: pipelines by what a batch or a pass needs; the generated blocks in front of every shader."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from engine.core.errors import ShaderError
from engine.core.watched import Watched
from engine.gpu.glsl_layout import BlockLayout
from engine.gpu.preprocess import flatten
from engine.gpu.types import BlendState, DepthState, Device, Pipeline, RasterState, RenderPipelineDesc
from engine.materials.effect import Effect
from engine.materials.library import EffectLibrary
from engine.materials.variant import VariantRequest, shader_file, shadowing
from engine.render.draw_list import DrawState, arena_streams, caster_state, casts_shadow
from engine.render.facts import SceneFacts
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

PREMULTIPLIED = BlendState("one", "one_minus_src_alpha", "add", "one", "one_minus_src_alpha", "add")

#: the vertex shader of all full-screen passes
FULLSCREEN = "passes/fullscreen.vert"


@dataclass(frozen=True, slots=True)
class _ScreenRequest:
    """What makes the pipeline of a full-screen pass what it is."""

    fragment: str
    prelude: str
    defines: tuple[tuple[str, int], ...]
    depth: DepthState | None
    blend: BlendState | None


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
            facts.sun_shadows, facts.shadow_quality.filter,
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
    ) -> Pipeline:  # fmt: skip
        """The pipeline of a full-screen triangle with passes/<fragment>; `block` becomes a uniform block at binding 1,
        named as the instance `block_name`. Raises ShaderError where no version of the shader ever compiled."""
        prelude = VIEW_PRELUDE
        if block is not None:
            prelude += block.block_glsl(f"PassBlock_{block_name}", 1, block_name) + "\n"
        request = _ScreenRequest(fragment, prelude, tuple(sorted((defines or {}).items())), depth, blend)
        shader = self._passes.setdefault(fragment, _PassShader())
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
        files = {shader_file(FULLSCREEN, search), shader_file(f"passes/{fragment}", search), *shader.texts}
        return files.union(shadowing(files, search))

    def _compile(self, request: _ScreenRequest, texts: dict[Path, str], search: Sequence[Path]) -> Pipeline:
        name = f"passes/{request.fragment}"
        try:
            vertex = flatten(shader_file(FULLSCREEN, search, texts), "vertex", search=search, texts=texts)
            source = flatten(
                shader_file(name, search, texts), "fragment", search=search, prelude=request.prelude,
                defines=dict(request.defines), texts=texts,
            )  # fmt: skip
            desc = RenderPipelineDesc(
                request.fragment, vertex, source, (), "triangles", request.depth, (request.blend,), RasterState("none")
            )
            return self._device.render_pipeline(desc)
        finally:
            files = {shader_file(FULLSCREEN, search), shader_file(name, search), *texts}
            self._watched.add(files.union(shadowing(files, search), (file.parent for file in files)))


def _shadow_request(state: DrawState, arena: MeshArena, effect: Effect) -> VariantRequest:
    streams = tuple(s for s in arena_streams(arena, effect, state.features) if s not in ("normal", "tangent"))
    return VariantRequest(
        state.effect, "shadow", state.features, arena.attributes(streams), topology=state.topology, targets=0,
        prelude=SCENE_PRELUDE,
    )  # fmt: skip


def _request(state: DrawState, arena: MeshArena, facts: SceneFacts, effect: Effect) -> VariantRequest:
    streams = arena_streams(arena, effect, state.features)
    defines = {"HAS_UV0": int("uv0" in streams), "BLENDED": int(state.blended), **facts.variant_defines()}
    request = VariantRequest(
        state.effect, "forward", state.features, arena.attributes(streams), topology=state.topology, cull=state.cull,
        front_ccw=state.front_ccw, depth_write=not state.blended, prelude=SCENE_PRELUDE,
        defines=tuple(sorted(defines.items())),
    )  # fmt: skip
    return replace(request, blend=PREMULTIPLIED) if state.blended else request
