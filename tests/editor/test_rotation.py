"""Euler angles of the inspector against the engine's quaternions."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from editor.rotation import euler_from_quaternion, quaternion_from_euler
from engine.math import quat

ANGLE = st.floats(-179.0, 179.0)


def test_known_angles() -> None:
    s = math.sqrt(0.5)
    assert quaternion_from_euler((90, 0, 0)) == pytest.approx((s, 0, 0, s))
    assert quaternion_from_euler((0, 90, 0)) == pytest.approx((0, s, 0, s))
    assert quaternion_from_euler((0, 0, 90)) == pytest.approx((0, 0, s, s))
    assert euler_from_quaternion((0, 0, 0, 1)) == pytest.approx((0, 0, 0))


@given(ANGLE, st.floats(-89.0, 89.0), ANGLE)
def test_there_and_back(x: float, y: float, z: float) -> None:
    assert euler_from_quaternion(quaternion_from_euler((x, y, z))) == pytest.approx((x, y, z), abs=1e-6)


@given(ANGLE, ANGLE, ANGLE)
def test_is_the_product_z_y_x(x: float, y: float, z: float) -> None:
    axes = [quat.from_axis_angle(axis, math.radians(a)) for axis, a in (((1, 0, 0), x), ((0, 1, 0), y), ((0, 0, 1), z))]
    product = quat.multiply(axes[2], quat.multiply(axes[1], axes[0]))
    assert abs(float(product @ quaternion_from_euler((x, y, z)))) == pytest.approx(1.0)


@pytest.mark.parametrize("y", [90.0, -90.0])
@pytest.mark.parametrize("z", [0.0, 40.0, -130.0])
def test_at_the_poles_the_rotation_is_kept(y: float, z: float) -> None:
    q = quaternion_from_euler((25.0, y, z))
    again = quaternion_from_euler(euler_from_quaternion(q))
    assert abs(sum(a * b for a, b in zip(q, again, strict=True))) == pytest.approx(1.0, abs=1e-6)
