from __future__ import annotations

import numpy as np
import pytest

from engine.animation.blend_space import BlendSpace
from engine.core.errors import InputError


def test_one_dimension_is_linear_between_neighbours() -> None:
    space = BlendSpace([0.0, 4.0, 1.0])  # in any order
    got = space.weights([-1.0, 0.0, 0.25, 1.0, 2.5, 4.0, 9.0])
    np.testing.assert_allclose(got[0], [1, 1, 0.75, 0, 0, 0, 0])
    np.testing.assert_allclose(got[2], [0, 0, 0.25, 1, 0.5, 0, 0])
    np.testing.assert_allclose(got[1], [0, 0, 0, 0, 0.5, 1, 1])


@pytest.mark.parametrize("dimensions", [1, 2])
def test_shares_sum_to_1_and_each_sample_is_alone_at_its_place(dimensions: int) -> None:
    rng = np.random.default_rng(dimensions)
    points = rng.normal(size=(7, dimensions))
    space = BlendSpace(points)
    np.testing.assert_allclose(space.weights(points), np.eye(7), atol=1e-12)
    got = space.weights(rng.normal(size=(500, dimensions)) * 3.0)
    assert (got >= 0.0).all()
    np.testing.assert_allclose(got.sum(axis=0), 1.0, atol=1e-12)


def test_two_samples_in_the_plane_are_linear_between_them() -> None:
    space = BlendSpace([[0.0, 0.0], [2.0, 2.0]])
    np.testing.assert_allclose(space.weights([[0.5, 0.5], [1.0, 1.0], [1.5, 0.5]])[1], [0.25, 0.5, 0.5], atol=1e-12)


def test_the_middle_of_a_square_has_all_four() -> None:
    space = BlendSpace([[-1, -1], [1, -1], [-1, 1], [1, 1]])
    np.testing.assert_allclose(space.weights([[0.0, 0.0]])[:, 0], 0.25)


def test_weights_are_continuous() -> None:
    rng = np.random.default_rng(9)
    space = BlendSpace(rng.normal(size=(6, 2)))
    line = np.linspace(-2.0, 2.0, 4001)[:, None] * np.array([0.8, 0.6])
    assert np.abs(np.diff(space.weights(line), axis=1)).max() < 0.02


@pytest.mark.parametrize("points", [[0.0, 0.0, 1.0], [[0.0, 0.0], [0.0, 0.0], [1.0, 0.0]]])
def test_samples_at_one_place_share(points: list[object]) -> None:
    space = BlendSpace(points)
    at = [0.0] if space.dimensions == 1 else [[0.0, 0.0]]
    np.testing.assert_allclose(space.weights(at)[:, 0], [0.5, 0.5, 0.0])


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e300])
def test_what_is_not_finite_is_still_somewhere(bad: float) -> None:
    for space, at in ((BlendSpace([0.0, 1.0]), [bad]), (BlendSpace([[0, 0], [1, 0], [0, 1]]), [[bad, bad]])):
        got = space.weights(at)
        assert np.isfinite(got).all()
        assert got.sum() == pytest.approx(1.0)


@pytest.mark.parametrize("scale", [1e-4, 1e4])
def test_scale_changes_nothing(scale: float) -> None:
    rng = np.random.default_rng(0)
    points, at = rng.normal(size=(5, 2)), rng.normal(size=(50, 2))
    np.testing.assert_allclose(
        BlendSpace(points * scale).weights(at * scale), BlendSpace(points).weights(at), atol=1e-9
    )


def test_bad_spaces_say_so() -> None:
    for points, words in (
        ([], "got"),
        (np.zeros((2, 3)), "got"),
        ([0.0, np.nan], "finite places"),
        ([0.0, 1e200], "finite places"),
    ):
        with pytest.raises(InputError, match=words):
            BlendSpace(points)
    with pytest.raises(InputError, match="2 dimensions"):
        BlendSpace(np.zeros((1, 2))).weights([1.0])
