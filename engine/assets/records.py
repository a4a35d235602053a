"""Dataclasses from and to JSON objects: unknown keys are errors with a suggestion, defaults are left out on writing.

A `Record` knows one dataclass and how to check each of its fields; checks raise `Bad`, which gathers the path to the
value on its way up (`nodes[3].camera.yfov`).
"""

from __future__ import annotations

import dataclasses
import difflib
import math
from collections.abc import Callable, Collection, Mapping
from typing import Any, Generic, TypeVar

T = TypeVar("T")
Check = Callable[[Any], Any]


class Bad(Exception):
    """A value that a check refuses; `path` leads to it from the record it was found in."""

    def __init__(self, message: str, path: str = "", hint: str = "") -> None:
        super().__init__(message)
        self.message, self.path, self.hint = message, path, hint

    def under(self, path: str) -> Bad:
        """The same, seen from one level up."""
        joined = path + self.path if self.path.startswith("[") or not self.path else f"{path}.{self.path}"
        return Bad(self.message, joined, self.hint)


class Record(Generic[T]):
    """Reads and writes `cls`; `checks` has one check per field, and fields without a default are required.

    `nested` names the fields that hold records themselves (or None, or a list of them).
    """

    def __init__(
        self, cls: type[T], checks: Mapping[str, Check], nested: Mapping[str, Record[Any]] | None = None
    ) -> None:
        self.cls, self.checks, self.nested = cls, dict(checks), dict(nested or {})
        fields = dataclasses.fields(cls)  # type: ignore[arg-type]  # T is always a dataclass here
        assert {f.name for f in fields} == set(checks), f"{cls.__name__}: checks and fields differ"
        self.required = [f.name for f in fields if _default(f) is dataclasses.MISSING]
        self.defaults = {f.name: _default(f) for f in sorted(fields, key=lambda f: f.name)}

    def read(self, data: Any) -> T:
        if not isinstance(data, dict):
            raise Bad(f"is {kind_name(data)}, expected an object")
        values = {}
        for key, value in data.items():
            check = self.checks.get(key)
            if check is None:
                raise Bad("unknown key", key, did_you_mean(key, self.checks))
            try:
                values[key] = check(value)
            except Bad as bad:
                raise bad.under(key) from None
        for key in self.required:
            if key not in values:
                raise Bad(f"the key {key!r} is missing")
        return self.cls(**values)

    def write(self, value: T) -> dict[str, Any]:
        """A JSON object with sorted keys, without the fields that have their default value.

        Every value passes its check, so what is written can be read, and equal values give equal text.
        """
        data = {}
        for name, default in self.defaults.items():
            item = getattr(value, name)
            if default is dataclasses.MISSING or item != default:
                try:
                    record = self.nested.get(name)
                    if record is None:
                        data[name] = self.checks[name](plain_lists(item))
                    else:
                        data[name] = [record.write(i) for i in item] if isinstance(item, list) else record.write(item)
                except Bad as bad:
                    raise bad.under(name) from None
        return data


def plain_lists(value: Any) -> Any:
    """Tuples as lists and numpy values as Python's own, at any depth, as JSON would give them back."""
    if isinstance(value, (list, tuple)):
        return [plain_lists(v) for v in value]
    if isinstance(value, dict):
        return {k: plain_lists(v) for k, v in value.items()}
    return value.tolist() if hasattr(value, "tolist") else value


def _default(field: dataclasses.Field[Any]) -> Any:
    if field.default_factory is not dataclasses.MISSING:
        return field.default_factory()
    return field.default


def did_you_mean(name: str, known: Collection[str]) -> str:
    """A hint for an unknown name."""
    near = difflib.get_close_matches(name, known, 1)
    return f"did you mean {near[0]!r}?" if near else f"known: {', '.join(sorted(known))}"


def kind_name(value: Any) -> str:
    names = {dict: "an object", list: "an array", str: "a string", bool: "a boolean", type(None): "null"}
    return names.get(type(value), "a number")


def string(value: Any) -> str:
    if type(value) is not str:
        raise Bad(f"is {kind_name(value)}, expected a string")
    return value


def boolean(value: Any) -> bool:
    if type(value) is not bool:
        raise Bad(f"is {kind_name(value)}, expected true or false")
    return value


def integer(low: int, high: int = 2**31 - 1) -> Check:
    def check(value: Any) -> int:
        if type(value) is not int or not low <= value <= high:
            raise Bad(f"{value!r} is not a whole number in {low}..{high}")
        return value

    return check


def number(low: float = -math.inf, high: float = math.inf, *, above: bool = False) -> Check:
    """A finite number in [low, high], or in (low, high] with `above`."""

    def check(value: Any) -> float:
        if type(value) is not float and type(value) is not int:
            raise Bad(f"is {kind_name(value)}, expected a number")
        try:
            result = float(value)
        except OverflowError:
            result = math.inf
        if not math.isfinite(result):
            raise Bad("is not a finite number", hint="give a number in its place")
        if not low <= result <= high or (above and result == low):
            raise Bad(f"{result:g} is outside {'(' if above else '['}{low:g}, {high:g}]")
        return result

    return check


def vector(count: int, item: Check | None = None) -> Check:
    """`count` numbers as a tuple."""
    each = item or number()

    def check(value: Any) -> tuple[float, ...]:
        if type(value) is not list or len(value) != count:
            got = f"an array of {len(value)}" if type(value) is list else kind_name(value)
            raise Bad(f"is {got}, expected an array of {count} numbers")
        return tuple(items(each)(value))

    return check


def items(item: Check) -> Check:
    """An array whose every element passes `item`."""

    def check(value: Any) -> list[Any]:
        if type(value) is not list:
            raise Bad(f"is {kind_name(value)}, expected an array")
        result = []
        for index, element in enumerate(value):
            try:
                result.append(item(element))
            except Bad as bad:
                raise bad.under(f"[{index}]") from None
        return result

    return check


def choice(*names: str) -> Check:
    def check(value: Any) -> str:
        if value not in names:
            hint = did_you_mean(value, names) if isinstance(value, str) else f"choose one of {', '.join(names)}"
            raise Bad(f"{value!r} is not a choice", hint=hint)
        return str(value)

    return check


def optional(item: Check) -> Check:
    return lambda value: None if value is None else item(value)


def mapping(value: Any) -> dict[str, Any]:
    if type(value) is not dict:
        raise Bad(f"is {kind_name(value)}, expected an object")
    return value


def string_map(value: Any) -> dict[str, str]:
    for key, item in mapping(value).items():
        if type(item) is not str:
            raise Bad(f"is {kind_name(item)}, expected a string", key)
    return dict(value)
