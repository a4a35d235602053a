"""What the dope sheet and the curve view show: a clip's channels by node, their keys, their values over time; and
where on the timeline they play."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.animation.sample import sample_track
from engine.animation.tracks import Track
from engine.assets.clip import Channel, ClipAsset
from engine.math import quat

F8 = NDArray[np.float64]
#: no more repeats of a key in a looping block are shown than this
_MOST_TURNS = 1000
UNITS = {"translation": "m", "rotation": "°", "scale": "×", "weights": ""}
COMPONENTS = {"translation": ("x", "y", "z"), "rotation": ("x", "y", "z"), "scale": ("x", "y", "z")}


@dataclass(frozen=True, slots=True)
class Row:
    """`channel`: its number in the clip; `keys`: seconds."""

    channel: int
    node: str
    path: str
    keys: F8


@dataclass(frozen=True, slots=True, eq=False)
class Shown:
    """A clip as it plays: by itself, or as block `block` of `track` (numbers) of `sequence`."""

    clip: ClipAsset
    sequence: Any = None
    track: int = -1
    block: int = -1

    @property
    def span(self) -> tuple[float, float]:
        """When it plays, seconds of the timeline."""
        if self.sequence is None:
            return 0.0, float(self.clip.duration)
        own = self._block
        return own.start, own.end

    def clip_times(self, times: F8) -> F8:
        """The clip's own times at `times` of the timeline."""
        if self.sequence is None:
            return np.clip(times, 0.0, float(self.clip.duration))
        return np.asarray(self.sequence.clip_time(self.sequence.tracks[self.track], self._block, times), np.float64)

    def places(self, keys: F8) -> tuple[F8, NDArray[np.int64]]:
        """(times on the timeline, numbers of the `keys` that are there): every repeat of a loop, rising with it."""
        number = np.arange(len(keys))
        length = float(self.clip.duration)
        if self.sequence is None or length <= 0.0 or not len(keys):
            return np.asarray(keys, np.float64), number
        own, track = self._block, self.sequence.tracks[self.track]
        ends = np.array([own.start, own.end])
        first, last = np.sort(self.sequence.phase(track, own, ends))
        share = np.asarray(keys, np.float64) / length
        if own.play == "once":
            turns = np.zeros(1)
        else:
            turns = np.arange(np.floor(first), min(np.floor(last), np.floor(first) + _MOST_TURNS) + 1)
        phase = turns[:, None] + share[None]
        if own.play == "ping-pong":
            phase = np.where((turns % 2 == 0)[:, None], phase, turns[:, None] + 1.0 - share[None])
        inside = (phase >= first - 1e-9) & (phase <= last + 1e-9)
        which = np.broadcast_to(number, phase.shape)[inside]
        if own.sync and track.phases is not None:
            times, phases = track.phases
            at = np.interp(phase[inside] - own.offset / length, phases, times)
        else:
            at = own.start + (phase[inside] * length - own.offset) / (own.speed or np.inf)
        return np.asarray(at, np.float64), which

    @property
    def _block(self) -> Any:
        return self.sequence.tracks[self.track].blocks[self.block]


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
    """Rotation vectors in degrees f8[3,n] of quaternions f8[4,n]: of all that mean the same rotation the nearest to the
    one before, so that the curve does not jump where the rotation does not. (It may where a whole turn is complete:
    there the axis is anybody's.)"""
    sine = np.linalg.norm(q[:3], axis=0)
    axes = q[:3] / np.where(sine > 1e-12, sine, 1.0)
    angles = 2.0 * np.arctan2(sine, q[3])
    out, before = np.zeros((3, q.shape[1])), np.zeros(3)
    for i in range(q.shape[1]):
        turns = np.round((before @ axes[:, i] - angles[i]) / (2.0 * np.pi))
        before = axes[:, i] * (angles[i] + 2.0 * np.pi * turns)
        out[:, i] = before
    return np.degrees(out)
