"""The schema of *.effect.toml. Every mistake is reported with its place, all of them at once."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from typing import Any, Literal, get_args

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from engine.assets.mesh import STREAMS
from engine.core.errors import LucarnaError, Place, ShaderError
from engine.core.param import Param
from engine.core.toml_source import KeyPath, dotted
from engine.materials.merge import Merged, effect_name
from engine.materials.suggest import hint

Compare = Literal["never", "less", "equal", "lequal", "greater", "notequal", "gequal", "always"]

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


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class FeatureModel(_Table):
    doc: str = ""
    implied_by: str = ""
    needs: list[str] = Field(default_factory=list)


class ParamModel(_Table):
    type: Literal["float", "int", "uint", "bool", "enum", "vec2", "vec3", "vec4", "color3", "color4"]
    default: Any
    min: float = -math.inf
    max: float = math.inf
    step: float = 0.0
    unit: str = ""
    choices: list[str] = Field(default_factory=list)
    space: Literal["linear", "srgb"] = "linear"
    doc: str = ""

    def to_param(self, name: str) -> Param:
        """The parameter, with its default checked. Raises UsageError."""
        param = Param(
            name, self.type, self.default, self.min, self.max, self.step, self.unit, tuple(self.choices), self.space,
            self.doc,
        )  # fmt: skip
        value = param.check(self.default)
        return Param(
            name, self.type, value, self.min, self.max, self.step, self.unit, tuple(self.choices), self.space, self.doc
        )


class TextureModel(_Table):
    space: Literal["srgb", "linear", "normal"] = "linear"
    default: Literal["white", "black", "flat_normal"] = "white"
    doc: str = ""


class DepthModel(_Table):
    test: bool = True
    write: bool = True
    compare: Compare = "gequal"
    bias: float = 0.0
    bias_slope: float = 0.0


class RasterModel(_Table):
    cull: Literal["none", "back", "front"] = "back"
    fill: Literal["solid", "wireframe"] = "solid"
    depth_clamp: bool = False


class TechniqueModel(_Table):
    vertex: str
    fragment: str = ""
    level: Literal["low", "medium", "high"] = "low"
    depth: DepthModel = DepthModel()
    raster: RasterModel = RasterModel()
    blend: Literal["opaque", "alpha", "premultiplied", "additive", "multiply"] = "opaque"
    features: list[str] | None = None


class EffectModel(_Table):
    name: str
    doc: str = ""
    extends: str = ""
    features: dict[str, FeatureModel] = Field(default_factory=dict)
    params: dict[str, ParamModel] = Field(default_factory=dict)
    textures: dict[str, TextureModel] = Field(default_factory=dict)
    technique: dict[str, TechniqueModel] = Field(default_factory=dict)


#: a mistake: where, what, and whether the value (not the key) is to be pointed at
Mistake = tuple[KeyPath, str, bool]


def check(merged: Merged) -> EffectModel:
    """Return the checked model; else raise ShaderError with all mistakes, each with place, line and caret."""
    try:
        model = EffectModel.model_validate(merged.data)
    except ValidationError as error:
        mistakes = [_translate(merged.data, dict(item)) for item in error.errors()]
    else:
        mistakes = list(_meaning(model, merged))
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
    path: KeyPath = tuple(error["loc"])
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
        at = (
            at.model_fields[str(part)].annotation
            if isinstance(at, type) and issubclass(at, BaseModel)
            else get_args(at)[1]
        )
    return list(at.model_fields)


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
    for role, technique in model.technique.items():
        for index, feature_name in enumerate(technique.features or ()):
            if feature_name not in model.features:
                text = f"there is no feature {feature_name!r} ({hint(feature_name, model.features)})"
                yield ("technique", role, "features", index), text, True


def _names(model: EffectModel) -> Iterator[Mistake]:
    fields = {f"{slot}_{part}" for slot in model.textures for part in ("layer", "uv", "row0", "row1")}
    tables: list[tuple[str, Mapping[str, object]]] = [
        ("features", model.features), ("params", model.params), ("textures", model.textures),
        ("technique", model.technique),
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
