"""Weighted blends: known answers, and every row of the stability table that is about blending."""

from __future__ import annotations

import math

import numpy as np
import pytest

from engine.animation import poses
from engine.animation.blend import CURVES, BlendJob, fade, shares
from engine.core.errors import InputError
from tests.animation.crowd import IDENTITY, angle, assert_same_pose, random_poses, rig, turning


def blend(inputs: list[np.ndarray], weights: object, method: str = "nlerp") -> np.ndarray:
    out = np.full_like(inputs[0], np.nan)
    weights = np.array(weights, np.float64)
    if weights.ndim == 1:
        weights = np.repeat(weights[:, None], inputs[0].shape[1], axis=1)
    job = BlendJob(inputs, weights, rig(inputs[0].shape[2]).rest, out, method)
    job.validate()
    job.run()
    return out


def rotated(q: np.ndarray) -> np.ndarray:
    pose = poses.resting(rig(1).rest, 1)
    pose[poses.R] = q[:, None, None]
    return pose


def test_two_by_hand() -> None:
    rng = np.random.default_rng(0)
    a, b = random_poses(rng, 3, 4), random_poses(rng, 3, 4)
    got = blend([a, b], [1.0, 3.0], "slerp")
    np.testing.assert_allclose(got[0:3], 0.25 * a[0:3] + 0.75 * b[0:3], atol=1e-12)
    np.testing.assert_allclose(got[7:], 0.25 * a[7:] + 0.75 * b[7:], atol=1e-12)
    whole = angle(a[3:7], b[3:7])
    np.testing.assert_allclose(angle(a[3:7], got[3:7]), 0.75 * whole, atol=1e-9)
    np.testing.assert_allclose(angle(got[3:7], b[3:7]), 0.25 * whole, atol=1e-9)


def test_weights_of_one_give_that_input_whatever_the_order() -> None:
    rng = np.random.default_rng(1)
    inputs = [random_poses(rng, 2, 5) for _ in range(4)]
    for method in ("nlerp", "slerp"):
        for i in range(4):
            got = blend(inputs, np.eye(4)[i], method)
            assert_same_pose(got, inputs[i])
    weights = np.array([0.1, 0.2, 0.3, 0.4])
    forth, back = blend(inputs, weights), blend(inputs[::-1], weights[::-1])
    assert angle(forth[3:7], back[3:7]).max() < 1e-9
    np.testing.assert_allclose(forth[:3], back[:3], atol=1e-12)


def test_the_spherical_mean_of_turns_about_one_axis_is_the_mean_angle() -> None:
    angles, weights = np.array([0.1, 0.9, 1.4, -0.3]), np.array([0.4, 0.1, 0.2, 0.3])
    got = blend([rotated(turning(1, a)) for a in angles], weights, "slerp")
    assert 2.0 * math.atan2(got[4, 0, 0], got[6, 0, 0]) == pytest.approx(float(angles @ weights), abs=1e-9)


def test_nlerp_is_off_slerp_by_the_published_angles() -> None:
    for degrees, most in ((30, 0.033), (60, 0.27), (90, 0.92), (120, 2.2), (170, 6.8)):
        a, b = rotated(IDENTITY), rotated(turning(0, math.radians(degrees)))
        worst = max(
            float(angle(blend([a, b], [1 - u, u])[3:7], blend([a, b], [1 - u, u], "slerp")[3:7]).max())
            for u in np.linspace(0, 1, 41)
        )
        assert math.degrees(worst) == pytest.approx(most, rel=0.05)


@pytest.mark.parametrize("method", ["nlerp", "slerp"])
def test_the_row_antipodal_double_cover(method: str) -> None:
    q = turning(0, 1.1)
    for others in ([], [rotated(q)]):
        got = blend([rotated(q), rotated(-q), *others], [0.5, 0.5, 0.3][: 2 + len(others)], method)
        assert angle(got[3:7, 0, 0], q) < 1e-12
    # half turns about x and -x: 180 degrees apart on neither side
    apart = blend([rotated(turning(0, math.pi / 2)), rotated(turning(0, -math.pi / 2))], [0.5, 0.5], method)
    np.testing.assert_allclose(np.linalg.norm(apart[3:7], axis=0), 1.0, atol=1e-12)
    # four rotations that cancel: the heaviest stands
    corners = [rotated(v) for v in np.eye(4)]
    even = blend(corners, [1.0, 1.0, 1.0, 1.0], method)
    np.testing.assert_allclose(np.linalg.norm(even[3:7], axis=0), 1.0, atol=1e-12)


def test_opposite_quaternions_that_cancel_give_the_heaviest() -> None:
    # no sign can help here: both are at right angles to the pivot in 4-space, and cancel
    a = np.array([1.0, 0.0, 0.0, 0.0])
    b = np.array([-0.5, math.sqrt(0.75), 0.0, 0.0])
    c = np.array([-0.5, -math.sqrt(0.75), 0.0, 0.0])
    got = blend([rotated(a), rotated(b), rotated(c)], [0.34, 0.33, 0.33])
    assert np.isfinite(got).all()
    np.testing.assert_allclose(np.linalg.norm(got[3:7], axis=0), 1.0, atol=1e-12)
    np.testing.assert_array_equal(poses.unit(np.full((4, 1), 1e-5), a[:, None]), a[:, None])


@pytest.mark.parametrize("method", ["nlerp", "slerp"])
@pytest.mark.parametrize("weights", [(0, 0), (-1, 0), (1e-7, 2e-7), (math.nan, math.nan), (math.inf, -1), (-1, -3)])
def test_the_row_weights_sum_0_is_the_rest_pose(weights: tuple[float, float], method: str) -> None:
    rng = np.random.default_rng(2)
    got = blend([random_poses(rng, 2, 3), random_poses(rng, 2, 3)], weights, method)
    np.testing.assert_array_equal(got, poses.resting(rig(3).rest, 2))


def test_the_row_negative_weights_count_as_0() -> None:
    rng = np.random.default_rng(2)
    a, b = random_poses(rng, 2, 3), random_poses(rng, 2, 3)
    assert_same_pose(blend([a, b], [-1.0, 1.0]), b)


def test_huge_weights_do_not_overflow() -> None:
    part, empty = shares(np.array([[1e308], [1e308], [1e308]]))
    np.testing.assert_allclose(part, 1 / 3)
    assert not empty.any()


def test_masks_blend_node_by_node() -> None:
    rng = np.random.default_rng(4)
    a, b = random_poses(rng, 2, 3), random_poses(rng, 2, 3)
    weights = np.zeros((2, 2, 3))
    weights[0, :, 0], weights[1, :, 1] = 1.0, 1.0
    got = blend([a, b], weights)
    assert_same_pose(got[:, :, 0], a[:, :, 0])
    assert_same_pose(got[:, :, 1], b[:, :, 1])
    np.testing.assert_array_equal(got[:, :, 2], poses.resting(rig(3).rest, 2)[:, :, 2])


@pytest.mark.parametrize("curve", CURVES)
def test_fade_curves_run_from_0_to_1_and_never_back(curve: str) -> None:
    x = np.linspace(-0.5, 1.5, 201)
    y = fade(x, curve)
    assert y[x <= 0].max() == 0.0
    assert y[x >= 1].min() == 1.0
    assert (np.diff(y) >= 0.0).all()
    assert fade(np.nan, curve) == 1.0
    if curve in ("linear", "smooth", "smoother"):
        assert fade(0.5, curve) == pytest.approx(0.5)


def test_a_job_says_what_does_not_fit() -> None:
    pose, rest = np.zeros((10, 2, 3)), rig(3).rest
    for inputs, weights, method, words in (
        ([], np.zeros((0, 2)), "nlerp", "nothing to blend"),
        ([pose, np.zeros((10, 2, 2))], np.zeros((2, 2)), "nlerp", r"inputs\[1\]"),
        ([pose], np.zeros((2, 2)), "nlerp", "weights have shape"),
        ([pose], np.zeros((1, 2)), "squad", "unknown method"),
    ):
        with pytest.raises(InputError, match=words):
            BlendJob(inputs, weights, rest, pose, method).validate()  # type: ignore[arg-type]  # wrong on purpose
    with pytest.raises(InputError, match="rest has shape"):
        BlendJob([pose], np.zeros((1, 2)), rest[:, :2], pose).validate()
    with pytest.raises(InputError, match="unknown fade curve"):
        fade(0.5, "bouncy")
