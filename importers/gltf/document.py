"""Typed access to the JSON tree: a wrong type or range becomes a finding and a default, never a crash."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from engine.core.findings import Findings
from importers.gltf.uris import storable_text

JsonObject = dict[str, Any]


def _kind(value: object) -> str:
    if isinstance(value, bool):
        return "a boolean"
    if value is None:
        return "null"
    names = {dict: "an object", list: "an array", str: "a string", int: "a number", float: "a number"}
    return names.get(type(value), "a value")


def _at(path: str, key: str) -> str:
    return f"{path}.{key}" if path else key


class Document:
    """The root object and the findings. All getters take the json path of the object they read, for messages."""

    def __init__(self, root: JsonObject, findings: Findings) -> None:
        self.root = root
        self.findings = findings
        self._lists: dict[str, list[JsonObject]] = {}

    def objects(self, name: str) -> list[JsonObject]:
        """The top-level array `name`; entries that are no objects become empty ones, so that indices keep."""
        if name not in self._lists:
            self._lists[name] = self.child_objects(self.root, name, "")
        return self._lists[name]

    def child_objects(self, owner: JsonObject, key: str, path: str) -> list[JsonObject]:
        """`owner[key]` as a list of objects, with an empty one for every entry of a wrong type."""
        where = _at(path, key)
        result: list[JsonObject] = []
        for i, item in enumerate(self.array(owner, key, path)):
            if not isinstance(item, dict):
                self._wrong(f"{where}[{i}]", "an object", item)
                item = {}
            result.append(item)
        return result

    def array(self, owner: JsonObject, key: str, path: str) -> list[Any]:
        value = owner.get(key)
        if value is None:
            return []
        if not isinstance(value, list):
            self._wrong(_at(path, key), "an array", value)
            return []
        return value

    def child(self, owner: JsonObject, key: str, path: str) -> JsonObject:
        """`owner[key]` as an object; {} where it is missing or of a wrong type."""
        value = owner.get(key)
        if value is None:
            return {}
        if not isinstance(value, dict):
            self._wrong(_at(path, key), "an object", value)
            return {}
        return value

    def extension(self, owner: JsonObject, name: str, path: str) -> JsonObject | None:
        """The extension object `name` of `owner`, or None where it has none."""
        extensions = self.child(owner, "extensions", path)
        if name not in extensions:
            return None
        return self.child(extensions, name, _at(path, "extensions"))

    def text(self, owner: JsonObject, key: str, path: str, default: str = "") -> str:
        value = owner.get(key)
        if value is None:
            return default
        if not isinstance(value, str):
            self._wrong(_at(path, key), "a string", value)
            return default
        return storable_text(value)

    def name(self, owner: JsonObject, path: str, fallback: str) -> str:
        """The object's name, cut to what files can carry; `fallback` where it has none."""
        return self.text(owner, "name", path)[:200] or fallback

    def choice(self, owner: JsonObject, key: str, path: str, choices: Sequence[str], default: str) -> str:
        value = self.text(owner, key, path, default)
        if value not in choices:
            self.findings.error("gltf.value", f"{value!r} is none of {', '.join(choices)}", _at(path, key))
            return default
        return value

    def flag(self, owner: JsonObject, key: str, path: str) -> bool:
        value = owner.get(key, False)
        if not isinstance(value, bool):
            self._wrong(_at(path, key), "true or false", value)
            return False
        return value

    def number(
        self, owner: JsonObject, key: str, path: str, default: float,
        low: float = -math.inf, high: float = math.inf,
    ) -> float:  # fmt: skip
        """A finite number, clamped to [low, high] with a finding where it lies outside."""
        value = owner.get(key)
        if value is None:
            return default
        checked = self._finite(value, _at(path, key))
        if checked is None:
            return default
        if not low <= checked <= high:
            clamped = min(max(checked, low), high)
            self.findings.warn(
                "gltf.range", f"{checked:g} is outside [{low:g}, {high:g}]; taken as {clamped:g}", _at(path, key)
            )
            return clamped
        return checked

    def integer(self, owner: JsonObject, key: str, path: str, default: int | None = None) -> int | None:
        """A whole number as it stands (any sign), or the default where missing or wrong."""
        value = owner.get(key)
        if value is None:
            return default
        if isinstance(value, float) and value.is_integer():
            value = int(value)
        if isinstance(value, bool) or not isinstance(value, int):
            self._wrong(_at(path, key), "a whole number", value)
            return default
        return value

    def index(self, owner: JsonObject, key: str, path: str, target: str) -> int | None:
        """An index into the top-level array `target`; None (with a finding) where it points outside."""
        value = self.integer(owner, key, path)
        return None if value is None else self.checked_index(value, _at(path, key), target)

    def indices(self, owner: JsonObject, key: str, path: str, target: str) -> list[int]:
        """The valid ones of an array of indices into `target`; each invalid one is a finding."""
        result = []
        for i, item in enumerate(self.array(owner, key, path)):
            where = f"{path}.{key}[{i}]"
            if isinstance(item, bool) or not isinstance(item, int):
                self._wrong(where, "an index", item)
            elif self.checked_index(item, where, target) is not None:
                result.append(item)
        return result

    def checked_index(self, value: int, where: str, target: str) -> int | None:
        count = len(self.objects(target))
        if 0 <= value < count:
            return value
        self.findings.error(
            "gltf.index", f"{target}[{value}] does not exist; the file has {count} {target}", where,
            "repair the index or export the file again",
        )  # fmt: skip
        return None

    def vector(self, owner: JsonObject, key: str, path: str, default: Sequence[float]) -> tuple[float, ...]:
        """`len(default)` finite numbers; the default (with a finding) where the array is anything else."""
        value = owner.get(key)
        if value is None:
            return tuple(default)
        where = _at(path, key)
        if not isinstance(value, list) or len(value) != len(default):
            given = f"{len(value)} numbers" if isinstance(value, list) else _kind(value)
            self.findings.error("gltf.type", f"expected {len(default)} numbers, found {given}", where)
            return tuple(default)
        parts = [self._finite(v, f"{where}[{i}]") for i, v in enumerate(value)]
        if any(p is None for p in parts):
            return tuple(default)
        return tuple(p for p in parts if p is not None)

    def _finite(self, value: object, where: str) -> float | None:
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            self._wrong(where, "a number", value)
            return None
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        # 3e38 is where float32, which the GPU and the arrays use, ends
        if not math.isfinite(number) or abs(number) > 3.0e38:
            self.findings.error("gltf.not-finite", f"{number} is not a finite number", where, "export the file again")
            return None
        return number

    def _wrong(self, where: str, expected: str, value: object) -> None:
        self.findings.error("gltf.type", f"expected {expected}, found {_kind(value)}", where, "export the file again")
