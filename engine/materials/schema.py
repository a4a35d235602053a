"""The schema of *.effect.toml. Every mistake is reported with its place, all of them at once.

name = "rock"                     as the file is called
extends = "surface"               what is not said here is as there, key by key (arrays as a whole); an inherited
                                  table goes by `false`, as in  technique.gbuffer = false
doc = "…"

[features.moss]                   macro MOSS, 0 or 1
doc; implied_by = "moss_map"      a texture that switches it on; needs = ["tangent"]  vertex streams

[params.wetness]                  a field of MaterialParams, a slider, a flag, a line of the docs
type = float int uint bool enum vec2 vec3 vec4 color3 color4
default, min, max, step, unit, doc
choices = ["a", "b"]              of an enum
space = "linear" | "srgb"         of a colour
group = "Weather"; order = 2.0    where it stands among the others
when = "moss and wetness > 0.5"   shown only then (condition.py)

[textures.moss_map]
space = "srgb" | "linear" | "normal"; default = "white" | "black" | "flat_normal"
doc, group, order, when; sampler = "soft"

[samplers.soft] and [states.marked]   state_schema.py has their words

[technique.forward]               forward, gbuffer, depth, shadow (roles.py), or what passes added later ask for
vertex, tess_control, tess_evaluation, geometry, fragment = "effects/rock.frag"
patch_vertices = 3                indices a patch, with tess_evaluation
defines = { SHELL = 3 }           macros of this technique, level or pass
states = ["marked"]; depth, stencil, blend, blend_constant, write_mask, raster, targets     state_schema.py
features = ["moss"]               those that make a difference in this role; left out: all
streams = ["uv0"]                 vertex streams that it reads where the mesh has them, beside those that the features
                                  of the standard surface need; macros HAS_UV0 …
level = "low"; requires = []      what this is, and what it needs of the device (requirements.py)

[technique.forward.levels.high]   keys of the technique that are other at that level
requires = ["tessellation"]

[[technique.forward.passes]]      several draws, in order; keys of the technique that are other in it, and
name = "outline"                  what `inspect` calls it

[technique.texture]               draws nothing: it computes textures where the material gives no file for their slots
compute = "effects/moss.comp"     glsl.py has what is generated for it; levels, passes, defines, features as above
outputs = { moss_map = "rgba8" }  texture slot -> format, all of one
size = [512, 512]                 powers of two
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Annotated, Any, Literal, get_args, get_origin

from pydantic import BaseModel, Field, ValidationError

from engine.assets.mesh import STREAMS
from engine.core.errors import LucarnaError, Place, ShaderError
from engine.core.param import Param
from engine.core.toml_merge import Merged
from engine.core.toml_source import KeyPath, dotted
from engine.materials.condition import parse_condition
from engine.materials.merge import effect_name
from engine.materials.requirements import REQUIREMENTS
from engine.materials.roles import MOST_TARGETS, PROCEDURAL, TARGETS, target_index
from engine.materials.state_schema import TAGS, SamplerModel, StateModel, Table
from engine.materials.suggest import hint

#: formats that are stored by a shader, and sampled with filters; what they hold is linear
OutputFormat = Literal["r8", "rg8", "rgba8", "r16f", "rg16f", "rgba16f", "r32f", "rgba32f"]
MOST_OUTPUTS = 8
Texels = Annotated[int, Field(ge=8, le=4096)]
#: what else than stages a technique that computes has no use for
_DRAWING = (
    "states",
    "depth",
    "stencil",
    "blend",
    "blend_constant",
    "write_mask",
    "raster",
    "targets",
    "patch_vertices",
)
Level = Literal["low", "medium", "high"]
Requirement = Literal[
    "hardware", "tessellation", "geometry", "compute", "block_compression", "anisotropy", "multisampling",
    "large_textures", "large_storage", "reversed_depth",
]  # fmt: skip
assert set(get_args(Requirement)) == set(REQUIREMENTS)

#: names become GLSL identifiers: these would not
RESERVED = frozenset(
    re.findall(
        r"\w+",
        """
        if else for while do switch case default return break continue discard struct const in out inout uniform buffer
        shared float int uint bool double void true false sampler texture sample flat smooth centroid patch layout
        precise invariant lowp mediump highp precision input output common partition active filter half fixed goto
        """,
    )
)
_NAME = re.compile(r"[a-z](?:_?[a-z0-9])*")
_MACRO = re.compile(r"[A-Z](?:_?[A-Z0-9])*")


class FeatureModel(Table):
    doc: str = ""
    implied_by: str = ""
    needs: list[str] = Field(default_factory=list)


class ParamModel(Table):
    type: Literal["float", "int", "uint", "bool", "enum", "vec2", "vec3", "vec4", "color3", "color4"]
    default: Any
    min: float = -math.inf
    max: float = math.inf
    step: float = 0.0
    unit: str = ""
    choices: list[str] = Field(default_factory=list)
    space: Literal["linear", "srgb"] = "linear"
    doc: str = ""
    group: str = ""
    order: float = 0.0
    when: str = ""

    def to_param(self, name: str) -> Param:
        """The parameter, with its default checked. Raises UsageError."""
        param = Param(
            name, self.type, self.default, self.min, self.max, self.step, self.unit, tuple(self.choices), self.space,
            self.doc, self.group, self.order, self.when,
        )  # fmt: skip
        return replace(param, default=param.check(self.default))


class TextureModel(Table):
    space: Literal["srgb", "linear", "normal"] = "linear"
    default: Literal["white", "black", "flat_normal"] = "white"
    doc: str = ""
    group: str = ""
    order: float = 0.0
    when: str = ""
    sampler: str = ""


class PassModel(StateModel):
    """One draw of a technique: shader files by stage, and state. What is left out is as in the technique."""

    name: str = ""
    vertex: str = ""
    tess_control: str = ""
    tess_evaluation: str = ""
    geometry: str = ""
    fragment: str = ""
    compute: str = ""
    patch_vertices: int = Field(3, ge=1, le=32)
    states: list[str] = Field(default_factory=list)
    defines: dict[str, int | bool | float] = Field(default_factory=dict)


class LevelModel(PassModel):
    """A technique at one level; what is left out is as in the technique."""

    requires: list[Requirement] = Field(default_factory=list)
    passes: list[PassModel] = Field(default_factory=list)
    size: list[Texels] = Field(default_factory=list, min_length=2, max_length=2)


class TechniqueModel(LevelModel):
    outputs: dict[str, OutputFormat] = Field(default_factory=dict)
    features: list[str] | None = None
    streams: list[str] = Field(default_factory=list)
    level: Level = "low"
    levels: dict[Level, LevelModel] = Field(default_factory=dict)


class EffectModel(Table):
    name: str
    doc: str = ""
    extends: str = ""
    features: dict[str, FeatureModel] = Field(default_factory=dict)
    params: dict[str, ParamModel] = Field(default_factory=dict)
    textures: dict[str, TextureModel] = Field(default_factory=dict)
    samplers: dict[str, SamplerModel] = Field(default_factory=dict)
    states: dict[str, StateModel] = Field(default_factory=dict)
    technique: dict[str, TechniqueModel] = Field(default_factory=dict)


#: a mistake: where, what, and whether the value (not the key) is to be pointed at
Mistake = tuple[KeyPath, str, bool]


def check(merged: Merged) -> EffectModel:
    """Return the checked model; else raise ShaderError with all mistakes, each with place, line and caret."""
    try:
        model = EffectModel.model_validate(merged.data)
    except ValidationError as error:
        mistakes = [_translate(merged.data, dict(item)) for item in error.errors()]
        mistakes += _without_vertex(merged.data)
    else:
        mistakes = list(_without_vertex(merged.data)) or list(_meaning(model, merged))
        if not mistakes:
            return model
    found = [merged.describe(path, message, value=value) for path, message, value in mistakes]
    found.sort(key=lambda item: (item[1].file, item[1].line, item[1].column))
    if len(found) == 1:
        place = found[0][1]
        raise ShaderError(found[0][0], where=Place(place.file, place.line, place.column))
    text = "".join(f"\n{p.file}:{p.line}:{p.column}: {message}" for message, p in found)
    raise ShaderError(f"{len(found)} mistakes{text}", where=merged.files[0])


def _translate(data: Mapping[str, Any], error: Mapping[str, Any]) -> Mistake:
    """A pydantic error in our words."""
    loc = tuple(part for part in error["loc"] if part not in TAGS)
    if loc[-1:] == ("[key]",):
        choices = re.findall(r"'([^']*)'", error["ctx"]["expected"])
        return loc[:-1], f"unknown {str(loc[-3])[:-1]} {loc[-2]!r} ({hint(str(loc[-2]), choices)})", False
    path: KeyPath = loc
    kind, given = error["type"], error["input"]
    where = f" in {dotted(path[:-1])}" if len(path) > 1 else ""
    if kind == "extra_forbidden":
        return path, f"unknown key {str(path[-1])!r}{where} ({hint(str(path[-1]), _known(path[:-1]))})", False
    if kind == "missing":
        return path, f"the key {str(path[-1])!r} is missing{where}", False
    name = dotted(path)
    if kind == "literal_error":
        choices = re.findall(r"'([^']*)'", error["ctx"]["expected"])
        advice = hint(given, choices) if isinstance(given, str) else f"there are: {', '.join(choices)}"
        return path, f"{name}: {given!r} is not a choice ({advice})", True
    if kind == "model_type":
        return path, f"{name}: expected a table, got {given!r}", True
    return path, f"{name}: {error['msg'].replace('Input should be', 'expected')}, got {given!r}", True


def _known(path: KeyPath) -> list[str]:
    """The keys that the table at `path` may have."""
    at: Any = EffectModel
    for part in path:
        at = _inside(at, part)
    return [field.alias or name for name, field in _plain(at).model_fields.items()]


def _inside(at: Any, part: str | int) -> Any:
    """What type stands under `part` of a value of type `at`."""
    at = _plain(at)
    if isinstance(at, type) and issubclass(at, BaseModel):
        fields = {field.alias or name: field for name, field in at.model_fields.items()}
        return fields[str(part)].annotation
    return get_args(at)[-1]


def _plain(at: Any) -> Any:
    """A type without Annotated, and the table among the alternatives of a union."""
    while get_origin(at) is Annotated:
        at = get_args(at)[0]
    if isinstance(at, type) or get_origin(at) in (dict, list, Literal):
        return at
    kinds = [_plain(kind) for kind in get_args(at)]
    tables = [kind for kind in kinds if isinstance(kind, type) and issubclass(kind, BaseModel)]
    return (tables or [kind for kind in kinds if kind is not type(None)])[0]


def _meaning(model: EffectModel, merged: Merged) -> Iterator[Mistake]:
    """What is well-formed but makes no sense."""
    stem = effect_name(merged.files[0])
    if model.name != stem:
        yield ("name",), f"the name {model.name!r} is not that of the file, {stem!r}", True
    yield from _names(model)
    for name, feature in model.features.items():
        path: KeyPath = ("features", name)
        if feature.implied_by and feature.implied_by not in model.textures:
            text = f"there is no texture {feature.implied_by!r} ({hint(feature.implied_by, model.textures)})"
            yield (*path, "implied_by"), text, True
        for index, stream in enumerate(feature.needs):
            if stream not in STREAMS:
                yield (*path, "needs", index), f"there is no vertex stream {stream!r} ({hint(stream, STREAMS)})", True
    for name, param in model.params.items():
        yield from _param(name, param)
    for name, texture in model.textures.items():
        if texture.sampler and texture.sampler not in model.samplers:
            text = f"there is no sampler group {texture.sampler!r} ({hint(texture.sampler, model.samplers)})"
            yield ("textures", name, "sampler"), text, True
    for name, sampler in model.samplers.items():
        try:
            sampler.to_desc()
        except LucarnaError as error:
            yield ("samplers", name, "border"), str(error), True
    yield from _conditions(model)
    for role, technique in model.technique.items():
        yield from _technique(role, technique, model)


def _conditions(model: EffectModel) -> Iterator[Mistake]:
    entries: list[tuple[str, str, str]] = [("params", name, p.when) for name, p in model.params.items()]
    entries += [("textures", name, t.when) for name, t in model.textures.items()]
    known = {*model.features, *model.params, *model.textures}
    choices = {name: tuple(p.choices) for name, p in model.params.items() if p.type == "enum"}
    for table, name, text in entries:
        if text:
            try:
                parse_condition(text, known, choices)
            except LucarnaError as error:
                yield (table, name, "when"), str(error), True


def _technique(role: str, technique: TechniqueModel, model: EffectModel) -> Iterator[Mistake]:
    """What is well-formed but makes no sense in a technique, its levels and its passes."""
    at: KeyPath = ("technique", role)
    layers: list[tuple[KeyPath, PassModel]] = [(at, technique)]
    layers += [((*at, "levels", name), level) for name, level in technique.levels.items()]
    if technique.level in technique.levels:
        text = f"the technique itself is the level {technique.level!r}; say its level, or leave this one out"
        yield (*at, "levels", technique.level), text, False
    for path, layer in list(layers):
        if isinstance(layer, LevelModel):
            layers += [((*path, "passes", index), draw) for index, draw in enumerate(layer.passes)]
    for index, name in enumerate(technique.features or ()):
        if name not in model.features:
            yield (*at, "features", index), f"there is no feature {name!r} ({hint(name, model.features)})", True
    for index, name in enumerate(technique.streams):
        if name not in STREAMS:
            yield (*at, "streams", index), f"there is no vertex stream {name!r} ({hint(name, STREAMS)})", True
    for path, layer in layers:
        yield from _layer(role, path, layer, model)
        yield from (_computing if role == PROCEDURAL else _drawing)(role, path, layer)
    if role == PROCEDURAL:
        yield from _outputs(at, technique, model)
        return
    from engine.materials.technique import build

    for made in build(role, technique, model, ()).levels.values():
        for draw in made.passes:
            if draw.tess_control and not draw.tess_evaluation:
                yield draw.places["tess_control"], "a tess_control stage needs a tess_evaluation stage", False
            if "patch_vertices" in draw.places and not draw.tess_evaluation:
                yield draw.places["patch_vertices"], "only a tess_evaluation stage draws patches", False
            if not draw.vertex:
                yield draw.places["vertex"], "every pass needs a vertex stage", True


def _without_vertex(data: Mapping[str, Any]) -> Iterator[Mistake]:
    """Techniques that draw and say no vertex stage."""
    tables = data.get("technique")
    for role, table in tables.items() if isinstance(tables, Mapping) else ():
        if isinstance(table, Mapping) and role != PROCEDURAL and "vertex" not in table:
            yield ("technique", role, "vertex"), f"the key 'vertex' is missing in technique.{role}", False


def _drawing(role: str, path: KeyPath, layer: PassModel) -> Iterator[Mistake]:
    """What only a technique that computes may say."""
    for word in ("compute", "outputs", "size"):
        if word in layer.model_fields_set:
            thing = "compute stage" if word == "compute" else word
            text = f"a technique draws in the role {role!r}, so it has no {thing} (that of {PROCEDURAL!r} computes)"
            yield (*path, word), text, False


def _computing(role: str, path: KeyPath, layer: PassModel) -> Iterator[Mistake]:
    """What only a technique that draws may say."""
    stages = ("vertex", "tess_control", "tess_evaluation", "geometry", "fragment")
    for word in (*stages, *_DRAWING, "streams"):
        if word in layer.model_fields_set:
            text = f"the technique of the role {role!r} computes textures and draws nothing, so it has no {word}"
            yield (*path, word), text, False
    for index, texels in enumerate(layer.size if isinstance(layer, LevelModel) else ()):
        if texels & (texels - 1):
            yield (*path, "size", index), f"{texels} is no power of two, so it has no whole mips", True


def _outputs(at: KeyPath, technique: TechniqueModel, model: EffectModel) -> Iterator[Mistake]:
    """What is computed: each level says where, how large, and by which shader."""
    from engine.materials.technique import build

    if not technique.outputs:
        yield (*at, "outputs"), f"the key 'outputs' is missing in {dotted(at)}: texture slot = format", False
    if len(technique.outputs) > MOST_OUTPUTS:
        yield (*at, "outputs"), f"{len(technique.outputs)} textures at once; {MOST_OUTPUTS} is the most", True
    for slot in technique.outputs:
        if slot not in model.textures:
            yield (*at, "outputs", slot), f"there is no texture {slot!r} ({hint(slot, model.textures)})", False
    for level in build(PROCEDURAL, technique, model, ()).levels.values():
        if level.size == (0, 0):
            yield (*at, "size"), f"the key 'size' is missing in {dotted(at)}: [width, height] in texels", False
        for draw in level.passes:
            if not draw.compute:
                place = draw.places.get("compute", (*at, "compute"))
                yield place, f"every pass of {dotted(at)} needs a compute stage", "compute" in draw.places
        if level.size == (0, 0) or not all(draw.compute for draw in level.passes):
            return


def _layer(role: str, path: KeyPath, layer: PassModel, model: EffectModel) -> Iterator[Mistake]:
    for index, name in enumerate(layer.states):
        if name not in model.states:
            yield (*path, "states", index), f"there is no state group {name!r} ({hint(name, model.states)})", True
    for name in layer.defines:
        if not _MACRO.fullmatch(name) or name.lower() in model.features:
            why = "is a feature of this effect" if name.lower() in model.features else "use capitals, digits, single _"
            yield (*path, "defines", name), f"{name!r} cannot be a macro here: {why}", False
    groups = [(path, layer), *((("states", name), model.states[name]) for name in layer.states if name in model.states)]
    for where, group in groups:
        for name in group.targets:
            if target_index(role, name) is None:
                yield (*where, "targets", name), _no_target(role, name), False


def _no_target(role: str, name: str) -> str:
    names = TARGETS.get(role)
    if names == ():
        return f"the role {role!r} has no colour targets, so none is {name!r}"
    known: Iterable[str] = names or [str(i) for i in range(MOST_TARGETS)]
    return f"the role {role!r} has no target {name!r} ({hint(name, known)})"


def _names(model: EffectModel) -> Iterator[Mistake]:
    fields = {f"{slot}_{part}" for slot in model.textures for part in ("layer", "uv", "row0", "row1")}
    tables: list[tuple[str, Mapping[str, object]]] = [
        ("features", model.features), ("params", model.params), ("textures", model.textures),
        ("technique", model.technique), ("samplers", model.samplers), ("states", model.states),
    ]  # fmt: skip
    for table, entries in tables:
        for name in entries:
            if not _NAME.fullmatch(name) or (name in RESERVED and table == "params") or name.startswith("gl_"):
                text = f"{name!r} cannot be a name in a shader (small letters, digits, single _; no GLSL word)"
                yield (table, name), text, False
            elif table == "params" and name in fields:
                yield (table, name), f"{name!r} is also a generated field of a texture slot; rename one", False


def _param(name: str, param: ParamModel) -> Iterator[Mistake]:
    path: KeyPath = ("params", name)
    if param.type == "enum" and not param.choices:
        yield path, f"{name!r} is an enum without choices", False
    elif param.type != "enum" and param.choices:
        yield (*path, "choices"), f"only an enum has choices; {name!r} is a {param.type}", False
    elif param.min > param.max:
        yield (*path, "min"), f"{name!r}: min {param.min:g} is above max {param.max:g}", True
    else:
        try:
            param.to_param(name)
        except LucarnaError as error:
            yield (*path, "default"), f"the default does not fit: {error}", True
