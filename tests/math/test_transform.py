from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from engine.math import quat, transform

quaternions = (
    arrays(np.float64, 4, elements=st.floats(-1, 1)).filter(lambda q: np.linalg.norm(q) > 1e-3).map(quat.normalize)
)
positions = arrays(np.float64, 3, elements=st.floats(-1e6, 1e6))
scales = arrays(np.float64, 3, elements=st.floats(1e-4, 1e4) | st.floats(-1e4, -1e-4))


@given(positions, quaternions, scales)
def test_decompose_undoes_compose(t: np.ndarray, q: np.ndarray, s: np.ndarray) -> None:
    m = transform.compose(t, q, s)
    t2, q2, s2 = transform.decompose(m)
    assert np.array_equal(t2, t)
    assert np.allclose(transform.compose(t2, q2, s2), m, rtol=1e-9, atol=1e-9 * np.abs(s).max())
    assert np.allclose(np.abs(s2), np.abs(s), rtol=1e-9)


@given(positions, quaternions, scales)
def test_inverse(t: np.ndarray, q: np.ndarray, s: np.ndarray) -> None:
    m = transform.compose(t, q, s)
    inverse = transform.inverse_affine(m)
    point = np.array([1.0, -2.0, 3.0])
    there = m[:3, :3] @ point
    assert np.allclose(inverse[:3, :3] @ there, point, rtol=1e-6, atol=1e-6)
    assert np.allclose(m[:3, :3] @ inverse[:3, 3] + m[:3, 3], 0.0, atol=1e-6 * max(1.0, np.abs(t).max()))


def test_compose_known() -> None:
    m = transform.compose([1, 2, 3], quat.from_axis_angle([0, 0, 1], math.pi / 2), [2, 3, 4])
    assert np.allclose(m @ [1, 1, 1, 1], [1 - 3, 2 + 2, 3 + 4, 1])


def test_compose_broadcasts() -> None:
    assert transform.compose(np.zeros((5, 3)), quat.IDENTITY, [1, 1, 1]).shape == (5, 4, 4)


@pytest.mark.parametrize(
    "scale", [(1, 1, 0), (0, 1, 1), (1, 0, 1), (0, 0, 1), (0, 1, 0), (1, 0, 0), (0, 0, 0), (-1, 1, 1), (1, -2, 0)]
)
def test_degenerate_scales_stay_finite(scale: tuple[float, float, float]) -> None:
    q = quat.from_axis_angle([1, 2, 3], 0.7)
    m = transform.compose([1, 2, 3], q, scale)
    t, rotation, s = transform.decompose(m)
    assert math.isclose(np.linalg.norm(rotation), 1.0)
    assert np.allclose(transform.compose(t, rotation, s), m, atol=1e-12)
    inverse = transform.inverse_affine(m)
    assert np.isfinite(inverse).all()
    assert np.allclose(m[:3, :3] @ inverse[:3, :3] @ m[:3, :3], m[:3, :3], atol=1e-12), "the pseudo-inverse"


def test_tiny_uniform_scale_is_not_singular() -> None:
    m = transform.compose([0, 0, 0], quat.IDENTITY, [1e-9, 1e-9, 1e-9])
    assert np.allclose(transform.inverse_affine(m)[:3, :3], np.eye(3) * 1e9)


def test_uneven_scale_is_not_singular() -> None:
    m = transform.compose([0, 0, 0], quat.from_axis_angle([1, 1, 0], 1.0), [1e-8, 1.0, 1e8])
    assert np.allclose(m[:3, :3] @ transform.inverse_affine(m)[:3, :3], np.eye(3), atol=1e-6)


def test_cofactor_keeps_normals_perpendicular() -> None:
    rng = np.random.default_rng(1)
    m = rng.normal(size=(20, 3, 3))
    u, v = rng.normal(size=(2, 20, 3))
    normal = np.cross(u, v)
    moved = (transform.cofactor(m) @ normal[..., None])[..., 0]
    expected = np.cross((m @ u[..., None])[..., 0], (m @ v[..., None])[..., 0])
    assert np.allclose(moved, expected)


def test_cofactor_of_flat_scale_is_finite() -> None:
    assert np.allclose(transform.cofactor(np.diag([1.0, 1.0, 0.0])) @ [0, 0, 1], [0, 0, 1])


def test_look_at_sees_target_on_minus_z() -> None:
    m = transform.look_at([1, 2, 3], [4, 2, 3])
    assert np.allclose(transform.inverse_affine(m) @ [4, 2, 3, 1], [0, 0, -3, 1])
    assert np.allclose(m[:3, 1], [0, 1, 0])


@pytest.mark.parametrize(
    ("eye", "target", "up"),
    [([0, 0, 0], [0, 0, 0], [0, 1, 0]), ([0, 5, 0], [0, 0, 0], [0, 1, 0]), ([0, 0, 5], [0, 0, 0], [0, 0, 0])],
)
def test_look_at_degenerate_is_rigid(eye: list[float], target: list[float], up: list[float]) -> None:
    m = transform.look_at(eye, target, up)
    assert np.allclose(m[:3, :3] @ m[:3, :3].T, np.eye(3), atol=1e-12)
    assert math.isclose(np.linalg.det(m[:3, :3]), 1.0)
