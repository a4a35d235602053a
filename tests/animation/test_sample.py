from __future__ import annotations

import math

import numpy as np
import pytest

from engine.animation.sample import ClipPlayer, sample_track, segments
from engine.animation.tracks import pack
from engine.assets.clip import Channel, ClipAsset
from engine.math import quat
from engine.scene.nodes import NodeTable

WIDTH = {"translation": 3, "rotation": 4, "scale": 3}


def channel(node: int, path: str, interpolation: str, times: object, values: object) -> Channel:
    return Channel(node, path, interpolation, np.array(times, np.float32), np.array(values, np.float32), f"n{node}")


def reference(c: Channel, time: float) -> np.ndarray:
    """One channel by hand, in float64."""
    times, values = c.times.astype(np.float64), c.values.astype(np.float64)
    if c.path == "rotation":
        if c.interpolation == "cubic":
            values[:, 1] /= np.linalg.norm(values[:, 1], axis=-1, keepdims=True)
        else:
            values /= np.linalg.norm(values, axis=-1, keepdims=True)
    key = (lambda v: v[1]) if c.interpolation == "cubic" else (lambda v: v)
    if time <= times[0]:
        return key(values[0])
    if time >= times[-1]:
        return key(values[-1])
    i = int(np.searchsorted(times, time, side="right")) - 1
    dt = times[i + 1] - times[i]
    u = (time - times[i]) / dt
    a, b = values[i], values[i + 1]
    if c.interpolation == "step":
        return a
    if c.interpolation == "cubic":
        out = (
            (2 * u**3 - 3 * u**2 + 1) * a[1]
            + (u**3 - 2 * u**2 + u) * dt * a[2]
            + (-2 * u**3 + 3 * u**2) * b[1]
            + (u**3 - u**2) * dt * b[0]
        )
        return out / np.linalg.norm(out) if c.path == "rotation" else out
    if c.path == "rotation":
        dot = float(a @ b)
        if dot < 0:
            b, dot = -b, -dot
        angle = math.acos(min(dot, 1.0))
        if angle < 1e-6:
            return a
        return (math.sin((1 - u) * angle) * a + math.sin(u * angle) * b) / math.sin(angle)
    return a + (b - a) * u


def random_clip(rng: np.random.Generator, nodes: int) -> ClipAsset:
    channels = []
    for node in range(nodes):
        for path, width in WIDTH.items():
            keys = int(rng.integers(1, 30))
            times = np.sort(rng.uniform(0, 5, size=keys)).astype(np.float32)
            times = np.unique(times)
            interpolation = str(rng.choice(["step", "linear", "cubic"]))
            shape = (len(times), 3, width) if interpolation == "cubic" else (len(times), width)
            channels.append(channel(node, path, interpolation, times, rng.normal(size=shape)))
    return ClipAsset("c", channels)


@pytest.mark.parametrize("seed", range(3))
def test_every_channel_against_float64(seed: int) -> None:
    rng = np.random.default_rng(seed)
    clip = random_clip(rng, 20)
    player = ClipPlayer(clip, np.arange(20))
    assert len(player.findings) == 0
    assert player.duration == pytest.approx(clip.duration)
    exact = [float(c.times[len(c.times) // 2]) for c in clip.channels[:10]]
    for time in [0.0, *exact, *rng.uniform(0, clip.duration, size=25)]:
        got = {}
        for path, rows, values in player.sample(time, "once"):
            for row, value in zip(rows, values, strict=True):
                got[int(row), path] = value
        assert len(got) == len(clip.channels)
        for c in clip.channels:
            value, expected = got[c.node, c.path], reference(c, time)
            if c.path == "rotation":
                value = value if value @ expected >= 0 else -value
                assert np.linalg.norm(value) == pytest.approx(1.0)
            assert np.allclose(value, expected, atol=1e-6), (c.path, c.interpolation, time)


def test_apply_writes_only_its_nodes() -> None:
    nodes = NodeTable()
    nodes.add_many(["a", "b", "c"], translations=np.full((3, 3), 9.0))
    nodes.update()
    clip = ClipAsset("c", [channel(0, "translation", "linear", [0, 2], [[0, 0, 0], [4, 0, 0]])])
    player = ClipPlayer(clip, [1])
    player.apply(nodes, 0.5)
    assert nodes.update().tolist() == [1]
    assert nodes.world[:, 0, 3].tolist() == [9, 1, 9]
    player.apply(nodes, 2.5)
    nodes.update()
    assert nodes.world[1, 0, 3] == 1
    player.apply(nodes, 3.5, "ping-pong")
    nodes.update()
    assert nodes.world[1, 0, 3] == 1


def test_scale_and_rotation_are_applied() -> None:
    nodes = NodeTable()
    nodes.add("a")
    half = math.sqrt(0.5)
    clip = ClipAsset(
        "c",
        [
            channel(0, "rotation", "linear", [0, 1], [[0, 0, 0, 1], [0, half, 0, half]]),
            channel(0, "scale", "step", [0, 0.75], [[1, 1, 1], [2, 2, 2]]),
        ],
    )
    ClipPlayer(clip, [0]).apply(nodes, 0.5)
    nodes.update()
    assert np.allclose(nodes.world[0] @ [0, 0, 1, 1], [math.sin(math.pi / 4), 0, math.cos(math.pi / 4)])
    ClipPlayer(clip, [0]).apply(nodes, 0.75)
    nodes.update()
    assert np.linalg.norm(nodes.world[0, :, 0]) == pytest.approx(2.0)


def test_removed_nodes_are_left_alone() -> None:
    nodes = NodeTable()
    nodes.add_many(["a", "b"])
    keys = [[0, 0, 0], [4, 0, 0]]
    clip = ClipAsset("c", [channel(i, "translation", "linear", [0, 2], keys) for i in range(2)])
    player = ClipPlayer(clip, [0, 1])
    player.apply(nodes, 1.0)
    nodes.remove(1)
    player.apply(nodes, 1.0)
    assert nodes.add("other") == 1
    player.apply(nodes, 1.5)
    nodes.update()
    assert nodes.world[:, 0, 3].tolist() == [3, 0]
    nodes.remove([0, 1])
    player.apply(nodes, 0.0)
    ClipPlayer(clip, [0, 1]).apply(NodeTable(), 1.0)


def test_rows_of_minus_one_are_skipped() -> None:
    clip = ClipAsset("c", [channel(i, "scale", "step", [0], [[1, 1, 1]]) for i in range(3)])
    player = ClipPlayer(clip, [4, -1, 2])
    assert player.node_rows.tolist() == [2, 4]
    assert len(player.findings) == 0


@pytest.mark.parametrize("time", [-1e9, 1e12, math.nan, math.inf, 0.0])
@pytest.mark.parametrize("interpolation", ["step", "linear", "cubic"])
@pytest.mark.parametrize("mode", ["loop", "once", "ping-pong"])
def test_single_keys_hold_at_any_time(time: float, interpolation: str, mode: str) -> None:
    value = np.array([[0.0, 0.0, 0.0], [1.0, 2.0, 3.0], [0.0, 0.0, 0.0]])
    values = value[None] if interpolation == "cubic" else value[1:2]
    player = ClipPlayer(ClipAsset("c", [channel(0, "translation", interpolation, [0.7], values)]), [0])
    assert player.sample(time, mode)[0][2].tolist() == [[1, 2, 3]]


def test_key_times_hit_exactly() -> None:
    track = pack(ClipAsset("c", [channel(0, "translation", "step", [0, 1, 2], np.eye(3))]), [0])[0]
    assert [int(np.argmax(sample_track(track, t)[0])) for t in (0.0, 0.999, 1.0, 1.999, 2.0, 9.0)] == [0, 0, 1, 1, 2, 2]
    before, after, span, fraction = segments(track, 1.25)
    assert (before[0], after[0], span[0], fraction[0]) == (1, 2, 1.0, 0.25)


def test_bad_keys_are_mended_and_noted() -> None:
    clip = ClipAsset(
        "c",
        [
            channel(0, "translation", "linear", [2, 0, 1, 1], [[2, 0, 0], [0, 0, 0], [7, 0, 0], [1, 0, 0]]),
            channel(1, "translation", "linear", [0, 1, 2], [[0, 0, 0], [math.nan, 0, 0], [4, 0, 0]]),
            channel(2, "translation", "linear", [], np.zeros((0, 3))),
            channel(3, "rotation", "linear", [0], [[0, 0, 0, 0]]),
            channel(4, "rotation", "linear", [0], [[0, 0, 0]]),
            channel(5, "colour", "linear", [0], [[0, 0, 0]]),
            channel(5, "scale", "bezier", [0], [[0, 0, 0]]),
            channel(99, "scale", "step", [0], [[0, 0, 0]]),
            channel(0, "weights", "linear", [0], [[0.5]]),
            channel(6, "scale", "step", [0], [[1, 1, 1]]),
            channel(6, "scale", "linear", [0], [[2, 2, 2]]),
        ],
    )
    player = ClipPlayer(clip, np.arange(10))
    codes = sorted(f.code for f in player.findings)
    assert codes == [
        "clip.empty", "clip.finite", "clip.interpolation", "clip.node", "clip.order", "clip.path", "clip.shape",
        "clip.twice",
    ]  # fmt: skip
    got = {
        (path, int(r)): v
        for path, rows, values in player.sample(0.5, "once")
        for r, v in zip(rows, values, strict=True)
    }
    assert got["translation", 0].tolist() == [0.5, 0, 0]
    assert got["translation", 1].tolist() == [1, 0, 0]
    assert got["rotation", 3].tolist() == [0, 0, 0, 1]
    assert got["scale", 6].tolist() == [2, 2, 2]
    assert len(got) == 4


def test_empty_clip() -> None:
    player = ClipPlayer(ClipAsset("c"), [0, 1])
    assert player.duration == 0.0
    assert player.node_rows.tolist() == []
    player.apply(NodeTable(), 1.0)


def test_tiny_rotations_are_smooth() -> None:
    for angle in (1e-7, 1e-5, 1e-3):
        q = quat.from_axis_angle([0, 1, 0], [0.0, angle])
        # keys in float64 here: float32 cannot tell such angles apart
        track = pack(ClipAsset("c", [Channel(0, "rotation", "linear", np.array([0.0, 1.0]), q)]), [0])[0]
        half = sample_track(track, 0.5)[0]
        assert quat.angle_between(half, quat.from_axis_angle([0, 1, 0], angle / 2)) < 1e-12
