"""Light space is a rotation with the sun along z, for every sun."""

from __future__ import annotations

import numpy as np
import pytest

from engine.render.shadows.light_space import light_from_world

DIRECTIONS = [(0, -1, 0), (0, 1, 0), (1, 0, 0), (0, 0, -3), (1e-9, -1, 0), (0.02, -1, 0.03), (1, -2, 3), (1e-20, 0, 0)]


@pytest.mark.parametrize("direction", DIRECTIONS)
def test_a_rotation_with_the_sun_along_z(direction: tuple[float, ...]) -> None:
    axes = light_from_world(direction)
    assert axes @ axes.T == pytest.approx(np.eye(3), abs=1e-12)
    assert np.linalg.det(axes) == pytest.approx(1.0)
    assert axes[2] == pytest.approx(-np.array(direction) / np.linalg.norm(direction))


@pytest.mark.parametrize("direction", [(0, 0, 0), (np.nan, 0, 0), (np.inf, 0, 0)])
def test_no_direction_is_straight_down(direction: tuple[float, ...]) -> None:
    assert light_from_world(direction)[2].tolist() == [0, 1, 0]
