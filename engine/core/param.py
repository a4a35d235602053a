"""Param: one declaration of a tunable value, from which UBO fields, editor widgets, CLI flags and docs are made.

A pass declares its parameters as a `ParamBlock`:

    class Params(ParamBlock):
        exposure: float = param(0.0, min=-10, max=10, unit="EV", doc="added to the scene's exposure")

An effect file declares the same thing in TOML; both end as a tuple of `Param`.
"""

from __future__ import annotations

import difflib
import math
from dataclasses import dataclass
from typing import Any, ClassVar

from engine.core.color_text import is_color_text, parse_color
from engine.core.errors import UsageError

#: Parameter types and their component counts. Textures have none: they become slots.
COMPONENTS = {
    "float": 1, "int": 1, "uint": 1, "bool": 1, "enum": 1,
    "vec2": 2, "vec3": 3, "vec4": 4, "color3": 3, "color4": 4, "texture2d": 0,
}  # fmt: skip

Value = float | int | bool | str | tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Param:
    """A tunable value: `default`, inclusive range [`min`, `max`], `unit`, `choices` (for enum), `space` (srgb|linear),
    `doc`. Colours are scene-linear Rec.709, and may be given as text (color_text.py).

    `group`, `order`: where an editor shows it (by group, then order, then as declared); `when`: a condition under which
    it matters ('' always)."""

    name: str
    type: str
    default: Any
    min: float = -math.inf
    max: float = math.inf
    step: float = 0.0
    unit: str = ""
    choices: tuple[str, ...] = ()
    space: str = "linear"
    doc: str = ""
    group: str = ""
    order: float = 0.0
    when: str = ""

    def check(self, value: Any) -> Value:
        """Return `value` converted and range-checked; raises UsageError that names the parameter, value and range."""
        count = COMPONENTS[self.type]
        try:
            if self.type == "enum":
                text = str(value)
                if text not in self.choices:
                    near = difflib.get_close_matches(text, self.choices, 1)
                    hint = f"did you mean {near[0]!r}?" if near else f"choose one of {', '.join(self.choices)}"
                    raise UsageError(f"{self.name}: {text!r} is not a choice", hint=hint)
                return text
            if self.type == "bool":
                if isinstance(value, str):
                    lowered = value.strip().lower()
                    if lowered not in {"1", "0", "true", "false", "on", "off", "yes", "no"}:
                        raise UsageError(f"{self.name}: {value!r} is not true or false")
                    return lowered in {"1", "true", "on", "yes"}
                return bool(value)
            if self.type in ("color3", "color4") and is_color_text(value):
                value = parse_color(self.name, value, count)
            if isinstance(value, str):
                value = [float(v) for v in value.replace(",", " ").split()]
            parts = tuple(float(v) for v in (value if isinstance(value, (list, tuple)) else [value]))
            if self.type == "color4" and len(parts) == 3:
                parts = (*parts, 1.0)  # opaque
            if len(parts) != count:
                raise UsageError(f"{self.name}: expected {count} number(s) for {self.type}, got {len(parts)}")
        except (TypeError, ValueError) as error:
            raise UsageError(f"{self.name}: {value!r} is not a {self.type}") from error
        for number in parts:
            if not math.isfinite(number):
                raise UsageError(f"{self.name}: {number} is not a finite number")
            if not self.min <= number <= self.max:
                raise UsageError(
                    f"{self.name}: {number:g} is outside [{self.min:g}, {self.max:g}] {self.unit}".rstrip()
                )
        if count > 1:
            return parts
        return int(parts[0]) if self.type in {"int", "uint"} else parts[0]


def param(
    default: Any, *, min: float = -math.inf, max: float = math.inf, step: float = 0.0,
    unit: str = "", choices: tuple[str, ...] = (), space: str = "linear", doc: str = "", type: str = "",
) -> Any:  # fmt: skip
    """Declare a field of a `ParamBlock`; the type is taken from the default unless given."""
    if not type:
        if isinstance(default, bool):
            type = "bool"
        elif isinstance(default, int):
            type = "int"
        elif isinstance(default, float):
            type = "float"
        elif isinstance(default, str):
            type = "enum"
        else:
            type = f"vec{len(default)}"
    return Param("", type, default, min, max, step, unit, choices, space, doc)


class ParamBlock:
    """Base of a group of parameters declared as class attributes. Instances hold checked values."""

    PARAMS: ClassVar[tuple[Param, ...]] = ()

    def __init_subclass__(cls) -> None:
        own = []
        for name, value in list(vars(cls).items()):
            if isinstance(value, Param):
                own.append(Param(name, *(getattr(value, f) for f in Param.__slots__[1:])))
                delattr(cls, name)
        cls.PARAMS = (*cls.PARAMS, *own)

    def __init__(self, **values: Any) -> None:
        known = {p.name: p for p in self.PARAMS}
        for name in values:
            if name not in known:
                near = difflib.get_close_matches(name, known, 1)
                raise UsageError(
                    f"unknown parameter {name!r}",
                    hint=f"did you mean {near[0]!r}?" if near else f"known: {', '.join(known) or 'none'}",
                )
        for p in self.PARAMS:
            object.__setattr__(self, p.name, p.check(values.get(p.name, p.default)))

    def __setattr__(self, name: str, value: Any) -> None:
        for p in self.PARAMS:
            if p.name == name:
                object.__setattr__(self, name, p.check(value))
                return
        raise UsageError(f"unknown parameter {name!r}")

    def values(self) -> dict[str, Value]:
        return {p.name: getattr(self, p.name) for p in self.PARAMS}

    def key(self) -> tuple[Value, ...]:
        """A hashable snapshot of all values, in declaration order."""
        return tuple(getattr(self, p.name) for p in self.PARAMS)
