"""PassPrograms: the pipelines of the passes' own shaders, full-screen or compute, and their hot reload.

screen(fragment) / compute(shader) ──► one dict look-up ──► Pipeline
poll ──► files changed? ──► all pipelines of that shader compiled aside ──► together in use, or none of them
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
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
from engine.materials.library import EffectLibrary
from engine.materials.variant import shader_file, shadowing
from engine.materials.versions import includes
from engine.render.ahead import Ahead
from engine.render.blocks import LIGHT_PRELUDE, VIEW_PRELUDE

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


class PassPrograms:
    """`pass_errors`: fragment shader of a pass -> why its newest files are not in use."""

    def __init__(self, device: Device, effects: EffectLibrary) -> None:
        self._device = device
        self._effects = effects
        self._passes: dict[str, _PassShader] = {}
        self._watched = Watched()
        self.pass_errors: dict[str, ShaderError] = {}
        self.ahead = Ahead()

    def release(self) -> None:
        """Let the pipelines of the passes go."""
        for shader in self._passes.values():
            for pipeline in shader.pipelines.values():
                pipeline.release()
        self._passes.clear()

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
