"""ClipSampler: one clip at as many times as there are characters, into their poses, in a few array operations.

For one character the operations themselves cost more than what they do: `sample_one` needs a third of them, and gives
the same bits.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.animation import poses
from engine.animation.rig import Rig
from engine.animation.tracks import Track, pack
from engine.assets.clip import ClipAsset
from engine.core.errors import InputError
from engine.core.findings import Findings

F8 = NDArray[np.float64]
I8 = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class _Group:
    """Channels of one path and interpolation whose keys stand at the same times, `values` f8[w,keys,k] (cubic:
    f8[3,w,keys,k]). `theta` f8[keys-1,k]: the angle in 4-space of each segment of a linear rotation; `bend`: a third of
    its square where all are small enough for `poses.bent_nlerp`, else None."""

    path: str
    interpolation: str
    columns: slice | I8
    times: F8
    values: F8
    theta: F8 | None
    bend: F8 | None = None
    #: the number of its times among the sampler's clocks
    clock: int = 0


class ClipSampler:
    """`clip` on the nodes of `rig`. `covers` bool[3,n]: which translations, rotations, scales it has keys for.

    Quaternions are aligned key to key and the angles between them measured once, here. `findings` as of tracks.pack.
    """

    def __init__(self, clip: ClipAsset, rig: Rig) -> None:
        self.name = clip.name
        self.rig = rig
        self.findings = Findings(clip.name)
        size = max([c.node + 1 for c in clip.channels] + [int(rig.source.max(initial=-1)) + 1, 0])
        column = np.full(size, -1, np.int64)
        column[rig.source] = np.arange(len(rig))
        tracks = pack(clip, column, self.findings)
        clocks: dict[bytes, int] = {}
        self._groups = [
            replace(group, clock=clocks.setdefault(group.times.tobytes(), len(clocks)))
            for track in tracks
            for group in _groups(track)
        ]
        self._clocks = [np.frombuffer(times).tolist() for times in clocks]
        self.duration = max((float(t.times[t.first + t.count - 1].max()) for t in tracks), default=0.0)
        self.covers = np.zeros((3, len(rig)), np.bool_)
        for track in tracks:
            self.covers[("translation", "rotation", "scale").index(track.path), track.rows] = True

    def sample(self, times: ArrayLike, out: F8) -> None:
        """Write the poses at `times` f8[m] (seconds, held at the clip's ends) to what it covers of `out` f8[10,m,n]."""
        at = np.asarray(times, np.float64)
        if not np.isfinite(at).all():
            at = np.nan_to_num(at)
        found: dict[int, tuple[I8, F8]] = {}  # groups with the same key times look once
        for group in self._groups:
            if group.interpolation != "step" and group.clock not in found:
                found[group.clock] = _segments(group.times, at)
            out[poses.ROWS[group.path], :, group.columns] = _evaluate(group, at, found.get(group.clock))

    def sample_one(self, time: float, out: F8) -> None:
        """As `sample` for one character: the pose at `time` to what it covers of `out` f8[10,n]."""
        if not math.isfinite(time):
            time = float(np.nan_to_num(time))
        found: list[tuple[int, float, float]] = []
        for times in self._clocks:
            at = min(max(time, times[0]), times[-1])
            key = min(max(bisect_right(times, at) - 1, 0), max(len(times) - 2, 0))
            span = times[key + 1] - times[key] if len(times) > 1 else 1.0
            found.append((key, (at - times[key]) / span, time))
        for group in self._groups:
            if group.interpolation == "cubic":
                value = _evaluate(group, np.array([time]))[:, 0]
            else:
                value = _evaluate_one(group, *found[group.clock])
            out[poses.ROWS[group.path], group.columns] = value


@dataclass(slots=True)
class SampleJob:
    """A clip at `times` f8[m] over the rest pose, to `out` f8[10,m,n]."""

    sampler: ClipSampler
    times: F8
    out: F8

    def validate(self) -> None:
        """Raise InputError when the shapes do not fit."""
        poses.check(self.out, "out", (10, len(self.times), len(self.sampler.rig)))
        if self.times.ndim != 1:
            raise InputError(f"times have shape {self.times.shape}, expected one per character")

    def run(self) -> None:
        self.out[...] = self.sampler.rig.rest[:, None, :]
        self.sampler.sample(self.times, self.out)


def _segments(times: F8, at: F8) -> tuple[I8, F8]:
    """Per time the key before it i8[m], one that has a next, and how far it is to that, f8[m,1] in [0,1]."""
    at = np.minimum(np.maximum(at, times[0]), times[-1])
    key: I8 = np.minimum(np.maximum(times.searchsorted(at, side="right") - 1, 0), len(times) - 2)
    before = times[key]
    return key, ((at - before) / (times[key + 1] - before))[:, None]


def _evaluate(group: _Group, at: F8, found: tuple[I8, F8] | None = None) -> F8:
    """f8[w,m,k]; `found`: what `_segments` said of the group's times."""
    times, values = group.times, group.values
    if group.interpolation == "step":
        key = np.minimum(np.maximum(times.searchsorted(at, side="right") - 1, 0), len(times) - 1)
        return values[:, key]
    key, u = found if found is not None else _segments(times, at)
    if group.interpolation == "cubic":
        return _hermite(group, key, (times[key + 1] - times[key])[:, None], u)
    start, end = values[:, key], values[:, key + 1]
    if group.theta is None:
        # rather start + u (end - start) than two products: equal keys stay exactly what they are
        end -= start
        end *= u
        end += start
        return end
    if group.bend is not None:
        return poses.bent_nlerp(start, end, group.bend[key], u)
    weight_a, weight_b = poses.slerp_weights(group.theta[key], u)
    start *= weight_a
    end *= weight_b
    start += end
    return start


def _evaluate_one(group: _Group, key: int, u: float, time: float) -> F8:
    """f8[w,k] of a group that is not cubic."""
    values = group.values
    if group.interpolation == "step":
        key = min(max(int(np.searchsorted(group.times, time, side="right")) - 1, 0), len(group.times) - 1)
        return values[:, key]
    start, end = values[:, key], values[:, key + 1]
    if group.theta is None:
        moved: F8 = end - start
        moved *= u
        moved += start
        return moved
    if group.bend is None:
        weight_a, weight_b = poses.slerp_weights(group.theta[key], np.asarray(u))
        result: F8 = start * weight_a + end * weight_b
        return result
    # poses.bent_nlerp
    moved = end - start
    moved *= u + group.bend[key] * (u * (u - 0.5) * (u - 1.0))
    moved += start
    moved /= np.sqrt(np.add.reduce(moved * moved, axis=0))
    return moved


def _hermite(group: _Group, key: I8, span: F8, u: F8) -> F8:
    """The cubic Hermite spline (glTF 2.0, appendix C.5); rotations are made unit afterwards."""
    u2 = u * u
    u3 = u2 * u
    entering, value, leaving = group.values
    result: F8 = (
        (2.0 * u3 - 3.0 * u2 + 1.0) * value[:, key]
        + (u3 - 2.0 * u2 + u) * span * leaving[:, key]
        + (3.0 * u2 - 2.0 * u3) * value[:, key + 1]
        + (u3 - u2) * span * entering[:, key + 1]
    )
    if group.path == "rotation":
        start, end = value[:, key], value[:, key + 1]
        return poses.unit(result, poses.nlerp(start, end, u))
    return result


def _groups(track: Track) -> list[_Group]:
    """The track's channels, those with the same key times together."""
    of_times: dict[bytes, list[int]] = {}
    for channel in range(len(track.rows)):
        first, count = int(track.first[channel]), int(track.count[channel])
        of_times.setdefault(track.times[first : first + count].tobytes(), []).append(channel)
    shared = list(of_times.values())
    if len(shared) > 4 and track.interpolation != "cubic":
        # many short searches cost more than keys that change nothing: put all on the union of the times
        return _merged(track, shared)
    return [_group(track, channels) for channels in shared]


def _group(track: Track, channels: list[int]) -> _Group:
    first, count = track.first[channels[0]], track.count[channels[0]]
    times = track.times[first : first + count]
    # keys x channels x (3 x) w  ->  (3 x) w x keys x channels
    values = np.stack([track.values[track.first[c] : track.first[c] + count] for c in channels], axis=1)
    return _finish(track, channels, times, np.moveaxis(values, (0, 1), (-2, -1)))


def _merged(track: Track, shared: list[list[int]]) -> list[_Group]:
    """One group on the union of all key times, unless that is more than eight times the keys: then one for each."""
    groups = [_group(track, channels) for channels in shared]
    union = np.unique(track.times)
    if len(union) * len(track.rows) > 8 * len(track.times):
        return groups
    values = np.concatenate([_evaluate(group, union) for group in groups], axis=-1)
    return [_finish(track, [c for channels in shared for c in channels], union, values)]


def _finish(track: Track, channels: list[int], times: F8, values: F8) -> _Group:
    order = np.argsort(track.rows[channels])
    rows = track.rows[channels][order]
    columns = slice(int(rows[0]), int(rows[-1]) + 1) if rows[-1] - rows[0] == len(rows) - 1 else rows
    values = np.array(values[..., order])
    interpolation = track.interpolation
    if len(times) == 1:  # nothing to interpolate
        values = values if values.ndim == 3 else values[1]
        interpolation = "step"
    theta = None
    if track.path == "rotation" and interpolation == "linear":
        flips = np.where(poses.dot(values[:, 1:], values[:, :-1]) < 0.0, -1.0, 1.0)
        values[:, 1:] *= np.cumprod(flips, axis=0)
        theta = poses.angle_4d(values[:, :-1], values[:, 1:])
    bend = theta * theta / 3.0 if theta is not None and float(theta.max(initial=0.0)) <= poses.BENT_LIMIT else None
    return _Group(track.path, interpolation, columns, times, np.ascontiguousarray(values), theta, bend)
