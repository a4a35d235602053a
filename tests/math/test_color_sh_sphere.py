from __future__ import annotations

import math

import numpy as np
import pytest

from engine.math import color, sh, sphere


def test_srgb_known_values() -> None:
    assert color.srgb_to_linear(0.5) == pytest.approx(0.21404114048223255)
    assert color.linear_to_srgb(0.18) == pytest.approx(0.4613561295004)
    assert np.allclose(color.linear_to_srgb([0.0, 1.0, -1.0]), [0.0, 1.0, -1.0])


def test_srgb_bytes_survive_a_round_trip() -> None:
    codes = np.arange(256, dtype=np.uint8)
    assert np.array_equal(color.to_u1(color.srgb_to_linear(codes / 255.0)), codes)


def test_to_u1_defines_nonsense() -> None:
    assert color.to_u1([math.nan, math.inf, -math.inf, -1.0, 2.0]).tolist() == [0, 255, 0, 0, 255]


def test_luminance_of_white_is_one() -> None:
    assert color.luminance([1.0, 1.0, 1.0]) == pytest.approx(1.0)


def test_sh_basis_is_orthonormal() -> None:
    d = sphere.cube_directions(64).reshape(-1, 3)
    weight = np.broadcast_to(sphere.cube_solid_angles(64), (6, 64, 64)).reshape(-1)
    b = sh.basis9(d)
    assert np.allclose(b.T @ (b * weight[:, None]), np.eye(9), atol=2e-4)


def test_uniform_radiance_gives_pi_irradiance() -> None:
    d = sphere.fibonacci(4096)
    c = sh.project(np.full((4096, 3), 2.0), d, np.full(4096, 4 * math.pi / 4096))
    assert np.allclose(sh.evaluate(sh.irradiance_coefficients(c), [0.0, 0.6, 0.8]), 2 * math.pi, rtol=1e-3)


def test_irradiance_of_clamped_cosine_sky() -> None:
    # L = max(z, 0): E at +Z is 2 pi / 3; nine coefficients give it within 3 percent (Ramamoorthi and Hanrahan)
    d = sphere.cube_directions(64).reshape(-1, 3)
    weight = np.broadcast_to(sphere.cube_solid_angles(64), (6, 64, 64)).reshape(-1)
    c = sh.project(np.maximum(d[:, 2:], 0.0), d, weight)
    assert sh.evaluate(sh.irradiance_coefficients(c), [0.0, 0.0, 1.0])[0] == pytest.approx(2 * math.pi / 3, rel=0.03)


def test_cube_faces_look_where_they_should() -> None:
    d = sphere.cube_directions(3)
    assert np.allclose(d[:, 1, 1], [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]])
    assert (d[[0, 1, 4, 5], 0, :, 1] > 0).all(), "row 0 of the side faces is up"
    assert (d[0, :, 0, 2] > 0).all(), "left of +x is +z"
    assert (d[4, :, 2, 0] > 0).all(), "right of +z is +x"
    assert (d[2, 0, :, 2] < 0).all(), "top of +y is -z"
    assert np.allclose(np.linalg.norm(d, axis=-1), 1.0)


def test_solid_angles_sum_to_the_sphere() -> None:
    assert 6 * sphere.cube_solid_angles(7).sum() == pytest.approx(4 * math.pi, rel=1e-12)


def test_hammersley_first_points() -> None:
    assert np.array_equal(sphere.hammersley(4), [[0.125, 0.0], [0.375, 0.5], [0.625, 0.25], [0.875, 0.75]])


def test_cosine_hemisphere_mean_cosine() -> None:
    d = sphere.cosine_hemisphere(sphere.hammersley(4096))
    assert d[:, 2].mean() == pytest.approx(2 / 3, abs=1e-3)
    assert sphere.uniform_sphere(sphere.hammersley(4096)).mean(axis=0) == pytest.approx(np.zeros(3), abs=2e-3)


def test_basis_is_a_right_handed_frame_everywhere() -> None:
    n = np.concatenate([sphere.fibonacci(300), [[0, 0, -1], [0, 0, 1], [1e-9, 0, -1]]])
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    t, b = sphere.basis(n)
    assert np.allclose(np.cross(t, b), n, atol=1e-9)
    assert np.allclose(np.sum(t * n, axis=1), 0, atol=1e-9)
