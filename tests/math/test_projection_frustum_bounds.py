from __future__ import annotations

import math

import numpy as np
import pytest

from engine.core.errors import InputError
from engine.math import bounds, frustum, projection, quat, transform


def project(m: np.ndarray, point: list[float]) -> np.ndarray:
    clip = m @ [*point, 1.0]
    return clip[:3] / clip[3]


def test_perspective_known_points() -> None:
    m = projection.perspective_reversed(math.pi / 2, 2.0, 0.1)
    assert np.allclose(project(m, [0, 0, -0.1]), [0, 0, 1])
    assert np.allclose(project(m, [20, 10, -10]), [1, 1, 0.01])
    assert 0 < project(m, [0, 0, -1e9])[2] < 1e-9


def test_depth_tells_near_planes_apart_at_any_distance() -> None:
    m = projection.perspective_reversed(1.0, 1.0, 1e-3)
    for z in (1.0, 1e2, 1e5):
        assert np.float32(project(m, [0, 0, -z])[2]) > np.float32(project(m, [0, 0, -z * (1 + 1e-6)])[2])


def test_orthographic_known_points() -> None:
    m = projection.orthographic_reversed(2.0, 1.5, -1.0, 9.0)
    assert np.allclose(project(m, [3, 2, 1]), [1, 1, 1])
    assert np.allclose(project(m, [-3, -2, -9]), [-1, -1, 0])


@pytest.mark.parametrize("bad", [(0, 1, 0.1), (math.pi, 1, 0.1), (1, 0, 0.1), (1, 1, 0), (1, math.nan, 0.1)])
def test_impossible_lens(bad: tuple[float, float, float]) -> None:
    with pytest.raises(InputError, match="impossible camera"):
        projection.perspective_reversed(*bad)


def test_empty_orthographic_box() -> None:
    with pytest.raises(InputError, match="zfar"):
        projection.orthographic_reversed(1.0, 1.0, 5.0, 5.0)


@pytest.mark.parametrize("perspective", [True, False])
@pytest.mark.parametrize("offset", [0.0, 1e6])
def test_points_in_clip_space_are_inside_the_planes(perspective: bool, offset: float) -> None:
    rng = np.random.default_rng(3)
    world_from_camera = transform.look_at(np.array([1.0, 2, 3]) + offset, np.array([-4.0, 0, 1]) + offset)
    lens = (
        projection.perspective_reversed(0.9, 1.7, 0.5)
        if perspective
        else projection.orthographic_reversed(3.0, 1.7, 0.5, 40.0)
    )
    clip_from_world = lens @ transform.inverse_affine(world_from_camera)
    planes = frustum.planes_from_matrix(clip_from_world)
    assert np.allclose(np.linalg.norm(planes[:5, :3], axis=1), 1.0)
    points = rng.normal(size=(2000, 3)) * 20 + offset
    clip = np.concatenate([points, np.ones((2000, 1))], axis=1) @ clip_from_world.T
    w = clip[:, 3]
    inside = (np.abs(clip[:, 0]) <= w) & (np.abs(clip[:, 1]) <= w) & (clip[:, 2] >= 0) & (clip[:, 2] <= w)
    margin = np.min(points @ planes[:, :3].T + planes[:, 3], axis=1)
    clear = np.abs(margin) > 1e-6
    assert inside.any()
    assert np.array_equal(frustum.spheres_visible(planes, points, np.zeros(2000))[clear], inside[clear])


def test_spheres_touching_from_outside() -> None:
    planes = frustum.planes_from_matrix(projection.perspective_reversed(math.pi / 2, 1.0, 1.0))
    centers = [[0, 0, 1], [0, 0, 1], [0, 0, -5], [0, 0, -1e12], [math.nan, 0, -5]]
    assert frustum.spheres_visible(planes, centers, [1.9, 2.1, 0.0, 0.0, 1.0]).tolist() == [
        False, True, True, True, False,
    ]  # fmt: skip


def test_corners_project_back() -> None:
    m = projection.perspective_reversed(1.0, 2.0, 0.1)
    corner = frustum.corners(np.linalg.inv(m), far_depth=0.01)
    assert np.allclose(corner[:4, 2], -0.1)
    assert np.allclose(corner[4:, 2], -10.0)


def test_transformed_box_holds_transformed_points() -> None:
    rng = np.random.default_rng(5)
    m = transform.compose([1, 2, 3], quat.normalize(rng.normal(size=4)), [2, -1, 0.5])
    points = rng.uniform(-1, 1, size=(500, 3))
    low, high = bounds.transform_box(m, *bounds.of_points(points))
    moved = points @ m[:3, :3].T + m[:3, 3]
    assert (moved >= low - 1e-12).all()
    assert (moved <= high + 1e-12).all()


def test_largest_scale_is_exact_for_trs_and_safe_for_shear() -> None:
    rng = np.random.default_rng(6)
    q = quat.normalize(rng.normal(size=(50, 4)))
    s = rng.uniform(-3, 3, size=(50, 3))
    trs = quat.to_matrix3(q) * s[:, None, :]
    assert np.allclose(bounds.largest_scale(trs), np.abs(s).max(axis=1))
    sheared = rng.normal(size=(50, 3, 3))
    sigma = np.linalg.svd(sheared, compute_uv=False)[:, 0]
    assert (bounds.largest_scale(sheared) >= sigma - 1e-12).all()
    assert (bounds.largest_scale(sheared) <= sigma * math.sqrt(3)).all()


def test_transformed_sphere_known() -> None:
    m = transform.compose([10, 0, 0], quat.from_axis_angle([0, 0, 1], math.pi / 2), [1, 2, 3])
    center, radius = bounds.transform_sphere(m, [1, 0, 0], 2.0)
    assert np.allclose(center, [10, 1, 0])
    assert radius == pytest.approx(6.0)


def test_boxes_of_nothing_and_of_nan() -> None:
    assert np.array_equal(bounds.of_points(np.zeros((0, 3)))[0], [0, 0, 0])
    low, high = bounds.of_points([[math.nan, 0, 0], [1, 2, 3]])
    assert np.array_equal(low, high)
    low, high = bounds.of_spheres([[0, 0, 0], [5, 0, 0], [math.inf, 0, 0]], [1, 2, 3])
    assert np.array_equal(low, [-1, -2, -2])
    assert np.array_equal(high, [7, 2, 2])
    center, radius = bounds.sphere_of_box([0, 0, 0], [2, 4, 4])
    assert np.array_equal(center, [1, 2, 2])
    assert radius == 3.0
