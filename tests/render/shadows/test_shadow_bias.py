"""The normal offset clears a flat receiver's own depths at every angle, and moves nothing that faces the sun."""

from __future__ import annotations

import numpy as np
import pytest

from engine.render.shadows.bias import FOOTPRINT, HARDWARE_MAX_SLOPE, LIFT, MAX_SLOPE, normal_offset

ANGLES = np.radians([0.0, 5.0, 20.0, 45.0, 70.0, 80.0, 85.0, 89.0, 89.9])


@pytest.mark.parametrize("hardware", [False, True], ids=["planes", "hardware"])
@pytest.mark.parametrize("radius", [0.0, 1.5, 8.0])
@pytest.mark.parametrize("theta", ANGLES)
def test_lifted_plane_is_above_all_that_the_filter_sees(theta: float, radius: float, hardware: bool) -> None:
    """In texels along the light: the plane rises by tan(theta) a texel; what is compared follows it up to a slope."""
    lift = normal_offset(np.cos(theta), radius, hardware=hardware) / np.cos(theta)
    rest = np.tan(theta) - min(np.tan(theta), HARDWARE_MAX_SLOPE if hardware else MAX_SLOPE)
    needed = np.sqrt(2.0) * (np.tan(theta) if hardware else rest) + radius * rest
    assert lift >= needed * (1.0 - 1e-9)


def test_facing_the_sun_nothing_moves_and_the_lift_is_bounded() -> None:
    for hardware in (False, True):
        assert normal_offset(1.0, 8.0, hardware=hardware) == 0.0
        most = FOOTPRINT + 2.0 + (0.0 if hardware else LIFT)
        assert normal_offset(0.0, 2.0, hardware=hardware) == pytest.approx(most, rel=1e-3)
        assert normal_offset(-0.5, 1.0, hardware=hardware) == normal_offset(0.5, 1.0, hardware=hardware)
