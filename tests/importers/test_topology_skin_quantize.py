"""Numpy kernels with known answers: topology, flat normals, influences, quantisation."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from importers.geometry.normals import fill_normals, flat_normals, unit
from importers.geometry.quantize import snorm16, unorm16
from importers.geometry.skin import normalise_influences
from importers.geometry.topology import to_list, zero_area

I = np.arange(10, 16, dtype=np.uint32)


@pytest.mark.parametrize(
    ("mode", "count", "expected"),
    [
        (0, 3, [10, 11, 12]),
        (1, 5, [10, 11, 12, 13]),
        (2, 3, [10, 11, 11, 12, 12, 10]),
        (3, 3, [10, 11, 11, 12]),
        (4, 5, [10, 11, 12]),
        (5, 5, [10, 11, 12, 11, 13, 12, 12, 13, 14]),
        (6, 5, [11, 12, 10, 12, 13, 10, 13, 14, 10]),
        (5, 2, []),
        (6, 1, []),
        (3, 1, []),
    ],
)
def test_modes_become_lists(mode: int, count: int, expected: list[int]) -> None:
    assert to_list(I[:count], mode).tolist() == expected


def test_strip_keeps_its_winding() -> None:
    """All triangles of a strip over a flat zigzag face the same way."""
    points = np.array([[i / 2, i % 2, 0] for i in range(8)], np.float32)
    triangles = to_list(np.arange(8, dtype=np.uint32), 5).reshape(-1, 3)
    a, b, c = (points[triangles[:, k]] for k in range(3))
    signs = np.sign(np.cross(b - a, c - a)[:, 2])
    assert len(set(signs.tolist())) == 1


def test_zero_area_at_any_scale() -> None:
    base = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 0, 0], [0.5, 1e-9, 0]], np.float32)
    triangles = np.array([[0, 1, 2], [0, 1, 3], [0, 1, 4]], np.uint32)
    for scale in (1e-6, 1.0, 1e6):
        assert zero_area(base * np.float32(scale), triangles).tolist() == [False, True, True]


def test_flat_normals_of_a_cube_corner_split_and_of_a_quad_do_not() -> None:
    quad = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1]], np.float32)
    source, normals, triangles = flat_normals(quad, np.array([[0, 1, 2], [0, 2, 3], [0, 4, 1]], np.uint32))
    assert len(source) == 7  # four of the quad, three of the wall
    np.testing.assert_allclose(normals[triangles[:2]].reshape(-1, 3), np.tile([0, 0, 1], (6, 1)), atol=1e-6)
    np.testing.assert_allclose(normals[triangles[2]], np.tile([0, 1, 0], (3, 1)), atol=1e-6)
    assert source[triangles].tolist() == [[0, 1, 2], [0, 2, 3], [0, 4, 1]]


def test_missing_normals_are_filled_from_the_faces() -> None:
    quad = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0]], np.float32)
    given_normals = np.array([[0, 1, 0], [0, 0, 0], [0, 0, 0]], np.float32)
    filled = fill_normals(given_normals, quad, np.array([[0, 1, 2]], np.uint32))
    np.testing.assert_allclose(filled, [[0, 1, 0], [0, 0, 1], [0, 0, 1]], atol=1e-6)


def test_unit_survives_extremes() -> None:
    values = np.array([[1e300, 0, 0], [0, 1e-300, 0], [0, 0, 0], [np.nan, 1, 0], [np.inf, 0, 0]])
    expected = [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 1], [0, 0, 1]]
    np.testing.assert_allclose(unit(values, (0, 0, 1)), expected)


def test_influences_sorted_and_summing_to_one() -> None:
    result = normalise_influences(np.array([[3, 1, 2, 9]]), np.array([[0.1, 0.6, 0.3, 0.0]]))
    assert result.joints.tolist() == [[1, 2, 3, 0]]
    assert result.weights.sum() == 65535
    assert result.renormalised == result.without_weight == result.cut == 0
    np.testing.assert_allclose(result.weights[0] / 65535, [0.6, 0.3, 0.1, 0], atol=1e-5)


def test_influences_of_bad_sums_are_counted() -> None:
    weights = np.array([[0.2, 0.2, 0, 0], [0, 0, 0, 0], [np.nan, 1, 0, 0], [0.5, 0.5, 0, 0]])
    result = normalise_influences(np.tile(np.arange(4), (4, 1)), weights)
    assert (result.renormalised, result.without_weight) == (1, 1)
    assert (result.weights.astype(int).sum(axis=1) == 65535).all()
    assert result.weights[1].tolist() == [65535, 0, 0, 0]


def test_nine_influences_become_eight() -> None:
    result = normalise_influences(np.arange(12)[None], np.linspace(0.2, 0.01, 12)[None])
    assert result.joints.shape == (1, 8)
    assert result.cut == 1
    assert result.joints[0].tolist() == list(range(8))


@given(st.lists(st.lists(st.floats(0, 1), min_size=4, max_size=8), min_size=1, max_size=5))
def test_weights_always_sum_to_one(rows: list[list[float]]) -> None:
    width = max(map(len, rows))
    weights = np.array([row + [0.0] * (width - len(row)) for row in rows])
    result = normalise_influences(np.tile(np.arange(width), (len(rows), 1)), weights)
    assert (result.weights.astype(int).sum(axis=1) == 65535).all()


def test_quantisation_ends_and_rejects() -> None:
    assert snorm16([-2, -1, 0, 1, 2, np.nan, np.inf]).tolist() == [-32767, -32767, 0, 32767, 32767, 0, 0]
    assert unorm16([-1, 0, 0.5, 1, 9, np.nan]).tolist() == [0, 0, 32768, 65535, 65535, 0]
