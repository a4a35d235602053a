"""`when = "clearcoat and clearcoat_roughness > 0.1"`: under which condition a parameter or texture matters.

    condition := term ("or" term)*         term := factor ("and" factor)*
    factor    := "not" factor | "(" condition ")" | name | name compare value
    compare   := == != < <= > >=           value := number | true | false | word (a choice of an enum)

A bare name holds when the feature is on, the texture is there, or the parameter is not 0 (false, black).
"""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from engine.core.errors import UsageError
from engine.materials.suggest import hint

_TOKEN = re.compile(r"\s*(?:(==|!=|<=|>=|<|>|\(|\))|([A-Za-z_][A-Za-z0-9_-]*)|([-+]?\d[\d.eE+-]*)|(\S))")
_COMPARES: dict[str, Callable[[Any, Any], bool]] = {
    "==": operator.eq, "!=": operator.ne, "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge,
}  # fmt: skip
MOST = 200  # tokens: more is no condition that anyone wrote

#: what a name stands for now -> whether it holds
Test = Callable[[Mapping[str, Any]], bool]


@dataclass(frozen=True, slots=True)
class Condition:
    """`holds(values)`: by the values of parameters, and True or False for features and textures."""

    text: str
    names: frozenset[str]
    _test: Test

    def holds(self, values: Mapping[str, Any]) -> bool:
        return self._test(values)


def parse_condition(
    text: str, known: Collection[str] | None = None, choices: Mapping[str, tuple[str, ...]] | None = None
) -> Condition:
    """Parse; `known`: the names that there are (None: any), `choices`: those of each enum. Raises UsageError."""
    parser = _Parser(text, known, choices or {})
    test = parser.condition()
    if parser.at < len(parser.tokens):
        raise parser.error(f"did not expect {parser.tokens[parser.at]!r}")
    return Condition(text, frozenset(parser.names), test)


@lru_cache(maxsize=1024)
def condition_of(text: str) -> Condition:
    """A condition that was checked when its effect was read."""
    return parse_condition(text)


class _Parser:
    def __init__(self, text: str, known: Collection[str] | None, choices: Mapping[str, tuple[str, ...]]) -> None:
        self.text, self.known, self.choices = text, known, choices
        self.tokens = [next(filter(None, found)) for found in _TOKEN.findall(text.strip())]
        self.at = 0
        self.names: set[str] = set()
        if len(self.tokens) > MOST:
            raise self.error(f"more than {MOST} words")

    def error(self, what: str) -> UsageError:
        return UsageError(f"condition {self.text!r}: {what}", hint='as "feature and param == value"')

    def take(self, *wanted: str) -> str:
        token = self.tokens[self.at] if self.at < len(self.tokens) else ""
        if token and (not wanted or token in wanted):
            self.at += 1
            return token
        return ""

    def condition(self) -> Test:
        tests = [self.term()]
        while self.take("or"):
            tests.append(self.term())
        return tests[0] if len(tests) == 1 else lambda values: any(test(values) for test in tests)

    def term(self) -> Test:
        tests = [self.factor()]
        while self.take("and"):
            tests.append(self.factor())
        return tests[0] if len(tests) == 1 else lambda values: all(test(values) for test in tests)

    def factor(self) -> Test:
        if self.take("not"):
            inner = self.factor()
            return lambda values: not inner(values)
        if self.take("("):
            inner = self.condition()
            if not self.take(")"):
                raise self.error("a bracket is not closed")
            return inner
        name = self.take()
        if not name or not (name[0].isalpha() or name[0] == "_") or name in ("and", "or"):
            raise self.error(f"expected a name, got {name!r}" if name else "expected a name at the end")
        if self.known is not None and name not in self.known:
            raise UsageError(f"condition {self.text!r}: there is no {name!r}", hint=hint(name, self.known))
        self.names.add(name)
        compare = self.take(*_COMPARES)
        if not compare:
            return lambda values: _is_on(values.get(name))
        value = self._value(name)
        test = _COMPARES[compare]
        return lambda values: _compare(test, values.get(name), value)

    def _value(self, name: str) -> float | bool | str:
        token = self.take()
        if not token:
            raise self.error("expected a value at the end")
        if token in ("true", "false"):
            return token == "true"
        try:
            return float(token)
        except ValueError:
            pass
        choices = self.choices.get(name)
        if self.known is not None and token not in (choices or ()):
            message = f"{token!r} is not a choice of {name}" if choices else f"{token!r} is no number, true or false"
            raise UsageError(f"condition {self.text!r}: {message}", hint=hint(token, choices) if choices else "")
        return token


def _is_on(value: Any) -> bool:
    return any(value) if isinstance(value, (tuple, list)) else bool(value)


def _compare(test: Callable[[Any, Any], bool], have: Any, wanted: float | bool | str) -> bool:
    """A comparison of what cannot be compared does not hold."""
    if isinstance(have, bool) != isinstance(wanted, bool) and not isinstance(have, str):
        have, wanted = float(bool(have)) if isinstance(have, bool) else have, float(wanted)
    try:
        return bool(test(have, wanted))
    except TypeError:
        return False
