from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from engine.math import quat

components = st.floats(-1.0, 1.0)
quaternions = arrays(np.float64, 4, elements=components).filter(lambda q: np.linalg.norm(q) > 1e-3).map(quat.normalize)
vectors = arrays(np.float64, 3, elements=st.floats(-1e3, 1e3))


def same_rotation(a: np.ndarray, b: np.ndarray, tolerance: float = 1e-12) -> bool:
    return min(np.abs(a - b).max(), np.abs(a + b).max()) <= tolerance


@given(quaternions)
def test_matrix_round_trip(q: np.ndarray) -> None:
    m = quat.to_matrix3(q)
    assert np.allclose(m @ m.T, np.eye(3), atol=1e-12)
    assert math.isclose(np.linalg.det(m), 1.0, rel_tol=1e-12)
    assert same_rotation(quat.from_matrix3(m), q)


@given(quaternions, quaternions, vectors)
def test_product_is_matrix_product(a: np.ndarray, b: np.ndarray, v: np.ndarray) -> None:
    product = quat.multiply(a, b)
    assert np.allclose(quat.to_matrix3(product), quat.to_matrix3(a) @ quat.to_matrix3(b), atol=1e-12)
    assert np.allclose(quat.rotate(product, v), quat.rotate(a, quat.rotate(b, v)), atol=1e-9)
    assert np.allclose(quat.rotate(quat.conjugate(a), quat.rotate(a, v)), v, atol=1e-9)


def test_quarter_turn_about_y_takes_z_to_x() -> None:
    q = quat.from_axis_angle([0, 2, 0], math.pi / 2)
    assert np.allclose(q, [0, math.sqrt(0.5), 0, math.sqrt(0.5)])
    assert np.allclose(quat.rotate(q, [0, 0, 1]), [1, 0, 0], atol=1e-15)


def test_axis_angle_batches_and_zero_axis() -> None:
    q = quat.from_axis_angle([[1, 0, 0], [0, 0, 0]], [math.pi, 3.0])
    assert np.allclose(q, [[1, 0, 0, 0], [0, 0, 0, 1]])
    assert quat.from_axis_angle([0, 1, 0], np.zeros(5)).shape == (5, 4)


@pytest.mark.parametrize("size", [1e-300, 1e-30, 1.0, 1e30, 1e300])
def test_normalize_any_length(size: float) -> None:
    assert np.allclose(quat.normalize(np.array([1, 2, 3, 4]) * size), np.array([1, 2, 3, 4]) / math.sqrt(30))


@given(quaternions)
def test_normalize_is_idempotent(q: np.ndarray) -> None:
    assert np.array_equal(quat.normalize(q), q)


@pytest.mark.parametrize("bad", [[0, 0, 0, 0], [math.nan, 0, 0, 1], [math.inf, 0, 0, 1], [0, -math.inf, math.nan, 1]])
def test_normalize_gives_identity_for_nonsense(bad: list[float]) -> None:
    assert np.array_equal(quat.normalize(bad), quat.IDENTITY)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-7, 1e-5, 1e-4, 1e-3, 0.1, 1.0, 3.0, math.pi - 1e-7])
@pytest.mark.parametrize("t", [0.0, 0.25, 0.5, 1.0])
def test_slerp_is_constant_speed(angle: float, t: float) -> None:
    a = quat.from_axis_angle([0.6, 0.0, 0.8], 0.3)
    b = quat.multiply(a, quat.from_axis_angle([0, 1, 0], angle))
    expected = quat.multiply(a, quat.from_axis_angle([0, 1, 0], angle * t))
    assert quat.angle_between(quat.slerp(a, b, t), expected) < 1e-9
    assert quat.angle_between(quat.slerp(a, -b, t), expected) < 1e-9, "the double cover must not change the path"


def test_slerp_half_turn_is_unit() -> None:
    assert math.isclose(np.linalg.norm(quat.slerp([0, 0, 0, 1], [1, 0, 0, 0], 0.5)), 1.0)


@given(quaternions, quaternions, st.floats(0, 1))
@settings(max_examples=50)
def test_slerp_stays_unit_and_reverses(a: np.ndarray, b: np.ndarray, t: float) -> None:
    q = quat.slerp(a, b, t)
    assert math.isclose(np.linalg.norm(q), 1.0, abs_tol=1e-12)
    if abs(np.dot(a, b)) > 1e-6:
        assert quat.angle_between(q, quat.slerp(b, a, 1.0 - t)) < 1e-9


def test_angle_of_tiny_rotations() -> None:
    angles = np.array([1e-12, 1e-8, 1e-3, 1.0, math.pi])
    q = quat.from_axis_angle([0, 0, 1], angles)
    assert np.allclose(quat.angle_between(quat.IDENTITY, q), angles, rtol=1e-9)
