"""Colours as text: known values, every form, every mistake."""

from __future__ import annotations

from typing import Any

import pytest

from engine.core.color_text import is_color_text, parse_color
from engine.core.errors import UsageError
from engine.core.param import Param
from engine.math.color import srgb_to_linear


@pytest.mark.parametrize(
    ("value", "components", "expected"),
    [
        ("#ff0000", 3, (1.0, 0.0, 0.0)),
        ("#0F0", 3, (0.0, 1.0, 0.0)),
        ("white", 4, (1.0, 1.0, 1.0, 1.0)),
        ("#00000080", 4, (0.0, 0.0, 0.0, 128 / 255)),
        ("#80808080", 4, (0.2158605, 0.2158605, 0.2158605, 128 / 255)),  # IEC 61966-2-1
        ("Gray", 3, (0.2158605,) * 3),
        ({"linear": [0.5, 0.25, 2.0]}, 3, (0.5, 0.25, 2.0)),
        ({"srgb": [0.5, 0.0, 1.0, 0.5]}, 4, (0.2140411, 0.0, 1.0, 0.5)),
        ([0.5, 0.25, 2.0], 4, (0.5, 0.25, 2.0, 1.0)),
        ("0.5, 0.25 2", 3, (0.5, 0.25, 2.0)),
    ],
)
def test_forms(value: Any, components: int, expected: tuple[float, ...]) -> None:
    assert parse_color("c", value, components) == pytest.approx(expected, abs=1e-6)


def test_decoding_is_that_of_the_engine() -> None:
    for digit in range(0, 256, 5):
        text = f"#{digit:02x}0000"
        assert parse_color("c", text, 3)[0] == pytest.approx(float(srgb_to_linear(digit / 255)), abs=1e-9)


@pytest.mark.parametrize(
    ("value", "says"),
    [
        ("#12345", "5 digits, 3, 4, 6 or 8 are wanted"),
        ("#gg0000", "'g' is no hexadecimal digit"),
        ("ornage", "'ornage' is no colour"),
        ("", "'' is no colour"),
        ("#11223344", "expected 3 number"),
        ({"p3": [1.0, 0.0, 0.0]}, "one key, srgb or linear; got p3"),
        ({}, "got nothing"),
        ({"srgb": [1.0]}, "expected 3 or 4 numbers, got 1"),
        ({"srgb": "red"}, "is no colour"),
        ([1.0, float("nan"), 0.0], "is no colour"),
        ([True, False, True], "is no colour"),
    ],
)
def test_mistakes(value: Any, says: str) -> None:
    with pytest.raises(UsageError, match=r"^c") as caught:
        parse_color("c", value, 3)
    assert says in str(caught.value)


def test_a_parameter_takes_them() -> None:
    tint = Param("tint", "color4", (0.0, 0.0, 0.0, 1.0), min=0.0, max=1.0)
    assert tint.check("#ff0000") == (1.0, 0.0, 0.0, 1.0)
    assert tint.check([0.5, 0.5, 0.5]) == (0.5, 0.5, 0.5, 1.0)
    assert tint.check("0.5 0.5 0.5 0.25") == (0.5, 0.5, 0.5, 0.25)
    with pytest.raises(UsageError, match="outside"):
        tint.check({"linear": [2.0, 0.0, 0.0]})
    assert not is_color_text("1 0 0")
    assert not is_color_text([1.0, 0.0, 0.0])
