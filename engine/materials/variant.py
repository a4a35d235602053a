"""A variant: one effect in one role with one set of features, streams and state, compiled to a pipeline."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Iterable, Iterator, Mapping, MutableMapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import TypedDict

from engine.core.errors import ShaderError, UsageError
from engine.core.toml_source import load_toml, with_caret
from engine.gpu.preprocess import flatten
from engine.gpu.types import (
    BlendState,
    Device,
    Pipeline,
    RenderPipelineDesc,
    ShaderSource,
    VertexAttribute,
)
from engine.materials.effect import BLENDS, BUILTIN_FEATURES, Effect
from engine.materials.suggest import hint

#: shown where a fragment shader does not compile
MAGENTA = "effects/magenta.frag"

#: draws nothing: for an effect whose vertex shader does not compile either
_NOWHERE = ShaderSource("vertex", "void main()\n{\n    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);\n}\n")


class StateOptions(TypedDict, total=False):
    """State given with a request. None, or left out: as the technique says.

    `blend`: a BlendState or a blend name of effect files; `targets`: how many colour attachments (0: depth only).
    """

    topology: str
    cull: str | None
    front_ccw: bool
    targets: int
    blend: BlendState | str | None
    depth_write: bool | None
    depth_compare: str | None
    fill: str | None


@dataclass(frozen=True, slots=True)
class VariantRequest:
    """What makes a variant what it is; the state as in StateOptions."""

    effect: str
    role: str
    features: frozenset[str]
    attributes: tuple[VertexAttribute, ...]
    topology: str = "triangles"
    cull: str | None = None
    front_ccw: bool = True
    targets: int = 1
    blend: BlendState | str | None = None
    depth_write: bool | None = None
    depth_compare: str | None = None
    fill: str | None = None
    defines: tuple[tuple[str, str | int], ...] = ()
    prelude: str = ""


@dataclass(slots=True, eq=False)
class Variant:
    """A cached variant. `pipeline` is the last good one; `error` says why the newest source has none.

    `features`: those that are on in this role; `reasons`: why; `absent`: feature -> why it is off. `asked`: someone
    asked for it since EffectLibrary.expect.
    """

    request: VariantRequest
    device: Device
    features: frozenset[str]
    reasons: dict[str, str] = field(default_factory=dict)
    absent: dict[str, str] = field(default_factory=dict)
    pipeline: Pipeline | None = None
    error: ShaderError | None = None
    fallback: Pipeline | None = None
    files: tuple[Path, ...] = ()
    source_hash: str = ""
    compile_ms: float = 0.0
    asked: bool = True

    @property
    def label(self) -> str:
        return f"{self.request.effect} {self.request.role}"


def let_go(variant: Variant) -> None:
    """Release the variant's pipelines and forget its error."""
    for pipeline in (variant.pipeline, variant.fallback):
        if pipeline is not None:
            pipeline.release()
    variant.pipeline = variant.fallback = variant.error = None


@dataclass(frozen=True, slots=True)
class Compiled:
    """A pipeline, the files it was made from, and the hash of its source."""

    pipeline: Pipeline
    files: tuple[Path, ...]
    source_hash: str
    ms: float = 0.0


def compile_variant(
    device: Device, effect: Effect, request: VariantRequest, search: Sequence[Path], *, magenta: bool = False,
    texts: MutableMapping[Path, str] | None = None,
) -> Compiled:  # fmt: skip
    """Flatten and compile. `magenta` replaces the fragment shader; `texts` as in `flatten`.

    Raises ShaderError with file:line:col."""
    begun = time.perf_counter()
    desc = describe(effect, request, search, magenta=magenta, texts=texts)
    digest = hashlib.sha256(desc.vertex.text.encode("utf-8"))
    digest.update(b"\0" + (desc.fragment.text if desc.fragment else "").encode("utf-8"))
    stages = (desc.vertex, desc.fragment) if desc.fragment else (desc.vertex,)
    names = dict.fromkeys(file for stage in stages for file, _ in stage.lines)
    files = tuple(path for path in (_find(name, search) for name in names) if path is not None)
    pipeline = device.render_pipeline(desc)
    return Compiled(pipeline, files, digest.hexdigest(), 1e3 * (time.perf_counter() - begun))


def compile_nowhere(device: Device, request: VariantRequest) -> Pipeline:
    """The pipeline that draws nothing."""
    return device.render_pipeline(
        RenderPipelineDesc(
            f"{request.effect} {request.role} nowhere", _NOWHERE, None, topology=request.topology, depth=None,
            blend=(None,) * request.targets,
        )
    )  # fmt: skip


def describe(
    effect: Effect, request: VariantRequest, search: Sequence[Path], *, magenta: bool = False,
    texts: MutableMapping[Path, str] | None = None,
) -> RenderPipelineDesc:  # fmt: skip
    """All state of the variant's pipeline. Raises ShaderError when a file or an include is not there."""
    technique = effect.technique(request.role)
    features = effect.active(request.role, request.features)
    streams = [attribute.stream for attribute in request.attributes]
    defines: dict[str, str | int] = {**effect.defines(request.role, features, streams), **dict(request.defines)}
    prelude = request.prelude + effect.glsl(features)

    def stage(kind: str, file: str) -> ShaderSource:
        path = shader_file(file, search, texts or {})
        if not path.is_file() and path.resolve() not in (texts or {}):
            raise _missing(effect, request.role, kind, file, search)
        return flatten(path, kind, search=search, prelude=prelude, defines=defines, texts=texts)

    fragment = stage("fragment", MAGENTA if magenta else technique.fragment) if technique.fragment else None
    blend = request.blend if isinstance(request.blend, BlendState) else _blend(request.blend or technique.blend)
    return RenderPipelineDesc(
        label=f"{effect.name} {request.role} {'+'.join(sorted(features))}".rstrip(),
        vertex=stage("vertex", technique.vertex),
        fragment=fragment,
        attributes=request.attributes,
        topology=request.topology,
        depth=replace(
            technique.depth,
            write=technique.depth.write if request.depth_write is None else request.depth_write,
            compare=request.depth_compare or technique.depth.compare,
        ),
        blend=(blend,) * request.targets,
        raster=replace(
            technique.raster,
            cull=request.cull or technique.raster.cull,
            fill=request.fill or technique.raster.fill,
            front_ccw=request.front_ccw,
        ),
    )


def _missing(effect: Effect, role: str, kind: str, file: str, search: Sequence[Path]) -> ShaderError:
    """The technique names a file that is in none of the folders: the place is that of the name."""
    source = load_toml(effect.files[0])
    place = source.place(("technique", role, kind), value=True)
    known = [
        p.relative_to(folder).as_posix() for folder in search for p in sorted(folder.glob(f"*/*{Path(file).suffix}"))
    ]
    folders = ", ".join(map(str, search))
    message = with_caret(f"there is no shader {file!r} in {folders}", source.text, place)
    return ShaderError(message, where=place, hint=hint(file, known))


def _blend(name: str) -> BlendState | None:
    if name not in BLENDS:
        raise UsageError(f"unknown blend {name!r}", hint=hint(name, BLENDS))
    return BLENDS[name]


def absent_features(effect: Effect, role: str, wanted: frozenset[str], dropped: Mapping[str, str]) -> dict[str, str]:
    """Of every feature that is off in a variant: why."""
    active = effect.active(role, wanted)
    reasons = {}
    for name in (*effect.features, *BUILTIN_FEATURES):
        if name in dropped:
            reasons[name] = dropped[name]
        elif name not in active:
            reasons[name] = f"makes no difference in {role}" if name in wanted else "no material of the variant uses it"
    return reasons


def shader_file(name: str, search: Sequence[Path], texts: Mapping[Path, str] = MappingProxyType({})) -> Path:
    """`effects/surface.vert` in the search folders; the path in the last one when it is in none. A file in `texts`
    counts as there."""
    return _find(name, search, texts) or (Path(search[-1]) / name if search else Path(name))


def shadowing(files: Iterable[Path], search: Sequence[Path]) -> Iterator[Path]:
    """Paths that would be found before `files` if they were there."""
    for file in files:
        for i, folder in enumerate(search):
            if file.is_relative_to(folder):
                yield from (before / file.relative_to(folder) for before in search[:i])
                break


def _find(name: str, search: Sequence[Path], texts: Mapping[Path, str] = MappingProxyType({})) -> Path | None:
    """The file of that name: as it is, or in a search folder; None for generated text."""
    for path in (Path(name), *(Path(folder) / name for folder in search)):
        if path.is_file() or path.resolve() in texts:
            return path
    return None
