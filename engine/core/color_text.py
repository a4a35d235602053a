"""Colours as people write them: "#rgb", "#rrggbb", "#rrggbbaa", a few names, or a table that states its space.

Digits and names are sRGB, as everywhere else in the world; what comes out is scene-linear Rec.709 (alpha stays as it
is):

    "#ff8000"                          "orange"
    { srgb = [1.0, 0.5, 0.0] }         { linear = [1.0, 0.21, 0.0] }
    [1.0, 0.21, 0.0]                   plain numbers are linear
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Mapping
from typing import Any

from engine.core.errors import UsageError

#: the sixteen of HTML 4.01 (6.5), and orange
NAMES = {
    "black": "#000000", "silver": "#c0c0c0", "gray": "#808080", "white": "#ffffff", "maroon": "#800000",
    "red": "#ff0000", "purple": "#800080", "fuchsia": "#ff00ff", "green": "#008000", "lime": "#00ff00",
    "olive": "#808000", "yellow": "#ffff00", "navy": "#000080", "blue": "#0000ff", "teal": "#008080",
    "aqua": "#00ffff", "orange": "#ffa500",
}  # fmt: skip
FORMS = '"#rrggbb", "#rrggbbaa", a name, [r, g, b], { srgb = […] } or { linear = […] }'


def is_color_text(value: Any) -> bool:
    """Whether a value is written as a colour, not as plain numbers."""
    return isinstance(value, Mapping) or (isinstance(value, str) and not _looks_like_numbers(value))


def parse_color(name: str, value: Any, components: int) -> tuple[float, ...]:
    """The colour as 3 or 4 linear numbers (`components`; 0: as many as there are); alpha is 1 where 4 are wanted and 3
    are given. `name` is for messages.

    Raises UsageError that says what is wrong and which forms there are.
    """
    if isinstance(value, Mapping):
        numbers = _of_table(name, value)
    elif isinstance(value, str) and not _looks_like_numbers(value):
        numbers = _decoded(_of_text(name, value))
    else:
        numbers = _numbers(name, value)
    if components == 4 and len(numbers) == 3:
        numbers = (*numbers, 1.0)
    if components and len(numbers) != components:
        more = "; this colour has no alpha" if components == 3 and len(numbers) == 4 else ""
        raise UsageError(f"{name}: expected {components} number(s), got {len(numbers)}{more}")
    return numbers


def linear_of_srgb(value: float) -> float:
    """IEC 61966-2-1:1999, 5.2."""
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4


def _looks_like_numbers(text: str) -> bool:
    return bool(text.strip()) and all(c in "0123456789+-.eE, \t" for c in text)


def _of_text(name: str, text: str) -> tuple[float, ...]:
    word = text.strip().lower()
    digits = NAMES.get(word, word)
    if not digits.startswith("#"):
        near = difflib.get_close_matches(word, NAMES, 1)
        hint = f"did you mean {near[0]!r}?" if near else f"write {FORMS}"
        raise UsageError(f"{name}: {text!r} is no colour", hint=hint)
    digits = digits[1:]
    bad = next((c for c in digits if c not in "0123456789abcdef"), "")
    if bad or len(digits) not in (3, 4, 6, 8):
        why = f"{bad!r} is no hexadecimal digit" if bad else f"{len(digits)} digits, 3, 4, 6 or 8 are wanted"
        raise UsageError(f"{name}: {text!r} is no colour: {why}", hint='write "#rrggbb" or "#rrggbbaa"')
    if len(digits) < 6:
        digits = "".join(2 * c for c in digits)
    return tuple(int(digits[i : i + 2], 16) / 255.0 for i in range(0, len(digits), 2))


def _of_table(name: str, table: Mapping[Any, Any]) -> tuple[float, ...]:
    if len(table) != 1 or next(iter(table)) not in ("srgb", "linear"):
        keys = ", ".join(map(str, table)) or "nothing"
        raise UsageError(
            f"{name}: a colour's table has one key, srgb or linear; got {keys}", hint="as { srgb = [1.0, 0.5, 0.0] }"
        )
    (space, value), *_ = table.items()
    numbers = _numbers(name, value)
    if len(numbers) not in (3, 4):
        raise UsageError(f"{name}.{space}: expected 3 or 4 numbers, got {len(numbers)}")
    return _decoded(numbers) if space == "srgb" else numbers


def _numbers(name: str, value: Any) -> tuple[float, ...]:
    parts = value.replace(",", " ").split() if isinstance(value, str) else value
    parts = parts if isinstance(parts, (list, tuple)) else [parts]
    try:
        numbers = tuple(float(part) for part in parts if not isinstance(part, bool))
    except (TypeError, ValueError):
        numbers = ()
    if len(numbers) != len(parts) or not all(map(math.isfinite, numbers)):
        raise UsageError(f"{name}: {value!r} is no colour", hint=f"write {FORMS}")
    return numbers


def _decoded(srgb: tuple[float, ...]) -> tuple[float, ...]:
    return (*map(linear_of_srgb, srgb[:3]), *srgb[3:])
