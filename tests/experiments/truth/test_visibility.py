"""Rays where the answer is known: half a sun behind an edge, a sphere over a point, a wall beside it."""

from __future__ import annotations

import math

import numpy as np
import pytest

pytest.importorskip("embreex")

from engine.assets.primitives import card, plane, uv_sphere
from engine.core.errors import LucarnaError
from engine.experiments.shadow_filter import cut_area
from engine.experiments.truth import rays as rays_module
from engine.experiments.truth.rays import Rays
from engine.experiments.truth.visibility import ambient_occlusion, sun_visibility
from tests.experiments.truth import stage

UP = np.array([0.0, 1.0, 0.0])


def test_hits_are_where_they_should_be() -> None:
    shapes = stage.triangles(plane(2.0), move=(1e5, 3.0, 0.0))
    rays = Rays(shapes.corners)
    start = np.array([[1e5 + 0.3, 5.0, 0.2], [1e5 + 3.0, 5.0, 0.0]])
    down = np.tile(-UP, (2, 1))
    hits = rays.nearest(start, down)
    assert hits.triangle[0] >= 0
    assert hits.triangle[1] == -1
    assert hits.distance[0] == pytest.approx(2.0, abs=1e-6)
    w = np.array([1.0 - hits.u[0] - hits.v[0], hits.u[0], hits.v[0]])
    np.testing.assert_allclose(w @ shapes.corners[hits.triangle[0]], [1e5 + 0.3, 3.0, 0.2], atol=1e-6)
    assert rays.blocked(start, down).tolist() == [True, False]
    assert rays.blocked(start, down, np.array([1.9, 9.0])).tolist() == [False, False]


def test_nothing_blocks_nothing() -> None:
    rays = Rays(np.zeros((0, 3, 3)))
    assert rays.nearest(np.zeros((2, 3)), np.tile(UP, (2, 1))).triangle.tolist() == [-1, -1]
    assert not rays.blocked(np.zeros((2, 3)), np.tile(UP, (2, 1))).any()


def test_a_disc_cut_by_an_edge() -> None:
    """A card above covers all of the sun on one side of its edge: what is left is the cut disc's area."""
    shapes = stage.triangles(plane(10.0), move=(5.0, 2.0, 0.0))  # its edge runs along x = 0
    half = math.radians(10.0)
    reach = 2.0 * math.tan(half)
    x = np.linspace(-1.2, 1.2, 25) * reach
    places = np.stack([x, np.zeros_like(x), np.zeros_like(x)], axis=1)
    seen = sun_visibility(Rays(shapes.corners), places, np.tile(UP, (25, 1)), UP, half, 1024, np.random.default_rng(1))
    np.testing.assert_allclose(seen, cut_area(-x / reach), atol=0.01)
    hard = sun_visibility(Rays(shapes.corners), places, np.tile(UP, (25, 1)), UP, 0.0, 1, np.random.default_rng(1))
    assert (hard == (x < 0.0)).all() or (hard[x != 0.0] == (x < 0.0)[x != 0.0]).all()


def test_turned_away_is_dark() -> None:
    rays = Rays(stage.triangles(plane(1.0), move=(0.0, 50.0, 0.0)).corners)
    seen = sun_visibility(rays, np.zeros((1, 3)) + 9.0, -UP[None], UP, 0.01, 16, np.random.default_rng(1))
    assert seen.tolist() == [0.0]


def test_a_sphere_above_hides_its_form_factor() -> None:
    """A sphere of radius R straight above at distance D takes (R / D)^2 of a cosine-weighted hemisphere."""
    rays = Rays(stage.triangles(uv_sphere(1.0, 96, 192), move=(0.0, 2.5, 0.0)).corners)
    many = np.zeros((64, 3))
    got = ambient_occlusion(rays, many, np.tile(UP, (64, 1)), 1024, np.random.default_rng(3))
    assert float(got.mean()) == pytest.approx(1.0 - (1.0 / 2.5) ** 2, abs=2e-3)
    near = ambient_occlusion(rays, many[:4], np.tile(UP, (4, 1)), 256, np.random.default_rng(3), reach=1.0)
    assert (near == 1.0).all(), "nothing is that near"


def test_a_wall_beside_a_floor() -> None:
    """A wall of height H at distance d hides half of 1 - d / sqrt(d^2 + H^2) (a wide one)."""
    height, d = 1.0, 0.7
    wall = stage.triangles(card(1.0), scale=1.0)
    wall.corners = wall.corners * np.array([2000.0, height, 1.0]) + np.array([0.0, height / 2.0, -d])
    got = ambient_occlusion(Rays(wall.corners), np.zeros((64, 3)), np.tile(UP, (64, 1)), 1024, np.random.default_rng(3))
    assert float(got.mean()) == pytest.approx((1.0 + d / math.hypot(d, height)) / 2.0, abs=2e-3)


def test_without_embree_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rays_module, "missing", lambda: "no embreex")
    with pytest.raises(LucarnaError, match="embreex") as caught:
        Rays(np.zeros((0, 3, 3)))
    assert "pip install" in str(caught.value.hint)
