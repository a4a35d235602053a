"""One test for each way in which characters go wrong: from keys through the sampler and the nodes to the palette."""

from __future__ import annotations

import numpy as np
import pytest

from engine.animation import poses
from engine.animation.animator import Animator
from engine.animation.blend import BlendJob
from engine.animation.graph import single
from engine.animation.sample import ClipPlayer
from engine.animation.sampler import ClipSampler
from engine.animation.skinning import transform_points, vertex_matrices, vertex_matrices_dual_quaternion
from engine.assets.clip import Channel, ClipAsset
from engine.math import quat
from engine.scene.scene import Scene
from engine.scene.skins import METHODS
from tests.animation.crowd import angle, channel, random_rotations, rig, turning

F8 = np.ndarray


def hung(method: str = "linear", bind: F8 | None = None) -> tuple[Scene, list[int], int]:
    """Two joints, the second 1 m above the first, and a skin on them; the scene, the joints' rows, the skin."""
    scene = Scene()
    low = scene.nodes.add("low")
    high = scene.nodes.add("high", low, (0.0, 1.0, 0.0))
    binds = np.tile(np.eye(4), (2, 1, 1)) if bind is None else bind
    if bind is None:
        binds[1, 1, 3] = -1.0
    skin = scene.skins.add(scene.nodes.add("mesh"), [low, high], binds, [1.0, 1.0])
    scene.skins.set_method(skin, method)
    scene.update()
    return scene, [low, high], skin


def played(clip: ClipAsset, time: float, method: str = "linear", mode: str = "once") -> tuple[Scene, F8]:
    """The scene, posed, and its palette f4[2,3,4]."""
    scene, joints, _ = hung(method)
    player = ClipPlayer(clip, joints)
    player.apply(scene.nodes, time, mode)
    scene.update()
    sampler = ClipSampler(clip, rig(2))
    for crowd in (np.array([time]), np.full(9, time)):  # the ways for few and for many
        pose = poses.resting(rig(2).rest, len(crowd))
        sampler.sample(crowd, pose)
        assert np.isfinite(pose).all()
    return scene, scene.skins.palette(np.zeros(3))


def raw(times: list[float], values: list[list[float]], path: str = "rotation") -> ClipAsset:
    """A clip as no importer writes it: nothing is checked."""
    return ClipAsset("bad", [Channel(1, path, "linear", np.array(times, "f4"), np.array(values, "f4"))])


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("turn", [0.0, 1e-12, 1e-7, 3.0, np.pi - 1e-7, np.pi])
def test_slerp_near_0_and_pi(turn: float, method: str) -> None:
    scene, palette = played(
        ClipAsset("c", [channel(1, "rotation", [0, 1], [turning(2, 0.0), turning(2, turn)])]), 0.5, method
    )
    assert np.isfinite(palette).all()
    assert float(angle(scene.nodes.rotation[1], np.array(turning(2, turn / 2)))) == pytest.approx(0.0, abs=2e-7)


@pytest.mark.parametrize("weights", [[0.0, 0.0], [-1.0, -2.0], [np.nan, np.nan], [0.0, -1e300], [np.inf, -np.inf]])
def test_weights_of_nothing_are_the_rest_pose(weights: list[float]) -> None:
    rest = rig(2).rest
    moved = poses.resting(rest, 1) + 0.25
    out = np.zeros_like(moved)
    BlendJob([moved, moved * 2.0], np.array(weights)[:, None], rest, out).run()
    np.testing.assert_array_equal(out[:, 0], rest)


def test_a_negative_weight_counts_as_0() -> None:
    rest = rig(2).rest
    moved, out = poses.resting(rest, 1), np.zeros((10, 1, 2))
    moved[0] += 3.0
    BlendJob([moved, poses.resting(rest, 1)], np.array([[0.5], [-0.5]]), rest, out).run()
    np.testing.assert_allclose(out, moved, atol=1e-15)


@pytest.mark.parametrize("length", [1e-20, 1e-3, 7.0, 1e18])
def test_rotations_that_are_not_unit(length: float) -> None:
    keys = [turning(0, 0.2), turning(0, 0.9)]
    good = played(raw([0, 1], keys), 0.4)[1]
    np.testing.assert_allclose(played(raw([0, 1], (np.array(keys) * length).tolist()), 0.4)[1], good, atol=1e-6)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("scale", [[0.0, 0.0, 0.0], [1.0, 0.0, 1.0], [-1.0, 1.0, 1.0], [-2.0, -2.0, -2.0], [1e-30] * 3])
def test_bones_of_no_size_and_mirrored_ones(scale: list[float], method: str) -> None:
    """What the palette says is what the CPU's float64 truth says; a mirror stays a mirror in both."""
    scene, palette = played(raw([0.0], [scale], "scale"), 0.0, method)
    assert np.isfinite(palette).all()
    points = np.array([[0.1, 1.2, 0.3], [0.4, 1.0, -0.2]])
    world = np.tile(np.eye(4), (2, 1, 1))
    bind = np.tile(np.eye(4), (2, 1, 1))
    world[:, :3], bind[1, 1, 3] = scene.nodes.world[:2], -1.0
    joints, weights = np.array([[1, 0], [1, 0]]), np.array([[1.0, 0.0], [1.0, 0.0]])
    blend = vertex_matrices if method == "linear" else vertex_matrices_dual_quaternion
    truth = transform_points(blend(joints, weights, world @ bind), points)
    expected = (points - [0.0, 1.0, 0.0]) * scale + [0.0, 1.0, 0.0]
    np.testing.assert_allclose(truth, expected, atol=1e-9)


def test_keys_that_are_not_numbers_are_left_out() -> None:
    bad = raw([0, 1, 2], [turning(0, 0.0), [np.nan] * 4, turning(0, 1.0)])
    scene, palette = played(bad, 1.0)
    assert np.isfinite(palette).all()
    assert float(angle(scene.nodes.rotation[1], np.array(turning(0, 0.5)))) < 1e-6
    everything = raw([0, np.inf], [[np.nan] * 4, [np.inf] * 4])
    np.testing.assert_array_equal(played(everything, 0.5)[1], hung()[0].skins.palette(np.zeros(3)))


def test_times_twice_and_out_of_order() -> None:
    keys = [[0.0, 0, 0], [1.0, 0, 0], [2.0, 0, 0], [5.0, 0, 0]]
    for time, x in ((0.5, 0.5), (1.5, 1.5), (2.0, 2.0)):
        scene, _ = played(raw([0, 1, 2], keys[:3], "translation"), time)
        mixed, _ = played(raw([2, 0, 1, 0], [*keys[2:3], keys[3], *keys[1:2], keys[0]], "translation"), time)
        assert scene.nodes.translation[1, 0] == pytest.approx(x)
        np.testing.assert_array_equal(mixed.nodes.translation[1], scene.nodes.translation[1])  # of two at 0 the last


@pytest.mark.parametrize("mode", ["loop", "once", "ping-pong"])
def test_time_a_million_million_seconds_on(mode: str) -> None:
    clip = ClipAsset("c", [channel(1, "rotation", [0, 0.75, 1.5], [turning(1, a) for a in (0.0, 1.0, 0.0)])])
    here, there = (played(clip, t, "linear", mode)[1] for t in (0.375, 3e11 * 3.0 + 0.375))
    if mode != "once":
        np.testing.assert_allclose(there, here, atol=1e-3)  # float64 knows 1e12 s to 0.12 ms
    assert np.isfinite(there).all()
    animator = Animator(single(ClipSampler(clip, rig(2)), mode), 2)
    for dt in (1e12, -1e12, 1e300, np.nan, np.inf):
        animator.update(dt)
        assert np.isfinite(animator.poses).all()


def test_a_clip_of_no_duration() -> None:
    clip = ClipAsset("still", [channel(1, "rotation", [0.0], [turning(2, 1.0)])])
    for mode in ("loop", "once", "ping-pong"):
        for time in (0.0, -1.0, 5.0, 1e12):
            scene, _ = played(clip, time, "linear", mode)
            assert float(angle(scene.nodes.rotation[1], np.array(turning(2, 1.0)))) < 1e-6
        animator = Animator(single(ClipSampler(clip, rig(2)), mode))
        animator.update(1.0)
        assert np.isfinite(animator.poses).all()


@pytest.mark.parametrize("method", METHODS)
def test_skinned_a_million_metres_from_the_origin(method: str) -> None:
    """The palette is relative to the camera's origin: moved along, it is the same to a micrometre."""
    near, far = (hung(method)[0] for _ in range(2))
    away = np.array([1e6, -3e5, 2e6])
    far.nodes.set_translation(0, away)
    for scene in (near, far):
        scene.nodes.set_rotation(1, random_rotations(np.random.default_rng(2), 1)[:, 0])
        scene.update()
    np.testing.assert_allclose(far.skins.palette(away), near.skins.palette(np.zeros(3)), atol=1e-6)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("bind", [0.0, 1e-30, np.diag([1.0, 0.0, 1.0])])
def test_a_bind_matrix_that_has_no_inverse(bind: float | F8, method: str) -> None:
    binds = np.tile(np.eye(4), (2, 1, 1))
    binds[1, :3, :3] = bind * np.eye(3) if np.ndim(bind) == 0 else bind
    scene, _, skin = hung(method, binds)
    palette = scene.skins.palette(np.zeros(3))
    assert np.isfinite(palette).all()
    assert np.isfinite(scene.skins.sphere(skin)).all()
    np.testing.assert_allclose(palette[0], hung(method)[0].skins.palette(np.zeros(3))[0])  # the others are as ever
    assert quat.normalize(np.zeros(4)).tolist() == [0.0, 0.0, 0.0, 1.0]
