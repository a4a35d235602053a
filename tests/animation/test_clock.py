from __future__ import annotations

import math

import pytest

from engine.animation.clock import wrap
from engine.core.errors import InputError


@pytest.mark.parametrize(
    ("time", "mode", "expected"),
    [
        (0.5, "loop", 0.5), (2.5, "loop", 0.5), (-0.5, "loop", 1.5), (2.0, "loop", 0.0), (-4.0, "loop", 0.0),
        (-1e-30, "loop", 0.0), (3.0, "once", 2.0), (-3.0, "once", 0.0), (2.0, "once", 2.0),
        (math.inf, "once", 2.0), (-math.inf, "once", 0.0), (3.0, "ping-pong", 1.0), (2.0, "ping-pong", 2.0),
        (4.5, "ping-pong", 0.5), (-0.5, "ping-pong", 0.5), (math.nan, "loop", 0.0), (math.nan, "once", 0.0),
        (math.inf, "loop", 0.0), (-math.inf, "ping-pong", 0.0),
    ],
)  # fmt: skip
def test_known_times(time: float, mode: str, expected: float) -> None:
    assert wrap(time, 2.0, mode) == expected


@pytest.mark.parametrize("mode", ["loop", "once", "ping-pong"])
@pytest.mark.parametrize("duration", [0.0, -1.0, math.nan, math.inf])
def test_no_duration(mode: str, duration: float) -> None:
    assert wrap(7.0, duration, mode) == 0.0


def test_huge_times_keep_their_fraction() -> None:
    assert wrap(1e12 + 0.25, 2.0) == 0.25
    assert wrap(-1e9 - 0.25, 2.0) == 1.75


def test_unknown_mode() -> None:
    with pytest.raises(InputError, match="bounce"):
        wrap(0.0, 1.0, "bounce")
