"""What could stand at the cursor of an effect or material file: the keys of the table there, the values of a key.

The keys of effects are read off their schema (engine.materials.schema), so a key added there is offered here.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Annotated, Any, Literal, get_args, get_origin

from pydantic import BaseModel

from engine.assets.material import FILTERS, LEVELS, QUEUES, WRAPS
from engine.materials.effect import Effect

_HEADER = re.compile(r"^\s*\[+\s*([^\]\[]*?)\s*\]+")
_IN_HEADER = re.compile(r"^\s*\[+\s*((?:[\w-]+\.)*)([\w-]*)$")
_KEY = re.compile(r"^\s*([\w-]*)$")
_VALUE = re.compile(r'^\s*([\w-]+)\s*=\s*(?:\[(?:[^\]]*[",\s])?)?"?([\w.-]*)$')
_INLINE_KEY = re.compile(r"^\s*([\w-]+)\s*=\s*\{(?:.*,)?\s*([\w-]*)$")
_INLINE_VALUE = re.compile(r'^\s*([\w-]+)\s*=\s*\{(?:.*,)?\s*([\w-]+)\s*=\s*"?([\w.-]*)$')
_EFFECT = re.compile(r'^\s*effect\s*=\s*"([^"]*)"', re.MULTILINE)

#: of a material file, at the top and in a texture's table: key -> what it takes
MATERIAL_KEYS: dict[str, tuple[str, tuple[str, ...]]] = {
    "schema": ("", ("lucarna.material/1",)), "name": ("text", ()), "parent": ("file.material.toml", ()),
    "effect": ("effect", ()), "queue": ("", QUEUES), "features": ("features", ()), "level": ("", LEVELS),
}  # fmt: skip
TEXTURE_KEYS: dict[str, tuple[str, tuple[str, ...]]] = {
    "path": ("file.dds", ()), "wrap_u": ("", WRAPS), "wrap_v": ("", WRAPS), "min_filter": ("", FILTERS),
    "mag_filter": ("", ("nearest", "linear")), "uv_set": ("", ("0", "1")), "offset": ("[u, v]", ()),
    "rotation": ("radians", ()), "scale": ("[u, v]", ()),
}  # fmt: skip

#: (word, what stands beside it)
Word = tuple[str, str]


def toml_words(before: str, text: str, line: int, effects: Sequence[Effect]) -> tuple[str, list[Word]]:
    """(what is typed of it, words) at the end of `before` in line `line` (from 1) of the file `text`."""
    material = "lucarna.material" in text or (_EFFECT.search(text) is not None and "[technique" not in text)
    if "#" in before:
        return "", []
    path = _table_at(text, line)
    header = _IN_HEADER.match(before)
    if header:
        above = [part for part in header[1].split(".") if part]
        return header[2], _keys(above, material, text, effects, tables=True)
    inline_value = _INLINE_VALUE.match(before)
    if inline_value:
        return inline_value[3], _values([*path, inline_value[1]], inline_value[2], material, text, effects)
    inline_key = _INLINE_KEY.match(before)
    if inline_key:
        return inline_key[2], _keys([*path, inline_key[1]], material, text, effects)
    key = _KEY.match(before)
    if key:
        return key[1], _keys(path, material, text, effects)
    value = _VALUE.match(before)
    if value:
        return value[2], _values(path, value[1], material, text, effects)
    return "", []


def _table_at(text: str, line: int) -> list[str]:
    """The path of the table that line `line` is in."""
    for row in reversed(text.split("\n")[: max(line - 1, 0)]):
        header = _HEADER.match(row)
        if header:
            return [part.strip(" \"'") for part in header[1].split(".")]
    return []


def _effect_of(text: str, effects: Sequence[Effect]) -> Effect | None:
    named = _EFFECT.search(text)
    name = named[1] if named else "surface"
    return next((effect for effect in effects if effect.name == name), None)


def _keys(path: list[str], material: bool, text: str, effects: Sequence[Effect], *, tables: bool = False) -> list[Word]:
    if material:
        effect = _effect_of(text, effects)
        if not path:
            tops = [("params", "table"), ("textures", "table"), ("extensions", "table")]
            return tops if tables else [*((k, " | ".join(v[1][:5]) or v[0]) for k, v in MATERIAL_KEYS.items()), *tops]
        if path == ["params"] and effect is not None:
            return [(p.name, f"{p.type} {p.unit}".strip()) for p in effect.params]
        if path == ["textures"] and effect is not None:
            return [(slot.name, slot.space) for slot in effect.textures]
        if path[0] == "textures" and len(path) == 2:
            return [(k, " | ".join(v[1][:4]) or v[0]) for k, v in TEXTURE_KEYS.items()]
        return []
    model = _model_at(path)
    if model is None:
        return []
    found = []
    for name, field in model.model_fields.items():
        kind = _plain(field.annotation)
        inner = _plain(get_args(kind)[0]) if get_origin(kind) is list else kind
        is_table = get_origin(kind) is dict or _is_model(inner)
        if not tables or is_table:
            found.append((field.alias or name, _spelled(kind)))
    return found


def _values(path: list[str], key: str, material: bool, text: str, effects: Sequence[Effect]) -> list[Word]:
    if material:
        effect = _effect_of(text, effects)
        if key == "effect" and not path:
            return [(e.name, e.doc) for e in effects]
        if key == "features" and not path:
            return [(name, f.doc) for name, f in effect.features.items()] if effect is not None else []
        if path == ["params"] and effect is not None:
            param = effect.param_by_name.get(key)
            choices = () if param is None else ("true", "false") if param.type == "bool" else param.choices
            return [(choice, "") for choice in choices]
        known = (TEXTURE_KEYS if path[:1] == ["textures"] else MATERIAL_KEYS).get(key)
        return [(choice, "") for choice in known[1]] if known else []
    model = _model_at(path)
    field = (
        next((f for n, f in model.model_fields.items() if (f.alias or n) == key), None) if model is not None else None
    )
    if field is None:
        return []
    kind = _plain(field.annotation)
    if get_origin(kind) is list:
        kind = _plain(get_args(kind)[0])
    if get_origin(kind) is Literal:
        return [(str(choice), "") for choice in get_args(kind)]
    return [("true", ""), ("false", "")] if kind is bool else []


# --- the schema of effects as types ---


def _model_at(path: list[str]) -> type[BaseModel] | None:
    """The table at `path` of an effect file; None where there is none."""
    from engine.materials.schema import EffectModel

    at: Any = EffectModel
    for part in path:
        if _is_model(at):
            field = next((f for n, f in at.model_fields.items() if (f.alias or n) == part), None)
            if field is None:
                return None
            at = _plain(field.annotation)
        elif get_origin(at) is dict:
            at = _plain(get_args(at)[1])
        elif get_origin(at) is not list:
            return None
        if get_origin(at) is list:
            at = _plain(get_args(at)[0])
    return at if _is_model(at) else None


def _is_model(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, BaseModel)


def _plain(kind: Any) -> Any:
    """A type without Annotated; of alternatives the table, else the choice, else the first."""
    while get_origin(kind) is Annotated:
        kind = get_args(kind)[0]
    if isinstance(kind, type) or get_origin(kind) in (dict, list, tuple, Literal):
        return kind
    options = [_plain(option) for option in get_args(kind) if option is not type(None)]
    tables = [option for option in options if _is_model(option)]
    words = [option for option in options if get_origin(option) is Literal]
    return (tables or words or options or [str])[0]


def _spelled(kind: Any) -> str:
    """A type in a few words."""
    origin = get_origin(kind)
    if origin is Literal:
        return " | ".join(str(choice) for choice in get_args(kind)[:5])
    if origin is dict or _is_model(kind):
        return "table"
    if origin in (list, tuple):
        return "list"
    return {str: "text", bool: "true | false", int: "whole number", float: "number"}.get(kind, "")
