"""What several animation tests build: rigs and clips by hand."""

from __future__ import annotations

import numpy as np

from engine.animation.rig import Rig
from engine.animation.sampler import ClipSampler
from engine.assets.clip import Channel, ClipAsset
from engine.assets.scene import NodeAsset

IDENTITY = np.array([0.0, 0.0, 0.0, 1.0])


def chain(count: int) -> list[NodeAsset]:
    """n0 - n1 - n2 …, each 1 m above its parent."""
    return [NodeAsset(f"n{i}", i - 1, translation=(0.0, float(i > 0), 0.0)) for i in range(count)]


def rig(count: int, parents: list[int] | None = None) -> Rig:
    rest = np.zeros((10, count))
    rest[6], rest[7:10] = 1.0, 1.0
    parent = np.arange(count) - 1 if parents is None else np.array(parents)
    return Rig(tuple(f"n{i}" for i in range(count)), parent, rest, np.arange(count))


def channel(node: int, path: str, times: object, values: object, interpolation: str = "linear") -> Channel:
    return Channel(node, path, interpolation, np.array(times, np.float32), np.array(values, np.float32), f"n{node}")


def turning(axis: int, angle: float) -> np.ndarray:
    q = np.zeros(4)
    q[axis], q[3] = np.sin(angle / 2), np.cos(angle / 2)
    return q


def random_clip(rng: np.random.Generator, nodes: int, *, shared: bool, interpolation: str = "linear") -> ClipAsset:
    """Every property of every node, with the same key times or each with its own."""
    times = np.sort(rng.uniform(0.0, 2.0, 9))
    channels = []
    for node in range(nodes):
        for path, width in (("translation", 3), ("rotation", 4), ("scale", 3)):
            own = times if shared else np.sort(rng.uniform(0.0, 2.0, rng.integers(1, 12)))
            shape = (len(own), 3, width) if interpolation == "cubic" else (len(own), width)
            channels.append(channel(node, path, own, rng.normal(size=shape), interpolation))
    return ClipAsset("random", channels)


def slide(seconds: float, x: float, name: str = "slide") -> ClipAsset:
    """Node 0 from the origin to x along +X."""
    return ClipAsset(name, [channel(0, "translation", [0.0, seconds], [[0, 0, 0], [x, 0, 0]])])


def still(x: float, seconds: float = 1.0, name: str = "still") -> ClipAsset:
    """Node 0 at x all the time."""
    return ClipAsset(name, [channel(0, "translation", [0.0, seconds], [[x, 0, 0], [x, 0, 0]])])


def sampler(clip: ClipAsset, nodes: int = 1) -> ClipSampler:
    return ClipSampler(clip, rig(nodes))


def random_rotations(rng: np.random.Generator, *shape: int) -> np.ndarray:
    """Unit quaternions, components first: f8[4, *shape]."""
    q = rng.normal(size=(4, *shape))
    return q / np.linalg.norm(q, axis=0)


def random_poses(rng: np.random.Generator, characters: int, nodes: int) -> np.ndarray:
    pose = rng.normal(size=(10, characters, nodes))
    pose[3:7] = random_rotations(rng, characters, nodes)
    return pose


def angle(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Radians between rotations [4,...], whatever their signs."""
    d, s = np.linalg.norm(a - b, axis=0), np.linalg.norm(a + b, axis=0)
    return 4.0 * np.arctan2(np.minimum(d, s), np.maximum(d, s))


def assert_same_pose(a: np.ndarray, b: np.ndarray, tolerance: float = 1e-12) -> None:
    """Equal, where q and -q are the same rotation."""
    np.testing.assert_allclose(a[0:3], b[0:3], atol=tolerance)
    np.testing.assert_allclose(a[7:10], b[7:10], atol=tolerance)
    assert angle(a[3:7], b[3:7]).max(initial=0.0) <= 4.0 * tolerance
