"""Numbers and names as people read them."""

from __future__ import annotations

import html
import math
from collections.abc import Mapping
from typing import Any

_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def escape(text: object) -> str:
    return html.escape(str(text), quote=True)


def power(exponent: int) -> str:
    """10⁻³, with 1 for 10⁰ and 10 for 10¹."""
    if exponent in (0, 1, 2):
        return str(10**exponent)
    return "10" + str(exponent).translate(_SUPERSCRIPT)


def scientific(value: float | None, digits: int = 2) -> str:
    """`1.2 × 10⁻³`; plain between 0.01 and 10,000; a dash for None, words for what is not finite."""
    if value is None:
        return "–"
    if math.isnan(value):
        return "not a number"
    if math.isinf(value):
        return "infinite"
    if value == 0.0:
        return "0"
    if 0.01 <= abs(value) < 10000.0:
        return f"{value:.{max(0, digits - 1 - math.floor(math.log10(abs(value))))}f}"
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    return f"{mantissa} × 10{str(int(exponent)).translate(_SUPERSCRIPT)}"


def milliseconds(value: float) -> str:
    """Three significant digits."""
    if value >= 100.0:
        return f"{value:.0f}"
    return f"{value:.2f}" if value >= 1.0 else f"{value:.3f}"


def knobs(values: Mapping[str, Any], without: str = "") -> str:
    """`size 64, form cross`, or the value alone where there is only one that speaks for itself."""
    shown = {k: v for k, v in values.items() if k != without and v != ""}
    if len(shown) == 1 and isinstance(next(iter(shown.values())), str):
        return plain(next(iter(shown.values())))
    return ", ".join(f"{k} {plain(v)}" for k, v in shown.items())


def plain(value: Any) -> str:
    if isinstance(value, bool):
        return "on" if value else "off"
    if isinstance(value, float):
        return f"{value:g}"
    return str(value)
