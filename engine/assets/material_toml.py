"""`*.material.toml`: a material by hand or by import; edits keep the comments.

    schema = "lucarna.material/1"
    name = "steel"
    effect = "surface"
    [params]
    roughness = 0.3
    [textures.normal_map]
    path = "steel.normal.dds"

A material may come from another one: `parent = "steel.material.toml"` (material_parent.py). Then what is read is all of
it, and what is written only what is other. Colours may be written as "#rrggbb" (core/color_text.py).

`read_material` checks the shape of the file (pydantic) and places every complaint at its line; whether the effect has
such parameters and slots is for engine.materials to say.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, ValidationError, field_validator

from engine.assets.material import LEVELS, QUEUES, SAMPLING, MaterialAsset, TextureRef
from engine.assets.material_parent import SUFFIX, load_chain
from engine.assets.records import did_you_mean
from engine.core.atomic import write_text
from engine.core.color_text import parse_color
from engine.core.errors import FormatError, InputError, UsageError
from engine.core.toml_merge import Merged, has
from engine.core.toml_source import KeyPath, TomlSource, load_toml, parse_toml

SCHEMA = "lucarna.material/1"

#: what a texture's table may say
_FIELDS = tuple(name for name in TextureRef.__slots__ if name != "stated")

Wrap = Literal["repeat", "mirror", "clamp"]
Filter = Literal[
    "nearest", "linear", "nearest_mip_nearest", "linear_mip_nearest", "nearest_mip_linear", "linear_mip_linear"
]
Name = Annotated[str, Field(max_length=4096)]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)


class _Texture(_Strict):
    path: Name = ""
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
    parent: Name = ""
    effect: Name = "surface"
    level: Literal["", "low", "medium", "high"] = ""
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
    """Numbers, booleans, strings, colours, and arrays of numbers (as tuples)."""
    if isinstance(value, Mapping) or (isinstance(value, str) and value.startswith("#")):
        try:
            color = parse_color(name, value, 0 if isinstance(value, Mapping) else _parts(value))
        except UsageError as error:
            raise ValueError(f"{error.message}{f' ({error.hint})' if error.hint else ''}") from None
        return color
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
    return _material(load_toml(path), Path(path))


def parse_material(text: str, file: str) -> MaterialAsset:
    """The same from text; `file` names it in messages."""
    return _material(parse_toml(text, file), Path(file))


def _material(source: TomlSource, path: Path) -> MaterialAsset:
    chain = load_chain(source, path)
    data = dict(chain.data)
    if "parent" in data:
        data.setdefault("name", path.name.removesuffix(SUFFIX))
    try:
        model = _Material.model_validate(data)
    except ValidationError as error:
        raise _explain(chain, error) from None
    for slot, given in model.textures.items():
        if "path" not in given.model_fields_set:
            raise _at(chain, ("textures", slot), "the key 'path' is missing")
    textures = {}
    for slot, t in model.textures.items():
        textures[slot] = TextureRef(
            t.path, t.wrap_u, t.wrap_v, t.min_filter, t.mag_filter, t.uv_set,
            (t.offset[0], t.offset[1]), t.rotation, (t.scale[0], t.scale[1]),
            tuple(n for n in SAMPLING if n in t.model_fields_set and getattr(t, n) == _Texture.model_fields[n].default),
        )  # fmt: skip
    return MaterialAsset(
        model.name, model.effect, model.queue, model.features, model.params, textures, model.extensions, model.level,
        model.parent, chain.files, _origin(chain) if model.parent else {},
    )  # fmt: skip


def _origin(chain: Merged) -> dict[str, Path]:
    """Dotted key -> file, of all that a parent says and nothing below it does."""
    found: dict[str, Path] = {}
    keys: list[KeyPath] = [(key,) for key in chain.data if key not in ("params", "textures")]
    keys += [("params", name) for name in chain.data.get("params", {})]
    keys += [("textures", slot, key) for slot, said in chain.data.get("textures", {}).items() for key in said]
    for keypath in keys:
        for source, file in zip(chain.sources, chain.files, strict=True):
            if has(source.data, keypath):
                if file != chain.files[0]:
                    found[".".join(map(str, keypath))] = file
                break
    return found


def _at(chain: Merged, keypath: KeyPath, message: str, *, hint: str = "", value: bool = False) -> FormatError:
    """The error at that key, in the file that says it."""
    return chain.locate(keypath)[0].error(keypath, message, hint=hint, value=value)


def _explain(source: Merged, error: ValidationError) -> FormatError:
    """The first complaint of pydantic, at its line."""
    first = error.errors()[0]
    location = tuple(part for part in first["loc"] if part != "schema_")
    if first["type"] == "extra_forbidden":
        owner = _Texture if location[:1] == ("textures",) else _Material
        known = [field.alias or name for name, field in owner.model_fields.items()]
        return _at(source, location, f"unknown key {location[-1]!r}", hint=did_you_mean(str(location[-1]), known))
    if first["type"] == "missing":
        return _at(source, location, f"the key {location[-1]!r} is missing")
    if first["type"] == "model_type" and first["input"] is False:
        return _at(source, location, "false takes an inherited texture away; there is none", value=True)
    message = first["msg"].removeprefix("Value error, ")
    if message.startswith("Input should be"):
        message = f"{message.replace('Input should be', 'expected', 1)}, got {first['input']!r}"
    if location[:1] == ("params",) and len(location) == 1:
        location = ("params", re.split(r"[ :.]", message)[0])
    hint = ""
    words = QUEUES if location == ("queue",) else LEVELS if location == ("level",) else ()
    if first["type"] == "literal_error" and words and isinstance(first["input"], str):
        hint = did_you_mean(first["input"], words)
    return _at(source, location, message, hint=hint, value=True)


def _parts(text: str) -> int:
    """The numbers of a colour in hexadecimal digits."""
    return 4 if len(text) in (5, 9) else 3


def write_material(path: Path, material: MaterialAsset) -> None:
    """Write `material` atomically; the same material gives the same bytes. Raises FormatError, OutputError."""
    write_text(path, format_material(material, str(path)))


def format_material(material: MaterialAsset, file: str = "") -> str:
    """The text of a material file: defaults left out, keys in a fixed order. JSON nulls in extensions are dropped.

    With a parent only what is other than in that is written; without a `file` to find it from, everything is. Raises
    FormatError where the parent is not there or something cannot be stored."""
    base = _base_of(material, file) if material.parent and file else None
    lines = [f'schema = "{SCHEMA}"', f"name = {_value(material.name, file)}"]
    plain = MaterialAsset("") if base is None else base
    if base is not None:
        lines.append(f"parent = {_value(material.parent, file)}")
    if base is None or material.effect != base.effect:
        lines.append(f"effect = {_value(material.effect, file)}")
    if material.queue != plain.queue:
        lines.append(f"queue = {_value(material.queue, file)}")
    if material.level != plain.level:
        lines.append(f"level = {_value(material.level, file)}")
    if list(material.features) != list(plain.features):
        lines.append(f"features = {_value(list(material.features), file)}")
    own = {n: v for n, v in material.params.items() if n not in plain.params or not _equal(v, plain.params[n])}
    if own:
        lines += ["", "[params]"]
        lines += [f"{_key(name)} = {_value(value, file)}" for name, value in sorted(own.items())]
    gone = [slot for slot in plain.textures if slot not in material.textures]
    if gone:
        lines += ["", "[textures]", *(f"{_key(slot)} = false" for slot in sorted(gone))]
    for slot, texture in sorted(material.textures.items()):
        lines += _texture_lines(slot, texture, plain.textures.get(slot), file)
    if material.extensions:
        lines += ["", "[extensions]"]
        for name, value in sorted(material.extensions.items()):
            if value is not None:
                lines.append(f"{_key(name)} = {_value(value, file)}")
    text = "\n".join(lines) + "\n"
    parse_material(text, file)
    return text


def _base_of(material: MaterialAsset, file: str) -> MaterialAsset:
    """The parent of a material that is to be written as `file`, its paths relative to that. Raises FormatError."""
    text = f"parent = {_string(material.parent)}\n"
    return parse_material(text, file)


def _texture_lines(slot: str, texture: TextureRef, base: TextureRef | None, file: str) -> list[str]:
    """The table of a slot: what is other than in `base` (else than the defaults), or meant though it is not."""
    default = base or TextureRef(texture.path)
    names = [
        name
        for name in _FIELDS
        if getattr(texture, name) != getattr(default, name)
        or (name in texture.stated and (base is None or name not in base.stated))
    ]
    if base is None:
        names.insert(0, "path")
    elif not names:
        return []
    lines = [f"{name} = {_value(getattr(texture, name), file)}" for name in dict.fromkeys(names)]
    return ["", f"[textures.{_key(slot)}]", *lines]


def _equal(one: Any, other: Any) -> bool:
    """Whether two values would be written alike."""
    return type(one) is type(other) and one == other if isinstance(one, (bool, str)) else _plain(one) == _plain(other)


def _plain(value: Any) -> Any:
    value = value.tolist() if isinstance(value, (np.generic, np.ndarray)) else value
    return tuple(value) if isinstance(value, list) else value


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
