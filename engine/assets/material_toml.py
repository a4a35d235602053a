"""`*.material.toml`: a material by hand or by import; edits keep the comments.

    schema = "lucarna.material/1"
    name = "steel"
    effect = "surface"
    [params]
    roughness = 0.3
    [textures.normal_map]
    path = "steel.normal.dds"

`read_material` checks the shape of the file (pydantic) and places every complaint at its line; whether the effect has
such parameters and slots is for engine.materials to say.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, ValidationError, field_validator

from engine.assets.material import QUEUES, MaterialAsset, TextureRef
from engine.assets.records import did_you_mean
from engine.core.atomic import write_text
from engine.core.errors import FormatError, InputError
from engine.core.toml_source import TomlSource, load_toml, parse_toml

SCHEMA = "lucarna.material/1"

Wrap = Literal["repeat", "mirror", "clamp"]
Filter = Literal[
    "nearest", "linear", "nearest_mip_nearest", "linear_mip_nearest", "nearest_mip_linear", "linear_mip_linear"
]
Name = Annotated[str, Field(max_length=4096)]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)


class _Texture(_Strict):
    path: Name
    wrap_u: Wrap = "repeat"
    wrap_v: Wrap = "repeat"
    min_filter: Filter = "linear_mip_linear"
    mag_filter: Literal["nearest", "linear"] = "linear"
    uv_set: int = Field(0, ge=0, le=1)
    offset: list[FiniteFloat] = Field([0.0, 0.0], min_length=2, max_length=2)
    rotation: FiniteFloat = 0.0
    scale: list[FiniteFloat] = Field([1.0, 1.0], min_length=2, max_length=2)


class _Material(_Strict):
    schema_: Literal["lucarna.material/1"] = Field("lucarna.material/1", alias="schema")
    name: Name
    effect: Name = "surface"
    queue: Literal["background", "opaque", "alpha_test", "transparent", "overlay"] = "opaque"
    features: list[Name] = []
    params: dict[str, Any] = {}
    textures: dict[str, _Texture] = {}
    extensions: dict[str, Any] = {}

    @field_validator("params")
    @classmethod
    def _params(cls, value: dict[str, Any]) -> dict[str, Any]:
        return {name: _param(name, item) for name, item in value.items()}


def _param(name: str, value: Any) -> Any:
    """Numbers, booleans, strings, and arrays of numbers (as tuples)."""
    parts = value if isinstance(value, list) else [value]
    for part in parts:
        if not isinstance(part, (bool, int, float, str)) or (isinstance(value, list) and isinstance(part, (bool, str))):
            raise ValueError(f"{name} is no number, boolean, string or array of numbers")
        if isinstance(part, float) and not math.isfinite(part):
            raise ValueError(f"{name} is not finite")
    return tuple(value) if isinstance(value, list) else value


def read_material(path: Path) -> MaterialAsset:
    """Read and check a material file.

    Raises InputError when it cannot be read, FormatError with file:line:column, the line and a caret.
    """
    return _material(load_toml(path))


def parse_material(text: str, file: str) -> MaterialAsset:
    """The same from text; `file` names it in messages."""
    return _material(parse_toml(text, file))


def _material(source: TomlSource) -> MaterialAsset:
    try:
        model = _Material.model_validate(source.data)
    except ValidationError as error:
        raise _explain(source, error) from None
    textures = {}
    for slot, t in model.textures.items():
        textures[slot] = TextureRef(
            t.path, t.wrap_u, t.wrap_v, t.min_filter, t.mag_filter, t.uv_set,
            (t.offset[0], t.offset[1]), t.rotation, (t.scale[0], t.scale[1]),
        )  # fmt: skip
    return MaterialAsset(
        model.name, model.effect, model.queue, model.features, model.params, textures, model.extensions
    )


def _explain(source: TomlSource, error: ValidationError) -> FormatError:
    """The first complaint of pydantic, at its line."""
    first = error.errors()[0]
    location = tuple(part for part in first["loc"] if part != "schema_")
    if first["type"] == "extra_forbidden":
        owner = _Texture if location[:1] == ("textures",) else _Material
        known = [field.alias or name for name, field in owner.model_fields.items()]
        return source.error(location, f"unknown key {location[-1]!r}", hint=did_you_mean(str(location[-1]), known))
    if first["type"] == "missing":
        return source.error(location, f"the key {location[-1]!r} is missing")
    message = first["msg"].removeprefix("Value error, ")
    if location[:1] == ("params",) and len(location) == 1:
        location = ("params", message.split(" ")[0])
    hint = ""
    if first["type"] == "literal_error" and location == ("queue",) and isinstance(first["input"], str):
        hint = did_you_mean(first["input"], QUEUES)
    return source.error(location, message, hint=hint, value=True)


def write_material(path: Path, material: MaterialAsset) -> None:
    """Write `material` atomically; the same material gives the same bytes. Raises FormatError, OutputError."""
    write_text(path, format_material(material, str(path)))


def format_material(material: MaterialAsset, file: str = "") -> str:
    """The text of a material file: defaults left out, keys in a fixed order. JSON nulls in extensions are dropped."""
    lines = [f'schema = "{SCHEMA}"', f"name = {_value(material.name, file)}"]
    lines.append(f"effect = {_value(material.effect, file)}")
    if material.queue != "opaque":
        lines.append(f"queue = {_value(material.queue, file)}")
    if material.features:
        lines.append(f"features = {_value(list(material.features), file)}")
    if material.params:
        lines += ["", "[params]"]
        lines += [f"{_key(name)} = {_value(value, file)}" for name, value in sorted(material.params.items())]
    for slot, texture in sorted(material.textures.items()):
        lines += ["", f"[textures.{_key(slot)}]", f"path = {_value(texture.path, file)}"]
        default = TextureRef(texture.path)
        for name in TextureRef.__slots__[1:]:
            value = getattr(texture, name)
            if value != getattr(default, name):
                lines.append(f"{name} = {_value(value, file)}")
    if material.extensions:
        lines += ["", "[extensions]"]
        for name, value in sorted(material.extensions.items()):
            if value is not None:
                lines.append(f"{_key(name)} = {_value(value, file)}")
    text = "\n".join(lines) + "\n"
    parse_material(text, file)
    return text


def update_material(path: Path, changes: Mapping[str, Any]) -> MaterialAsset:
    """Set values in a material file and leave everything else, comments too, as it stands.

    `changes`: dotted key -> value, as `{"params.roughness": 0.4, "textures.normal_map.scale": (2.0, 2.0)}`; None
    removes the key. The result is checked before it is written, atomically. Returns the new material.
    Raises InputError, FormatError, OutputError; the file is then untouched.
    """
    import tomlkit  # here: only edits need it, and it is slow to import
    from tomlkit.exceptions import TOMLKitError

    source = load_toml(path)
    try:
        document = tomlkit.parse(source.text)
        for dotted_key, value in changes.items():
            *tables, key = dotted_key.split(".")
            table: Any = document
            for name in tables:
                if name not in table:
                    if value is None:
                        break
                    # super tables such as [textures] need no header of their own
                    table[name] = tomlkit.table(is_super_table=table is document and name == "textures")
                table = table[name]
            else:
                if value is None:
                    table.pop(key, None)
                else:
                    table[key] = tomlkit.value(_value(value, str(path)))
    except (TOMLKitError, TypeError, AttributeError, ValueError) as error:
        raise InputError(f"cannot change it: {error}", where=path, hint="keys are like 'params.roughness'") from error
    text = tomlkit.dumps(document)
    material = parse_material(text, str(path))
    write_text(path, text)
    return material


def _key(name: str) -> str:
    bare = bool(name) and all(c.isascii() and (c.isalnum() or c in "_-") for c in name)
    return name if bare else _string(name)


def _string(text: str) -> str:
    # JSON's escapes are TOML's, except that TOML wants DEL escaped and knows no lone surrogates
    return json.dumps(text.encode("utf-8", "replace").decode("utf-8"), ensure_ascii=False).replace("\x7f", "\\u007f")


def _value(value: Any, file: str) -> str:
    if isinstance(value, (np.generic, np.ndarray)):
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return _string(value)
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        if not math.isfinite(value):
            raise FormatError(f"{value} is not a finite number", where=file)
        return repr(value)
    if isinstance(value, Mapping):
        pairs = (f"{_key(str(k))} = {_value(v, file)}" for k, v in sorted(value.items()) if v is not None)
        return "{ " + ", ".join(pairs) + " }" if value else "{}"
    if isinstance(value, Sequence):
        return "[" + ", ".join(_value(v, file) for v in value if v is not None) + "]"
    raise FormatError(f"{type(value).__name__} cannot be stored in a material", where=file)
