"""A variant: one effect in one role with one set of features, streams and state, compiled to a pipeline."""

from __future__ import annotations

import hashlib
import re
import time
from collections.abc import Iterable, Iterator, Mapping, MutableMapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import TypedDict

from engine.core.errors import ShaderError, UsageError
from engine.core.toml_source import KeyPath
from engine.gpu.preprocess import flatten
from engine.gpu.types import (
    BlendState,
    Caps,
    ComputePipelineDesc,
    Device,
    Pipeline,
    RenderPipelineDesc,
    ShaderSource,
    VertexAttribute,
)
from engine.materials.effect import BLENDS, BUILTIN_FEATURES, Effect
from engine.materials.requirements import AUTO
from engine.materials.suggest import hint
from engine.materials.technique import DrawPass

#: shown where a fragment shader does not compile
MAGENTA = "effects/magenta.frag"
#: and the vertex shader where an effect's own one does not either
PLAIN = "effects/surface.vert"

#: draws nothing: for an effect whose vertex shader does not compile either
_NOWHERE = ShaderSource("vertex", "void main()\n{\n    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);\n}\n")


class StateOptions(TypedDict, total=False):
    """State given with a request. None, or left out: as the technique says.

    `blend`: a BlendState or a blend name of effect files; `targets`: how many colour attachments (0: depth only).
    `cull` stands for `back` alone: what a technique draws of other faces stays.
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
    """What makes a variant what it is; the state as in StateOptions.

    `level`: that of the technique that is wanted; `index`: which of its passes. `blended`: what the technique writes as
    it is is laid over what is there, premultiplied; other blends stay. `clip`: what is behind the plane of
    gl_ClipDistance is cut away, where the vertex shader writes it and no stage comes between."""

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
    level: str = AUTO
    index: int = 0
    blended: bool = False
    clip: bool = False


@dataclass(slots=True, eq=False)
class Variant:
    """A cached variant. `pipeline` is the last good one; `error` says why the newest source has none.

    `features`: those that are on in this role; `reasons`: why; `absent`: feature -> why it is off. `asked`: someone
    asked for it since EffectLibrary.expect. `loaded`: its program was taken from the program cache. `level`,
    `level_reason`: which of the technique is drawn, and why.
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
    loaded: bool = False
    asked: bool = True
    level: str = ""
    level_reason: str = ""
    #: of a compute stage: the parameters that its text names
    reads: frozenset[str] = frozenset()

    @property
    def label(self) -> str:
        number = f" pass {self.request.index + 1}" if self.request.index else ""
        return f"{self.request.effect} {self.request.role}{number}"


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
    reads: frozenset[str] = frozenset()


#: what a variant's pipeline is made of
Description = RenderPipelineDesc | ComputePipelineDesc


@dataclass(frozen=True, slots=True)
class Begun:
    """What a variant is made of, when the driver already works on it, and the time that took so far."""

    device: Device
    desc: Description
    ms: float


def compile_variant(
    device: Device, effect: Effect, request: VariantRequest, search: Sequence[Path], *, magenta: str = "",
    texts: MutableMapping[Path, str] | None = None, ahead: Begun | None = None,
) -> Compiled:  # fmt: skip
    """Flatten and compile. `magenta`: `fragment` replaces that shader, `plain` all of them; `texts` as in `flatten`.

    Raises ShaderError with file:line:col."""
    begun = time.perf_counter() - (1e-3 * ahead.ms if ahead is not None else 0.0)
    if ahead is not None:
        desc = ahead.desc
    else:
        desc = describe(effect, request, search, magenta=magenta, texts=texts, caps=device.caps)
    stages = desc.stages
    digest = hashlib.sha256()
    for source in stages:
        digest.update(source.stage.encode("utf-8") + b"\0" + source.text.encode("utf-8") + b"\0")
    names = dict.fromkeys(file for stage in stages for file, _ in stage.lines)
    files = tuple(path for path in (_find(name, search) for name in names) if path is not None)
    reads: frozenset[str] = frozenset()
    pipeline: Pipeline
    if isinstance(desc, ComputePipelineDesc):
        pipeline, reads = device.compute_pipeline(desc), _params_read(effect, desc.compute)
    else:
        pipeline = device.render_pipeline(desc)
    return Compiled(pipeline, files, digest.hexdigest(), 1e3 * (time.perf_counter() - begun), reads)


def _params_read(effect: Effect, source: ShaderSource) -> frozenset[str]:
    """The parameters that stand as members in what the author wrote, switched off or not."""
    own = [
        line
        for line, (file, _) in zip(source.text.splitlines(), source.lines, strict=False)
        if not file.startswith("<")
    ]
    return frozenset(re.findall(r"\.\s*(\w+)", "\n".join(own))) & set(effect.param_by_name)


def compile_nowhere(device: Device, request: VariantRequest) -> Pipeline:
    """The pipeline that draws nothing."""
    return device.render_pipeline(
        RenderPipelineDesc(
            f"{request.effect} {request.role} nowhere", _NOWHERE, None, topology=request.topology, depth=None,
            blend=(None,) * request.targets,
        )
    )  # fmt: skip


def describe(
    effect: Effect, request: VariantRequest, search: Sequence[Path], *, magenta: str = "",
    texts: MutableMapping[Path, str] | None = None, caps: Caps | None = None,
) -> Description:  # fmt: skip
    """All state of the variant's pipeline on a device with these capabilities (None: one that can do all). Raises
    ShaderError when a file or an include is not there, or the device can do no level of the technique."""
    draw = draw_of(effect, request, caps)
    features = effect.active(request.role, request.features)
    streams = [attribute.stream for attribute in request.attributes]
    defines: dict[str, str | int] = {**effect.defines(request.role, features, streams), **draw.defines}
    defines |= dict(request.defines)
    prelude = request.prelude + (effect.computing_glsl() if draw.compute else effect.glsl(features))

    def stage(kind: str, file: str) -> ShaderSource:
        path = shader_file(file, search, texts or {})
        if not path.is_file() and path.resolve() not in (texts or {}):
            raise _missing(effect, draw.places.get(kind, ("technique", request.role)), file, search)
        return flatten(path, kind, search=search, prelude=prelude, defines=defines, texts=texts)

    files = draw.stages()
    if draw.compute:
        return ComputePipelineDesc(f"{effect.name} {request.role}", stage("compute", draw.compute))
    if magenta == "plain":  # the stages before may be what is wrong
        files = {"vertex": PLAIN, "fragment": MAGENTA} if draw.fragment else {"vertex": PLAIN}
    elif magenta and draw.fragment:
        files["fragment"] = MAGENTA
    sources = {kind: stage(kind, file) for kind, file in files.items()}
    patches = "tess_evaluation" in sources
    if patches and request.topology == "triangle_strip":
        at = draw.places["tess_evaluation"]
        message, place = effect.place_of(at, "a strip of triangles cannot be drawn as patches")
        raise ShaderError(message, where=place, hint="convert the mesh to triangles, or leave the tessellation out")
    return RenderPipelineDesc(
        label=f"{effect.name} {request.role} {'+'.join(sorted(features))}".rstrip(),
        vertex=sources["vertex"],
        fragment=sources.get("fragment"),
        tess_control=sources.get("tess_control"),
        tess_evaluation=sources.get("tess_evaluation"),
        geometry=sources.get("geometry"),
        patch_vertices=draw.patch_vertices if patches else 3,
        attributes=request.attributes,
        topology="patches" if patches else request.topology,
        depth=replace(
            draw.depth,
            write=draw.depth.write if request.depth_write is None else request.depth_write,
            compare=request.depth_compare or draw.depth.compare,
        ),
        stencil=draw.stencil,
        blend=tuple(_target_blend(draw, request, index) for index in range(request.targets)),
        blend_constant=draw.blend_constant,
        raster=replace(
            draw.raster,
            cull=request.cull if request.cull and draw.raster.cull == "back" else draw.raster.cull,
            fill=request.fill or draw.raster.fill,
            front_ccw=request.front_ccw == draw.raster.front_ccw,
            clip_distances=int(request.clip and _clips(sources)),
        ),
    )


def _clips(sources: Mapping[str, ShaderSource]) -> bool:
    """Whether the planes that the vertex shader writes reach the rasteriser."""
    return not {"tess_evaluation", "geometry"} & sources.keys() and "gl_ClipDistance" in sources["vertex"].text


def draw_of(effect: Effect, request: VariantRequest, caps: Caps | None = None) -> DrawPass:
    """The pass of the technique, at the level that the device gets. Raises ShaderError where it can do none."""
    technique, why = effect.technique(request.role).at(request.level, caps)
    if technique is None:
        message, place = effect.place_of(("technique", request.role), why)
        raise ShaderError(message, where=place, hint="add a level that requires less")
    return technique.passes[min(request.index, len(technique.passes) - 1)]


def _target_blend(draw: DrawPass, request: VariantRequest, index: int) -> BlendState | None:
    """How one colour target is blended: as the request says, else as the pass does."""
    own = draw.target(index)
    said = request.blend if request.blend is not None else own.blend
    if request.blended and said == "opaque":
        said = "premultiplied"
    blend = said if isinstance(said, BlendState) else _blend(said or "opaque")
    mask = own.write_mask or ""
    return blend if mask == "rgba" else replace(blend or BlendState(), write_mask=mask)


def _missing(effect: Effect, keypath: KeyPath, file: str, search: Sequence[Path]) -> ShaderError:
    """The technique names a file that is in none of the folders: the place is that of the name."""
    known = [
        p.relative_to(folder).as_posix() for folder in search for p in sorted(folder.glob(f"*/*{Path(file).suffix}"))
    ]
    folders = ", ".join(map(str, search))
    message, place = effect.place_of(keypath, f"there is no shader {file!r} in {folders}")
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
