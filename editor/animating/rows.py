"""What the dope sheet and the curve view show: a clip's channels by node, their keys, their values over time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.animation.sample import sample_track
from engine.animation.tracks import Track
from engine.assets.clip import Channel, ClipAsset
from engine.math import quat

F8 = NDArray[np.float64]
COMPONENTS = {"translation": ("x", "y", "z"), "rotation": ("x°", "y°", "z°"), "scale": ("x", "y", "z")}


@dataclass(frozen=True, slots=True)
class Row:
    """`channel`: its number in the clip; `keys`: seconds."""

    channel: int
    node: str
    path: str
    keys: F8


def dope_rows(clip: ClipAsset, search: str = "", nodes: Sequence[str] = ()) -> list[Row]:
    """The clip's channels, in their order; those whose node and path hold `search`, of `nodes` where some are named."""
    wanted = search.lower()
    rows = []
    for number, channel in enumerate(clip.channels):
        name = channel.target or f"node {channel.node}"
        if wanted not in f"{name} {channel.path}".lower() or (nodes and name not in nodes):
            continue
        rows.append(Row(number, name, channel.path, np.asarray(channel.times, np.float64)))
    return rows


def key_times(clip: ClipAsset, nodes: Sequence[str] = ()) -> list[float]:
    """All times at which some channel (of `nodes`) has a key, rising."""
    times = [np.asarray(c.times, np.float64) for c in clip.channels if not nodes or c.target in nodes]
    return np.unique(np.concatenate(times)).tolist() if times else []


def curve(channel: Channel, times: F8) -> tuple[tuple[str, ...], F8]:
    """The names of a channel's components, and their values f8[components, times]. Rotations as degrees about X, Y
    and Z (the rotation vector's parts, unwrapped): quaternions' four numbers tell nobody anything."""
    keys, values = np.asarray(channel.times, np.float64), np.asarray(channel.values, np.float64)
    if len(keys) == 0:
        return (), np.zeros((0, len(times)))
    if channel.path == "rotation" and channel.interpolation != "cubic":
        values = quat.normalize(values)
    zero, count = np.zeros(1, np.int64), np.array([len(keys)], np.int64)
    track = Track(channel.path, channel.interpolation, zero, zero, count, keys, values)
    sampled = np.stack([sample_track(track, float(t))[0] for t in times], axis=1)
    if channel.path == "rotation":
        return COMPONENTS["rotation"], _degrees(sampled)
    names = COMPONENTS.get(channel.path, tuple(f"target {i}" for i in range(len(sampled))))
    return names, sampled


def _degrees(q: F8) -> F8:
    """Rotation vectors in degrees f8[3,n] of quaternions f8[4,n], continuous where the rotation is."""
    signs = np.cumprod(np.where(np.sum(q[:, 1:] * q[:, :-1], axis=0) < 0.0, -1.0, 1.0))
    q = q * np.concatenate([[1.0], signs])
    if q.shape[1] and q[3, 0] < 0.0:
        q = -q
    sine = np.linalg.norm(q[:3], axis=0)
    angle = 2.0 * np.arctan2(sine, q[3])
    scale = np.where(sine > 1e-12, angle / np.where(sine > 1e-12, sine, 1.0), 2.0)
    return np.degrees(q[:3] * scale)
