"""Sampling many characters at once against one channel at a time."""

from __future__ import annotations

import numpy as np
import pytest

from engine.animation import poses
from engine.animation.rig import moved_nodes, rig_of
from engine.animation.sample import ClipPlayer
from engine.animation.sampler import ClipSampler, SampleJob
from engine.assets.clip import ClipAsset
from engine.core.errors import InputError
from tests.animation.crowd import (
    IDENTITY,
    angle,
    chain,
    channel,
    random_clip,
    random_rotations,
    rig,
    sampler,
    turning,
)


@pytest.mark.parametrize("shared", [True, False])
@pytest.mark.parametrize("interpolation", ["step", "linear", "cubic"])
def test_agrees_with_the_player_channel_by_channel(interpolation: str, shared: bool) -> None:
    rng = np.random.default_rng(3)
    clip = random_clip(rng, 12, shared=shared, interpolation=interpolation)
    keys = np.unique(np.concatenate([c.times for c in clip.channels])).astype(np.float64)
    times = np.concatenate([rng.uniform(-0.5, 2.5, 40), keys, [-1e9, 1e12]])
    out = poses.resting(rig(12).rest, len(times))
    job = SampleJob(ClipSampler(clip, rig(12)), times, out)
    job.validate()
    job.run()
    player = ClipPlayer(clip, np.arange(12))
    for i, time in enumerate(times):
        for path, rows, values in player.sample(float(time), "once"):
            got = out[poses.ROWS[path], i][:, rows]
            if path == "rotation":
                # q and -q are the same rotation
                assert angle(got, values.T).max() < 1e-7
                np.testing.assert_allclose(np.linalg.norm(got, axis=0), 1.0, atol=1e-8)
            else:
                np.testing.assert_allclose(got, values.T, atol=1e-9)


def test_the_row_t_huge_or_not_a_number_holds_the_ends() -> None:
    clip = ClipAsset("c", [channel(0, "translation", [0.5, 1.0], [[1, 0, 0], [2, 0, 0]])])
    out = poses.resting(rig(1).rest, 5)
    ClipSampler(clip, rig(1)).sample([-1e9, 1e12, np.nan, np.inf, -np.inf], out)
    np.testing.assert_array_equal(out[0, :, 0], [1.0, 2.0, 1.0, 2.0, 1.0])


def test_the_row_zero_one_and_equal_keys() -> None:
    clip = ClipAsset(
        "c",
        [
            channel(0, "translation", [], np.zeros((0, 3))),
            channel(1, "translation", [0.3], [[5, 0, 0]]),
            channel(2, "translation", [0.0, 0.5, 0.5, 1.0], [[0, 0, 0], [1, 0, 0], [3, 0, 0], [3, 0, 0]], "step"),
        ],
    )
    sampler = ClipSampler(clip, rig(3))
    out = poses.resting(rig(3).rest, 3)
    sampler.sample([0.0, 0.5, 2.0], out)
    np.testing.assert_array_equal(out[0], [[0, 5, 0], [0, 5, 3], [0, 5, 3]])
    assert {f.code for f in sampler.findings} == {"clip.empty", "clip.order"}
    np.testing.assert_array_equal(sampler.covers[0], [False, True, True])


def test_the_row_nan_key_leaves_the_others_alone() -> None:
    good = [channel(1, "rotation", [0, 1], [IDENTITY, turning(0, 1.0)])]
    bad = channel(0, "rotation", [0, 1], [[np.nan] * 4, turning(1, 2.0)])
    out, alone = poses.resting(rig(2).rest, 7), poses.resting(rig(2).rest, 7)
    times = np.linspace(0, 1, 7)
    ClipSampler(ClipAsset("c", [bad, *good]), rig(2)).sample(times, out)
    ClipSampler(ClipAsset("c", good), rig(2)).sample(times, alone)
    assert np.isfinite(out).all()
    np.testing.assert_array_equal(out[:, :, 1], alone[:, :, 1])


@pytest.mark.parametrize("size", [1e-30, 1e-6, 1.0, 1e30])
def test_the_row_non_unit_q_gives_the_same_pose(size: float) -> None:
    keys = np.array([IDENTITY, turning(2, 1.2)])
    out, unit = poses.resting(rig(1).rest, 5), poses.resting(rig(1).rest, 5)
    times = np.linspace(0, 1, 5)
    ClipSampler(ClipAsset("c", [channel(0, "rotation", [0, 1], keys * size)]), rig(1)).sample(times, out)
    ClipSampler(ClipAsset("c", [channel(0, "rotation", [0, 1], keys)]), rig(1)).sample(times, unit)
    np.testing.assert_allclose(out, unit, atol=1e-7)


@pytest.mark.parametrize("theta", [0.0, 1e-7, 1e-5, 1e-4, 1e-3, 1.0, 3.0, np.pi])
def test_the_row_slerp_small_angle_to_pi(theta: float) -> None:
    a, b = IDENTITY[:, None], turning(1, theta)[:, None]
    for u in (0.0, 0.25, 0.5, 1.0):
        for sign in (1.0, -1.0):
            got = poses.slerp(a, sign * b, np.array([u]))
            assert angle(got, turning(1, theta * u)[:, None])[0] < 1e-9 + 1e-12


def test_a_job_says_what_does_not_fit() -> None:
    sampler = ClipSampler(ClipAsset("c"), rig(2))
    with pytest.raises(InputError, match=r"shape \(10, 3, 1\), expected \(10, 3, 2\)"):
        SampleJob(sampler, np.zeros(3), np.zeros((10, 3, 1))).validate()
    with pytest.raises(InputError, match="expected float64"):
        SampleJob(sampler, np.zeros(3), np.zeros((9, 3, 2))).validate()


def test_a_rig_keeps_the_nearest_ancestor_that_moves() -> None:
    nodes = chain(5)
    clip = ClipAsset("c", [channel(i, "rotation", [0], [IDENTITY]) for i in (4, 1)])
    made = rig_of(nodes, moved_nodes([clip], len(nodes)))
    assert (made.names, made.parent.tolist(), made.source.tolist()) == (("n1", "n4"), [-1, 0], [1, 4])
    with pytest.raises(InputError, match="did you mean 'n4'"):
        made.index("n44")
    with pytest.raises(InputError, match="nodes 3 to 9 of 5"):
        rig_of(nodes, [3, 9])


def test_bent_nlerp_is_slerp_to_a_millionth_of_a_radian() -> None:
    rng = np.random.default_rng(5)
    a = random_rotations(rng, 500)
    away = random_rotations(rng, 500)
    away -= a * poses.dot(a, away)
    away /= np.sqrt(poses.dot(away, away))
    for angle_4d in (0.0, 1e-9, 0.05, poses.BENT_LIMIT):
        b = a * np.cos(angle_4d) + away * np.sin(angle_4d)
        t = rng.uniform(size=500)
        expected = poses.slerp(a, b, t)
        got = poses.bent_nlerp(a.copy(), b.copy(), np.full(500, angle_4d**2 / 3.0), t)
        assert angle(got, expected).max() < 1e-6
        np.testing.assert_allclose(poses.dot(got, got), 1.0, atol=1e-12)


def test_a_clip_of_wide_turns_is_played_by_slerp() -> None:
    wide = ClipAsset("wide", [channel(0, "rotation", [0.0, 1.0], [turning(1, 0.0), turning(1, 2.5)])])
    made = sampler(wide)
    out = poses.resting(made.rig.rest, 1)
    made.sample([0.25], out)
    assert angle(out[poses.R][:, 0, 0], turning(1, 0.625)) < 1e-7  # float32 keys; bent it would be off by 1e-2


def test_one_character_gets_the_bits_that_a_crowd_gets() -> None:
    rng = np.random.default_rng(11)
    for interpolation in ("linear", "step", "cubic"):
        for shared in (True, False):
            asset = random_clip(rng, 6, shared=shared, interpolation=interpolation)
            sampler = ClipSampler(asset, rig(6))
            times = np.array(
                [-1.0, 0.0, 0.37, 1.0, sampler.duration, 1e12, np.nan, *rng.uniform(0, sampler.duration, 9)]
            )
            crowd = poses.resting(rig(6).rest, len(times))
            sampler.sample(times, crowd)
            for i, time in enumerate(times.tolist()):
                alone = rig(6).rest.copy()
                sampler.sample_one(time, alone)
                np.testing.assert_array_equal(alone, crowd[:, i])
