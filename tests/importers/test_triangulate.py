"""Polygons of every shape: area kept, winding kept, k - 2 triangles each."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from importers.geometry.triangulate import newell_normals, triangulate


def one(points: list[tuple[float, ...]]) -> np.ndarray:
    p = np.array([(*q, 0.0)[:3] for q in points], float)
    triangles, owner = triangulate(p, np.array([0]), np.array([len(p)]))
    assert triangles.shape == (len(p) - 2, 3)
    assert (owner == 0).all()
    return triangles


def areas(points: list[tuple[float, ...]], triangles: np.ndarray) -> np.ndarray:
    p = np.array([(*q, 0.0)[:3] for q in points], float)[triangles]
    return np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])[:, 2] / 2


def shoelace(points: list[tuple[float, ...]]) -> float:
    x, y = np.array(points, float)[:, :2].T
    return float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2)


ARROW = [(0, 0), (2, 1), (0, 2), (0.5, 1)]
L = [(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)]
COMB = [(0, 0), (7, 0), (7, 3), (6, 3), (6, 1), (5, 1), (5, 3), (4, 3), (4, 1), (3, 1), (3, 3), (0, 3)]
STAR = [(np.cos(a) * r, np.sin(a) * r) for a, r in zip(np.arange(10) * np.pi / 5, [2.0, 0.7] * 5, strict=True)]


@pytest.mark.parametrize("points", [ARROW, L, COMB, STAR, [(0, 0), (1, 0), (2, 0), (2, 2), (0, 2)]])
@pytest.mark.parametrize("shift", range(4))
@pytest.mark.parametrize("turned", [False, True])
def test_area_and_winding(points: list[tuple[float, float]], shift: int, turned: bool) -> None:
    points = points[shift:] + points[:shift]
    points = points[::-1] if turned else points
    found = areas(points, one(points))
    total = shoelace(points)
    assert found.sum() == pytest.approx(total)
    # no triangle turns the other way: no overlap
    assert np.abs(found).sum() == pytest.approx(abs(total))


def test_a_quad_takes_the_shorter_diagonal() -> None:
    kite = [(0, 0), (3, -0.5), (6, 0), (3, 0.5)]
    assert all({1, 3} <= set(t) for t in one(kite).tolist())
    square = one([(0, 0), (1, 0), (1, 1), (0, 1)])
    assert square.tolist() == [[0, 1, 2], [0, 2, 3]]  # a tie: the first, every time


def test_polygons_of_any_plane_and_order() -> None:
    rng = np.random.default_rng(5)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    shapes = [ARROW, L, [(0, 0), (1, 0), (0, 1)], STAR, COMB]
    points = np.concatenate([np.array([(x, y, k) for x, y in shape]) for k, shape in enumerate(shapes)]) @ turn.T
    count = np.array([len(s) for s in shapes])
    first = np.cumsum(count) - count
    triangles, owner = triangulate(points, first, count)
    assert owner.tolist() == sorted(owner.tolist())
    assert np.bincount(owner).tolist() == [len(s) - 2 for s in shapes]
    for k, shape in enumerate(shapes):
        p = points[triangles[owner == k]]
        normal = newell_normals(points[first[k] : first[k] + count[k]][None])[0]
        found = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]) @ normal / 2
        assert (found > -1e-12).all()
        assert found.sum() == pytest.approx(abs(shoelace(shape)))


def test_polygons_without_area_keep_their_triangles() -> None:
    for points in ([(0, 0)] * 5, [(0, 0), (1, 0), (2, 0), (3, 0), (4, 0), (5, 0)], [(0, 0), (1, 1)] * 4):
        assert areas(points, one(points)).sum() == pytest.approx(0.0)
    assert len(triangulate(np.zeros((0, 3)), np.zeros(0, int), np.zeros(0, int))[0]) == 0
    bad = np.array([[0, 0, 0], [np.nan, 0, 0], [1, 1, 0], [0, np.inf, 0], [0, 1, 0]])
    assert triangulate(bad, np.array([0]), np.array([5]))[0].shape == (3, 3)


@given(st.lists(st.tuples(st.integers(-9, 9), st.integers(-9, 9), st.integers(-9, 9)), min_size=3, max_size=12))
@settings(deadline=None, max_examples=150)
def test_any_corners_give_their_triangles(points: list[tuple[int, int, int]]) -> None:
    triangles, _ = triangulate(np.array(points, float), np.array([0]), np.array([len(points)]))
    assert triangles.shape == (len(points) - 2, 3)
    assert triangles.min() >= 0
    assert triangles.max() < len(points)
