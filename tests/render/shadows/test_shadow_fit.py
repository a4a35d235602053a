"""Cascades: they hold what they must, stand still in the world, and are few where few do."""

from __future__ import annotations

import math

import numpy as np
import pytest

from engine.math.transform import look_at
from engine.render.camera import Camera
from engine.render.shadows.fit import GRID, MARGIN, WORTHWHILE, Boxes, Cascade, boxes_of, casts_into, fit_cascades
from engine.render.shadows.light_space import light_from_world

SUN = (0.4, -1.0, 0.2)
ASPECT = 1.5


def boxes(camera: Camera, axes: np.ndarray, centers: np.ndarray, radii: np.ndarray) -> Boxes:
    centers = np.asarray(centers, np.float64).reshape(-1, 3)
    return boxes_of(centers, np.asarray(radii, np.float64), axes, camera.position, -camera.world_from_camera[:3, 2])


def fit(camera: Camera, centers: object, radii: object, sun: object = SUN, **options: float) -> list[Cascade]:
    axes = light_from_world(sun)
    bodies = boxes(camera, axes, np.asarray(centers, np.float64), np.asarray(radii, np.float64))
    given = {"count": 3, "size": 1024, "weight": 0.8, "distance": 0.0, **options}
    return fit_cascades(camera, ASPECT, axes, bodies, bodies, **given)  # type: ignore[arg-type]  # ints among them


def street(n: int = 400) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(3)
    return rng.uniform((-60, 0, -200), (60, 3, 5), (n, 3)), rng.uniform(0.2, 2.0, n)


CAMERA = Camera(look_at((0.0, 2.0, 10.0), (3.0, 1.0, -40.0)), 0.9, znear=0.1)


def test_nothing_seen_or_nothing_that_casts_gives_no_cascade() -> None:
    axes = light_from_world(SUN)
    none = boxes(CAMERA, axes, np.zeros((0, 3)), np.zeros(0))
    some = boxes(CAMERA, axes, np.zeros((1, 3)), np.ones(1))
    options = {"count": 3, "size": 1024, "weight": 0.8, "distance": 0.0}
    assert fit_cascades(CAMERA, ASPECT, axes, none, some, **options) == []  # type: ignore[arg-type]
    assert fit_cascades(CAMERA, ASPECT, axes, some, none, **options) == []  # type: ignore[arg-type]
    assert fit(CAMERA, [[0, 0, 100]], [1.0]) == []  # behind the camera
    assert fit(CAMERA, [[0, 0, -100]], [1.0], distance=20.0) == []  # further than shadows go


def test_every_receiver_in_the_view_is_in_the_last_cascade() -> None:
    centers, radii = street()
    cascades = fit(CAMERA, centers, radii)
    axes = light_from_world(SUN)
    clip = CAMERA.clip_from_world(ASPECT) @ np.append(centers, np.ones((len(centers), 1)), 1).T
    seen = (np.abs(clip[:2]) <= clip[3]).all(axis=0) & (clip[3] > CAMERA.znear)
    at = centers[seen] @ axes.T
    last = cascades[-1]
    inside = last.half_width - MARGIN * last.texel
    assert seen.sum() > 50
    assert (np.abs(at[:, :2] - (last.x, last.y)) <= inside).all()
    assert ((at[:, 2] >= last.bottom) & (at[:, 2] <= last.top)).all()


def test_cascades_grow_and_small_gains_are_left_out() -> None:
    cascades = fit(CAMERA, *street(), count=8)
    widths = np.array([c.half_width for c in cascades])
    assert len(cascades) >= 3
    assert (widths[:-1] < WORTHWHILE * widths[1:]).all()
    one = fit(CAMERA, [[0, 1, -40]], [0.5], count=8)  # a lone ball: every cascade would be the same
    assert len(one) == 1
    assert 0.5 < one[0].half_width < 0.65


def test_a_cascade_moves_in_whole_texels_and_rarely() -> None:
    """Walking 2.7 m in steps of a seventh of a texel: squares stay, or jump by whole texels of an unchanged grid."""
    centers, radii = street()
    before = fit(CAMERA, centers, radii)
    step, changes = before[0].texel / 7 * np.array([0.6, 0.0, -0.8]), 0
    for i in range(1, 400):
        camera = Camera(CAMERA.world_from_camera.copy(), 0.9, znear=0.1)
        camera.world_from_camera[:3, 3] += i * step
        after = fit(camera, centers, radii)
        for a, b in zip(before, after, strict=True):
            changes += a != b
            if a.half_width == b.half_width:
                grid = a.texel * (1024 // GRID)
                for moved in (b.x - a.x, b.y - a.y):
                    assert moved / grid == pytest.approx(round(moved / grid), abs=1e-6)
        before = after
    assert changes < 24  # of 1200


def test_the_grid_stands_still_in_the_world_also_far_from_its_origin() -> None:
    for shift in ((0.0, 0.0, 0.0), (1e6, -2e6, 1e6)):
        camera = Camera(CAMERA.world_from_camera.copy(), 0.9, znear=0.1)
        camera.world_from_camera[:3, 3] += shift
        centers, radii = street()
        for c in fit(camera, centers + shift, radii):
            assert c.x / c.texel == pytest.approx(round(c.x / c.texel), abs=1e-4)
            assert c.y / c.texel == pytest.approx(round(c.y / c.texel), abs=1e-4)


@pytest.mark.parametrize("scale", [1e-4, 1.0, 1e4])
def test_scale_changes_nothing_but_the_scale(scale: float) -> None:
    """Sizes lie on a ladder of eighths of an octave, so a scene 10^4 times larger may land up to one step apart."""
    centers, radii = street()
    one = fit(CAMERA, centers, radii)
    camera = Camera(CAMERA.world_from_camera.copy(), 0.9, znear=0.1 * scale)
    camera.world_from_camera[:3, 3] *= scale
    scaled = fit(camera, centers * scale, radii * scale)
    assert len(scaled) == len(one)
    for a, b in zip(one, scaled, strict=True):
        assert abs(math.log2(b.half_width / a.half_width / scale)) < 1 / 8 + 1e-6


def test_what_only_stands_towards_the_sun_casts_too() -> None:
    cascade = Cascade(0.0, 0.0, 10.0, -5.0, 5.0, 0.01)
    centers = [[0, 0, 0], [0, 0, 1e5], [0, 0, -7], [0, 0, -5.5], [11, 0, 0], [10.5, 0, 0], [0, -30, 0]]
    bodies = boxes_of(np.array(centers, np.float64), np.full(7, 0.9), np.eye(3))
    assert casts_into(cascade, bodies).tolist() == [True, True, False, True, False, True, False]


@pytest.mark.parametrize("sun", [(0, -1, 0), (1, 0, 0), (0, 1, 0), (1e-7, -1, 0)])
@pytest.mark.parametrize(
    "bodies", [([[0, 0, 0]], [0.0]), ([[0, 0, -1e6]], [10.0]), ([[0, 1, 0], [0, 0, -1e6]], [1, 1])]
)
def test_extreme_scenes_give_finite_cascades(
    sun: tuple[float, ...], bodies: tuple[list[list[float]], list[float]]
) -> None:
    camera = Camera(look_at((0.0, 2.0, 10.0), (0.0, 1.0, -40.0)), 0.9, znear=1e-3)
    cascades = fit(camera, *bodies, sun=sun, count=4)
    assert cascades
    for c in cascades:
        values = (c.x, c.y, c.half_width, c.bottom, c.top, c.texel)
        assert all(math.isfinite(v) for v in values)
        assert c.half_width > 0.0
        assert c.top > c.bottom
