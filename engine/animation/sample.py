"""Sampling: the values of a clip's tracks at a time, and ClipPlayer, which writes them to a scene's nodes."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.animation.clock import wrap
from engine.animation.tracks import Track, pack, survey
from engine.assets.clip import ClipAsset
from engine.core.findings import Findings
from engine.math import quat
from engine.scene.copies import Copies, OwnPlaces
from engine.scene.nodes import NodeTable

F8 = NDArray[np.float64]
I8 = NDArray[np.int64]


class ClipPlayer:
    """A clip bound to node rows: `node_rows[i]` is the row of the clip's node i, or -1 to leave that node alone.

    `findings` holds what was wrong with the clip; whatever could be used is played. A node removed since the first
    `apply`, or whose row was used again, is left alone: a player belongs to one scene. Keys in 16 bits, which come from
    files that were checked, are decoded when the clip first plays.
    """

    def __init__(self, clip: ClipAsset, node_rows: ArrayLike) -> None:
        self.name = clip.name
        self.findings = Findings(clip.name)
        self._structure_rev = -1
        self._generation: list[NDArray[np.uint32]] | None = None
        self._living: list[NDArray[np.bool_] | None] = []
        self._clip, self._bound = clip, np.asarray(node_rows, np.int64)
        self._tracks: list[Track] | None = None
        #: seconds to the last key that is played
        self.duration = 0.0
        if any(channel.codes is not None for channel in clip.channels):
            self._rows, self.duration = survey(clip, self._bound, self.findings)
            return
        self._tracks = tracks = pack(clip, self._bound, self.findings)
        self._rows = np.unique(np.concatenate([t.rows for t in tracks])) if tracks else np.zeros(0, np.int64)
        self.duration = max((float(t.times[t.first + t.count - 1].max()) for t in tracks), default=0.0)

    @property
    def tracks(self) -> list[Track]:
        """The clip's channels as they are sampled."""
        if self._tracks is None:
            self._tracks = pack(self._clip, self._bound)
        return self._tracks

    @property
    def node_rows(self) -> I8:
        """The rows that the clip moves, rising."""
        return self._rows

    def sample(self, time_s: float, mode: str = "loop") -> list[tuple[str, I8, F8]]:
        """Return (path, rows i8[k], values f8[k,3|4]) per track, at `time_s` wrapped by `mode` (see clock.wrap)."""
        time = wrap(time_s, self.duration, mode)
        return [(track.path, track.rows, sample_track(track, time)) for track in self.tracks]

    def apply(
        self, nodes: NodeTable, time_s: float, mode: str = "loop", copies: Copies | None = None,
        places: OwnPlaces | None = None,
    ) -> None:  # fmt: skip
        """Write the pose at `time_s` to `nodes`, and to the `copies` of those, the placed ones about their `places`;
        call `update()` afterwards."""
        setters = {
            "translation": nodes.set_translation, "rotation": nodes.set_rotation, "scale": nodes.set_scale,
        }  # fmt: skip
        self._check_living(nodes)
        for (path, rows, values), living in zip(self.sample(time_s, mode), self._living, strict=True):
            if copies and places is not None:
                places.write(copies, path, rows, values)
            if living is None:
                setters[path](rows, values)
            elif living.any():
                setters[path](rows[living], values[living])
            if copies:
                which, to = copies.moving.repeat(rows)
                setters[path](to, values[which])

    def meet(self, nodes: NodeTable) -> None:
        """Those who stand in the rows now are the ones to move, though they may be moved much later."""
        self._check_living(nodes)

    def _check_living(self, nodes: NodeTable) -> None:
        """Find, after structural changes only, which rows still hold the nodes that they held at first."""
        if nodes.structure_rev == self._structure_rev:
            return
        self._structure_rev = nodes.structure_rev
        count = len(nodes)
        rows = [np.minimum(t.rows, max(count - 1, 0)) for t in self.tracks]
        if self._generation is None:
            self._generation = [nodes.generation[r] for r in rows] if count else []
        self._living = []
        for index, track in enumerate(self.tracks):
            if count == 0:
                self._living.append(np.zeros(len(track.rows), np.bool_))
                continue
            r = rows[index]
            living = (track.rows < count) & nodes.alive[r] & (nodes.generation[r] == self._generation[index])
            self._living.append(None if living.all() else living)


def sample_track(track: Track, time: float) -> F8:
    """Return the values f8[k,3|4] of a track's channels at `time` (seconds); before the first and after the last key
    the end values hold. Rotations are unit."""
    before, after, span, fraction = segments(track, time)
    if track.interpolation == "step":
        return track.values[before]
    if track.interpolation == "cubic":
        values = hermite(track.values[before], track.values[after], span, fraction)
        return quat.normalize(values) if track.path == "rotation" else values
    if track.path == "rotation":
        return quat.slerp(track.values[before], track.values[after], fraction)
    start = track.values[before]
    result: F8 = start + (track.values[after] - start) * fraction[:, None]
    return result


def segments(track: Track, time: float) -> tuple[I8, I8, F8, F8]:
    """Return, per channel, the keys before and after `time` as indices [k], the seconds between them and the fraction
    in [0, 1]. Outside the keys both are the end key.

    All channels are searched together by bisection: log2 of the longest channel's keys in steps of one batch.
    """
    low = np.zeros(len(track.count), np.int64)  # the number of keys at or before `time`
    high = track.count.copy()
    for _ in range(int(track.count.max()).bit_length()):
        middle = (low + high) >> 1
        open_ = low < high
        passed = open_ & (track.times[track.first + np.minimum(middle, track.count - 1)] <= time)
        low = np.where(passed, middle + 1, low)
        high = np.where(open_ & ~passed, middle, high)
    before = track.first + np.maximum(low - 1, 0)
    after = track.first + np.minimum(low, track.count - 1)
    span = track.times[after] - track.times[before]
    fraction = np.where(span > 0.0, (time - track.times[before]) / np.where(span > 0.0, span, 1.0), 0.0)
    return before, after, span, fraction


def hermite(start: F8, end: F8, span: F8, fraction: F8) -> F8:
    """Return [k,w]: the cubic Hermite spline between keys [k,3,w] (glTF 2.0, appendix C.5); tangents times `span`."""
    t = fraction[:, None]
    t2, t3 = t * t, t * t * t
    dt = span[:, None]
    result: F8 = (
        (2.0 * t3 - 3.0 * t2 + 1.0) * start[:, 1]
        + (t3 - 2.0 * t2 + t) * dt * start[:, 2]
        + (3.0 * t2 - 2.0 * t3) * end[:, 1]
        + (t3 - t2) * dt * end[:, 0]
    )
    return result
