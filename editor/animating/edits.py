"""Edits of an animation file's text: comments, order and layout stay. Pure functions from text to text.

A place is a path of keys and numbers: ("tracks", 0, "blocks", 2, "start").
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

import tomlkit
from tomlkit.items import AoT, Array, InlineTable, Table

from engine.core.errors import InputError

Path = Sequence[str | int]

#: lists that are written as [[name]]
_TABLES = ("tracks", "layers", "transitions", "markers")


def put(text: str, *values: tuple[Path, Any]) -> str:
    """Set the value at each place; None takes it away. Raises InputError for a place that is not there."""
    document = tomlkit.parse(text)
    for path, value in values:
        holder = _holder(document, path)
        if value is None:
            if isinstance(path[-1], int) or path[-1] in holder:
                del holder[path[-1]]
        else:
            holder[path[-1]] = _item(value)
    return tomlkit.dumps(document)


def append(text: str, path: Path, value: Any) -> str:
    """Add `value` to the list at a place, which begins empty."""
    document = tomlkit.parse(text)
    holder = _holder(document, path)
    key = path[-1]
    if key not in holder:
        holder[key] = tomlkit.aot() if key in _TABLES and len(path) == 1 else tomlkit.array()
    items = holder[key]
    if isinstance(items, AoT):
        table = tomlkit.table()
        table.update({name: _item(part) for name, part in value.items() if part is not None})
        items.append(table)
    else:
        items.append(_item(value))
        if len(items) > 1:
            items.multiline(True)
    return tomlkit.dumps(document)


def remove(text: str, path: Path) -> str:
    """Take away what stands at a place."""
    return put(text, (path, None))


def move(text: str, path: Path, by: int) -> str:
    """Move an element of a list of tables up (-1) or down (1); beyond its ends nothing changes."""
    number = path[-1]
    document = tomlkit.parse(text)
    items = _holder(document, path)
    assert isinstance(number, int)
    if not 0 <= number + by < len(items):
        return text
    plain = [item.unwrap() for item in items]
    plain.insert(number + by, plain.pop(number))
    holder = _holder(document, path[:-1])
    if isinstance(items, AoT):
        fresh = tomlkit.aot()
        for item in plain:
            table = tomlkit.table()
            table.update({name: _item(value) for name, value in item.items()})
            fresh.append(table)
        holder[path[-2]] = fresh
    else:
        holder[path[-2]] = _item(plain)
    return tomlkit.dumps(document)


def rename(text: str, kind: str, old: str, new: str) -> str:
    """Give a clip, mask, state, param or blend (`kind`: the table's name) another key, everywhere it is used.

    Raises InputError where the new name is empty or taken."""
    document = tomlkit.parse(text)
    table = document.get(kind, {})
    if old not in table:
        raise InputError(f"there is no {kind.rstrip('s')} {old!r}")
    if not new or (new != old and new in table):
        raise InputError(f"{new!r} is no free name for a {kind.rstrip('s')}")
    kept = table[old]
    del table[old]
    table[new] = kept
    if kind == "clips" and not kept.get("source"):
        kept["source"] = old
    for where, key in _uses(document, kind):
        if where.get(key) == old:
            where[key] = new
    if kind == "params":
        for blend in document.get("blends", {}).values():
            names = blend["params"]
            for i, name in enumerate(names):
                if name == old:
                    names[i] = new
        for transition in document.get("transitions", []):
            conditions = transition.get("when", [])
            for i, condition in enumerate(conditions):
                conditions[i] = re.sub(rf"\b{re.escape(old)}\b", lambda _: new, condition, count=1)
    return tomlkit.dumps(document)


def free_name(wanted: str, taken: Sequence[str]) -> str:
    """`wanted`, or `wanted 2`, …"""
    name, count = wanted, 1
    while name in taken:
        count += 1
        name = f"{wanted} {count}"
    return name


def _uses(document: Any, kind: str) -> list[tuple[Any, str]]:
    """(table, key) of every place where a name of that kind may stand."""
    tracks, layers = document.get("tracks", []), document.get("layers", [])
    states = list(document.get("states", {}).values())
    if kind == "clips":
        samples = [s for b in document.get("blends", {}).values() for s in b.get("samples", [])]
        blocks = [b for t in tracks for b in t.get("blocks", [])]
        own = [(user, "clip") for user in (*states, *layers, *samples, *blocks)]
        return own + [(user, "reference") for user in (*layers, *tracks)]
    if kind == "masks":
        return [(user, "mask") for user in (*layers, *tracks)]
    if kind == "states":
        transitions = document.get("transitions", [])
        return [(t, "from") for t in transitions] + [(t, "to") for t in transitions] + [(document, "start")]
    if kind == "blends":
        return [(user, "blend") for user in (*states, *layers)]
    return [(layer, "weight") for layer in layers]


def _holder(document: Any, path: Path) -> Any:
    """The container of the last key; tables in between are made, list elements must be there."""
    at = document
    for i, key in enumerate(path[:-1]):
        if isinstance(key, int):
            if not 0 <= key < len(at):
                raise InputError(f"there is no {path[: i + 1]}")
            at = at[key]
        else:
            if key not in at:
                at[key] = tomlkit.inline_table() if isinstance(at, InlineTable) else tomlkit.table(is_super_table=False)
            at = at[key]
    last = path[-1]
    if isinstance(last, int) and not 0 <= last < len(at):
        raise InputError(f"there is no {tuple(path)}")
    return at


def _item(value: Any) -> Any:
    if isinstance(value, (Table, InlineTable, Array, AoT)):
        return value
    if isinstance(value, Mapping):
        table = tomlkit.inline_table()
        table.update({name: _item(part) for name, part in value.items() if part is not None})
        return table
    if isinstance(value, (list, tuple)):
        array = tomlkit.array()
        array.extend([_item(part) for part in value])
        return array
    if isinstance(value, float):
        return tomlkit.item(round(value, 9))
    return tomlkit.item(value)
