"""`when`: what holds, and what is no condition."""

from __future__ import annotations

from typing import Any

import pytest

from engine.core.errors import UsageError
from engine.materials.condition import parse_condition

VALUES: dict[str, Any] = {
    "on": True, "off": False, "size": 2.0, "mode": "add", "tint": (0.0, 0.0, 0.0), "count": 0,
}  # fmt: skip


@pytest.mark.parametrize(
    ("text", "holds"),
    [
        ("on", True), ("off", False), ("not off", True), ("size", True), ("count", False), ("tint", False),
        ("on and off", False), ("on or off", True), ("off and off or on", True), ("off and (off or on)", False),
        ("not on or on", True), ("size == 2", True), ("size>=2.5", False), ("size != 1e3", True), ("size < -1", False),
        ("mode == add", True), ("mode != add", False), ("on == true", True), ("off == 1", False),
        ("size == add", False),
        ("missing", False), ("missing > 1", False),
    ],
)  # fmt: skip
def test_what_holds(text: str, holds: bool) -> None:
    condition = parse_condition(text)
    assert condition.holds(VALUES) is holds
    assert condition.names <= {*VALUES, "missing"}


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("sise > 1", "did you mean 'size'?"),
        ("mode == ad", "did you mean 'add'?"),
        ("size == big", "'big' is no number, true or false"),
        ("on and", "expected a name at the end"),
        ("and on", "expected a name, got 'and'"),
        ("size >", "expected a value at the end"),
        ("(on", "a bracket is not closed"),
        ("on off", "did not expect 'off'"),
        ("on & off", "did not expect '&'"),
        ("", "expected a name at the end"),
        (" and ".join(["on"] * 200), "more than 200 words"),
    ],
)
def test_mistakes(text: str, says: str) -> None:
    with pytest.raises(UsageError) as caught:
        parse_condition(text, VALUES, {"mode": ("add", "multiply")})
    assert says in str(caught.value)
