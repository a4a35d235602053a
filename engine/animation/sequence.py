"""Sequence: a timeline of clips on tracks, evaluated at any time, or at many at once: a pure function of time.

blocks of a track ─ levels, clip times ─> BlendJob ─> LayerJob over the tracks below ─> poses f8[10,m,n]
blocks' markers ─ occurrences ─> times, names: what a playhead passes
root ─ way ─> where root motion has carried the character at each time
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence as Items
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.animation import poses
from engine.animation.blend import BlendJob, fade
from engine.animation.graph import ClipUse
from engine.animation.layers import LayerJob
from engine.animation.playhead import PING_PONG, Step, mode_number
from engine.animation.poses import ROWS
from engine.animation.rig import Rig
from engine.animation.root_motion import RootMotion

F8 = NDArray[np.float64]
I8 = NDArray[np.int64]

#: steps a second of what is summed up over time: phases of synced blocks, ways of roots
RATE = 120.0
_MOST_STEPS = 500_000
#: no more occurrences of one marker in one block than this
_MOST_MARKERS = 10_000


@dataclass(frozen=True, slots=True)
class Block:
    """See engine.assets.animation_toml.BlockModel; `clip` is a number."""

    clip: int
    start: float
    length: float
    offset: float = 0.0
    speed: float = 1.0
    fade_in: float = 0.0
    fade_out: float = 0.0
    curve: str = "smooth"
    play: str = "loop"
    sync: bool = False
    weight: float = 1.0

    @property
    def end(self) -> float:
        return self.start + self.length

    def level(self, times: F8) -> F8:
        """f8[m]: how loud the block is. Its end counts as within: a timeline may stop there."""
        inside = (times >= self.start) & (times <= self.end)
        up = fade((times - self.start) / self.fade_in, self.curve) if self.fade_in > 0.0 else 1.0
        # the complement of a fade in: two blocks that fade by the same curve sum to 1; see `levels`
        begin = self.end - self.fade_out
        down = 1.0 - fade((times - begin) / self.fade_out, self.curve) if self.fade_out > 0.0 else 1.0
        return np.where(inside, np.minimum(up, down), 0.0)


@dataclass(slots=True)
class Track:
    """`mask` f8[n]. `reference` f8[10,n] for an additive track."""

    name: str
    blocks: list[Block]
    mask: F8
    mode: Literal["override", "additive"] = "override"
    weight: float = 1.0
    muted: bool = False
    reference: F8 | None = None
    #: (times f8[k], phases f8[k], turns included) of its synced blocks
    phases: tuple[F8, F8] | None = None


@dataclass(slots=True)
class Sequence:
    rig: Rig
    clips: list[ClipUse]
    tracks: list[Track]
    #: (time, name) of the timeline's own markers
    markers: list[tuple[float, str]] = field(default_factory=list)
    ways: list[RootMotion | None] = field(default_factory=list)
    _way: tuple[F8, F8] | None = None

    def __post_init__(self) -> None:
        self.ways = self.ways or [None] * len(self.clips)
        for track in self.tracks:
            track.phases = self._synced(track)
        self._way = self._travel() if any(w is not None for w in self.ways) else None

    @property
    def duration(self) -> float:
        """Seconds to the last block's end or the last marker."""
        ends = [b.end for t in self.tracks for b in t.blocks] + [time for time, _ in self.markers]
        return max(ends, default=0.0)

    def covers(self) -> NDArray[np.bool_]:
        """bool[3,n]: which translations, rotations and scales some clip of some track has keys for."""
        result = np.zeros((3, len(self.rig)), np.bool_)
        for clip in {b.clip for t in self.tracks for b in t.blocks}:
            result |= self.clips[clip].sampler.covers
        return result

    # -- poses ----------------------------------------------------------------------------------------------------

    def pose(self, times: ArrayLike) -> F8:
        """f8[10,m,n]: the poses at `times` f8[m] (seconds)."""
        at = np.atleast_1d(np.nan_to_num(np.asarray(times, np.float64)))
        out = poses.resting(self.rig.rest, len(at))
        for track in self.tracks:
            if not track.muted and track.weight != 0.0:
                self._lay(track, at, out)
        return out

    def clip_time(self, track: Track, block: Block, times: F8) -> F8:
        """f8[m]: the time within the block's clip, wrapped as it plays."""
        length = self.clips[block.clip].sampler.duration
        if length <= 0.0:
            return np.zeros(len(times))
        return length * _share(self.phase(track, block, times), block.play)

    def audible(self, times: ArrayLike) -> list[tuple[int, int, float, float]]:
        """(track, block, level, clip time) of what is heard at one time."""
        at = np.atleast_1d(np.asarray(times, np.float64))[:1]
        found = []
        for i, track in enumerate(self.tracks):
            for j, (block, level) in enumerate(zip(track.blocks, levels(track.blocks, at)[:, 0].tolist(), strict=True)):
                if level > 0.0 and not track.muted:
                    found.append((i, j, level, float(self.clip_time(track, block, at)[0])))
        return found

    def _lay(self, track: Track, at: F8, out: F8) -> None:
        heard = [b for b in track.blocks if b.start <= at.max() and b.end >= at.min()]
        level = levels(heard, at)
        kept = [i for i in range(len(heard)) if level[i].any()]
        if not kept:
            return
        inputs, moved = [], np.zeros(len(self.rig), np.bool_)
        for i in kept:
            pose = poses.resting(self.rig.rest, len(at))
            sampler, way = self.clips[heard[i].clip].sampler, self.ways[heard[i].clip]
            time = self.clip_time(track, heard[i], at)
            sampler.sample(time, pose)
            if way is not None and sampler.duration > 0.0:
                way.take_out(time / sampler.duration, pose)
            moved |= sampler.covers.any(axis=0)
            inputs.append(pose)
        blend = np.zeros_like(out)
        BlendJob(inputs, level[kept], self.rig.rest, blend).run()
        weight = np.minimum(level[kept].sum(axis=0), 1.0) * track.weight
        LayerJob(out, blend, weight, track.mask * moved, track.mode, track.reference).run()

    # -- time -----------------------------------------------------------------------------------------------------

    def phase(self, track: Track, block: Block, times: F8) -> F8:
        """f8[m]: phase with turns: 1.5 is half-way through the second run."""
        length = self.clips[block.clip].sampler.duration
        if length <= 0.0:
            return np.zeros(len(times))
        if block.sync and track.phases is not None:
            return np.interp(times, *track.phases) + block.offset / length
        return (block.offset + (times - block.start) * block.speed) / length

    def _synced(self, track: Track) -> tuple[F8, F8] | None:
        """The common phase of a track's synced blocks: its rate is one over the blend of their clips' lengths."""
        blocks = [b for b in track.blocks if b.sync]
        if not blocks:
            return None
        start, end = min(b.start for b in blocks), max(b.end for b in blocks)
        count = int(np.clip((end - start) * RATE, 2, _MOST_STEPS))
        times = np.linspace(start, end, count)
        level = levels(blocks, times)
        seconds = np.array([self.clips[b.clip].sampler.duration / max(abs(b.speed), 1e-6) for b in blocks])
        total = level.sum(axis=0)
        length = np.where(total > 0.0, level.T @ seconds / np.where(total > 0.0, total, 1.0), 0.0)
        rate = np.where(length > 0.0, 1.0 / np.where(length > 0.0, length, 1.0), 0.0)
        steps = 0.5 * (rate[1:] + rate[:-1]) * np.diff(times)
        return times, np.concatenate([[0.0], np.cumsum(steps)])

    # -- markers --------------------------------------------------------------------------------------------------

    def occurrences(self) -> tuple[F8, list[str]]:
        """Every marker's times on the timeline f8[e], rising, and names: its own, and those of the blocks' clips."""
        found = list(self.markers)
        for track in self.tracks:
            if track.muted:
                continue
            for block in track.blocks:
                for marker in self.clips[block.clip].markers:
                    found += [(float(t), marker.name) for t in self._occurs(track, block, marker.time)]
        found.sort()
        return np.array([t for t, _ in found]), [name for _, name in found]

    def _occurs(self, track: Track, block: Block, time: float) -> F8:
        """When within the block its clip passes its own `time`."""
        length = self.clips[block.clip].sampler.duration
        ends = np.array([block.start, block.end])
        if length <= 0.0 or not 0.0 <= time <= length:
            return np.zeros(0)
        first, last = np.sort(self.phase(track, block, ends))
        mark = time / length
        if block.play == "once":
            wanted = np.array([mark])
        else:
            turns = np.arange(np.floor(first) - 1, min(np.ceil(last) + 1, np.floor(first) + _MOST_MARKERS))
            wanted = turns + mark if block.play == "loop" else np.where(turns % 2 == 0, turns + mark, turns + 1 - mark)
        wanted = wanted[(wanted >= first - 1e-12) & (wanted < last)]
        if block.sync and track.phases is not None:
            times, phases = track.phases
            met: F8 = np.interp(wanted - block.offset / length, phases, times)
            return met
        if block.speed == 0.0:
            return np.zeros(0)
        found: F8 = block.start + (wanted * length - block.offset) / block.speed
        return found

    # -- root motion ----------------------------------------------------------------------------------------------

    def way(self, times: ArrayLike) -> F8:
        """f8[m,3]: x, z (metres) and yaw (radians) that root motion has carried the character since time 0."""
        at = np.atleast_1d(np.asarray(times, np.float64))
        if self._way is None:
            return np.zeros((len(at), 3))
        steps, travel = self._way
        return np.stack([np.interp(at, steps, column) for column in travel], axis=1)

    def _travel(self) -> tuple[F8, F8]:
        count = int(np.clip(self.duration * RATE, 1, _MOST_STEPS)) + 1
        times = np.linspace(0.0, max(self.duration, 1e-6), count)
        middle = 0.5 * (times[1:] + times[:-1])
        step, total = np.zeros((3, count - 1)), np.zeros(count - 1)
        for track in self.tracks:
            if track.muted or track.mode == "additive":
                continue
            for block, heard in zip(track.blocks, levels(track.blocks, middle), strict=True):
                way = self.ways[block.clip]
                if way is None or not self.clips[block.clip].sampler.covers[:, way.root].any():
                    continue
                if track.mask[way.root] <= 0.0:
                    continue
                level = heard * track.weight * track.mask[way.root]
                # what lies over the rest takes its share
                step = step * (1.0 - np.minimum(level, 1.0)) if track is not self.tracks[0] else step
                total = total * (1.0 - np.minimum(level, 1.0)) if track is not self.tracks[0] else total
                step += level * way.travel(_steps(self.phase(track, block, times), block.play))
                total += level
        step = step / np.maximum(total, 1.0)
        yaw = np.concatenate([[0.0], np.cumsum(step[2])])
        # a turn about +Y takes +Z towards +X: z -> e^(i yaw) z with z = x - i z_axis
        moved = np.cumsum(np.exp(1j * yaw[:-1]) * (step[0] - 1j * step[1]))
        place = np.concatenate([[0.0], moved])
        return times, np.stack([place.real, -place.imag, yaw])


def levels(blocks: Items[Block], times: F8) -> F8:
    """f8[k,m]: how loud each of a track's blocks is. In a cross-fade they sum to at least 1, whatever their curves:
    what lies below, or the rest pose, does not show through. Each block's weight scales its level in the end."""
    out = np.array([b.level(times) for b in blocks]).reshape(len(blocks), len(times))
    fading = np.zeros(len(times), np.bool_)
    for a, b in itertools.permutations(blocks, 2):
        overlap = a.end - b.start
        # both fades lie within the overlap, so that at its ends one block is at its full level: no jump there
        if a.start < b.start and a.end < b.end and overlap > 0.0 and max(a.fade_out, b.fade_in) <= overlap + 1e-9:
            fading |= (times >= b.start) & (times <= a.end)
    total = out.sum(axis=0)
    quiet = fading & (total < 1.0) & (total > 0.0)
    out[:, quiet] /= total[quiet]
    result: F8 = out * np.array([b.weight for b in blocks]).reshape(len(blocks), 1)
    return result


def _share(phase: F8, play: str) -> F8:
    """Where in [0, 1] of the clip a phase with turns is."""
    if play == "once":
        return np.clip(phase, 0.0, 1.0)
    if play == "loop":
        return phase - np.floor(phase)
    there = np.mod(phase, 2.0)
    return np.where(there > 1.0, 2.0 - there, there)


def _steps(phase: F8, play: str) -> Step:
    """The steps between neighbouring phases, as of a playhead."""
    mode = mode_number(play)
    period = 2.0 if mode == PING_PONG else 1.0
    place = np.clip(phase, 0.0, 1.0) if play == "once" else phase
    turn = np.floor(place / period) if play != "once" else np.zeros(len(place))
    inside = place - turn * period
    count = len(phase) - 1
    return Step(
        turn[:-1].astype(np.int64), inside[:-1], turn[1:].astype(np.int64), inside[1:], np.zeros(count, np.bool_),
        np.sign(np.diff(place)).astype(np.int64), np.full(count, mode, np.int64),
    )  # fmt: skip


def write_columns(covers: NDArray[np.bool_]) -> Items[tuple[slice, I8]]:
    """(rows of a pose, rig nodes) per path that something moves."""
    return [(ROWS[path], np.flatnonzero(covers[i])) for i, path in enumerate(("translation", "rotation", "scale"))]
