"""From motions to poses: which clips each character hears, how loud, and their blend, block by block."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.animation.blend import BlendJob
from engine.animation.graph import ClipUse, Motion
from engine.animation.root_motion import RootMotion

F8 = NDArray[np.float64]
I8 = NDArray[np.int64]

#: Characters posed at a time: their poses stay in the cache.
BLOCK = 256
#: Up to so many characters are sampled one by one.
FEW = 4
#: A share of the pose below this is not sampled.
_SILENT = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Mix:
    """The characters `who` i8[c] in one motion, and the shares f8[k,c] of its clips."""

    motion: Motion
    who: I8
    shares: F8

    def seconds(self, clips: Sequence[ClipUse]) -> F8:
        """f8[c]: how long one run takes: the clips' lengths by their shares, so that all end together."""
        lengths = np.array([clips[c].sampler.duration for c in self.motion.clips])
        result: F8 = lengths @ self.shares
        return result


def mix(motion: Motion, who: I8, values: F8) -> Mix:
    """The shares of the motion's clips for the characters `who`, by the parameters `values` f8[p,m]."""
    if motion.space is None:
        return Mix(motion, who, np.ones((1, len(who))))
    at = np.stack([values[p, who] for p in motion.params], axis=1)
    return Mix(motion, who, motion.space.weights(at))


@dataclass(slots=True, eq=False)
class Voices:
    """One line per character and clip: `character`, `clip`, `phase` in [0,1], `weight`."""

    character: I8
    clip: I8
    phase: F8
    weight: F8


def voices(mixes: Sequence[Mix], fraction: F8, level: F8) -> Voices:
    """The audible clips of the mixes; `fraction` f8[m] the playheads, `level` f8[m] the weight of the whole."""
    parts: list[tuple[I8, I8, F8]] = []
    for m in mixes:
        for row, clip in enumerate(m.motion.clips):
            weight = m.shares[row] * level[m.who]
            loud = weight > _SILENT
            who = m.who[loud]
            parts.append((who, np.full(len(who), clip), weight[loud]))
    if not parts:
        empty = np.zeros(0, np.int64)
        return Voices(empty, empty, np.zeros(0), np.zeros(0))
    who = np.concatenate([p[0] for p in parts])
    return Voices(who, np.concatenate([p[1] for p in parts]), fraction[who], np.concatenate([p[2] for p in parts]))


def together(a: Voices, b: Voices) -> Voices:
    """Both."""
    return Voices(
        np.concatenate([a.character, b.character]), np.concatenate([a.clip, b.clip]),
        np.concatenate([a.phase, b.phase]), np.concatenate([a.weight, b.weight]),
    )  # fmt: skip


class Mixer:
    """Samples and blends voices; keeps its working arrays from frame to frame. `ways`: per clip, what is taken out."""

    def __init__(self, clips: Sequence[ClipUse], rest: F8, ways: Sequence[RootMotion | None]) -> None:
        self._clips, self._rest, self._ways = clips, rest, ways
        self._stack: list[F8] = []
        self._out = np.zeros((10, BLOCK, rest.shape[1]))

    def pose(self, heard: Voices, who: I8, out: F8, held: F8 | None = None, held_weight: F8 | None = None) -> None:
        """Write the blended poses of the characters `who` (rising) to `out` f8[10,m,n].

        `held` f8[10,m,n] joins in with `held_weight` f8[m]. Who hears nothing rests.
        """
        if len(who) <= FEW:
            self._few(heard, who, out, held, held_weight)
            return
        order = np.lexsort((heard.clip, heard.character))
        character, clip = heard.character[order], heard.clip[order]
        phase, weight = heard.phase[order], heard.weight[order]
        slot = np.arange(len(character)) - np.searchsorted(character, character, side="left")
        for start in range(0, len(who), BLOCK):
            block = who[start : start + BLOCK]
            low, high = np.searchsorted(character, block[0]), np.searchsorted(character, block[-1], side="right")
            part = slice(int(low), int(high))
            place = np.searchsorted(block, character[part])
            mine = block[np.minimum(place, len(block) - 1)] == character[part]
            chosen = np.flatnonzero(mine) + part.start
            self._block(
                place[mine], clip[chosen], phase[chosen], weight[chosen], slot[chosen], block, out, held, held_weight
            )

    def _few(self, heard: Voices, who: I8, out: F8, held: F8 | None, held_weight: F8 | None) -> None:
        """As `pose`, line by line: for so few this is less than finding what goes together."""
        place = {character: i for i, character in enumerate(who.tolist())}
        lines = sorted(
            zip(
                heard.character.tolist(), heard.clip.tolist(), heard.phase.tolist(), heard.weight.tolist(), strict=True
            ),
            key=lambda line: line[:2],
        )
        used = [0] * len(place)
        put: list[tuple[int, int, int, float, float]] = []
        for character, clip, phase, weight in lines:
            i = place.get(character)
            if i is not None:
                put.append((used[i], i, clip, phase, weight))
                used[i] += 1
        inputs = self._inputs(max([*used, 1]), len(place))
        weights = np.zeros((len(inputs), len(place)))
        for pose in inputs:
            pose[...] = self._rest[:, None, :]
        for slot, i, clip, phase, weight in put:
            weights[slot, i] = weight
            sampler, way = self._clips[clip].sampler, self._ways[clip]
            sampler.sample_one(phase * sampler.duration, inputs[slot][:, i])
            if way is not None:
                way.take_out(np.array([phase]), inputs[slot][:, i : i + 1])
        self._blend(inputs, weights, who, out, held, held_weight)

    def _block(
        self, place: I8, clip: I8, phase: F8, weight: F8, slot: I8, block: I8, out: F8, held: F8 | None,
        held_weight: F8 | None,
    ) -> None:  # fmt: skip
        inputs = self._inputs(int(slot.max(initial=0)) + 1, len(block))
        weights = np.zeros((len(inputs), len(block)))
        weights[slot, place] = weight
        for number, pose in enumerate(inputs):
            pose[...] = self._rest[:, None, :]  # just before it is sampled: it is still in the cache then
            here = slot == number
            for which in np.unique(clip[here]):
                lines = np.flatnonzero(here & (clip == which))
                self._sample(int(which), phase[lines], place[lines], pose)
        self._blend(inputs, weights, block, out, held, held_weight)

    def _inputs(self, slots: int, count: int) -> list[F8]:
        """Room for so many poses of `count` characters."""
        while len(self._stack) < slots:
            self._stack.append(np.zeros((10, BLOCK, self._rest.shape[1])))
        return [pose[:, :count] for pose in self._stack[:slots]]

    def _blend(
        self, inputs: list[F8], weights: F8, block: I8, out: F8, held: F8 | None, held_weight: F8 | None
    ) -> None:
        if held is not None and held_weight is not None and (held_weight[block] > 0.0).any():
            inputs.append(held[:, block])
            weights = np.concatenate([weights, held_weight[None, block]])
        result = self._out[:, : len(block)]
        BlendJob(inputs, weights, self._rest, result).run()
        out[:, block] = result

    def _sample(self, clip: int, phase: F8, place: I8, pose: F8) -> None:
        sampler, way = self._clips[clip].sampler, self._ways[clip]
        whole = len(place) == pose.shape[1]
        part = pose if whole else pose[:, place]
        sampler.sample(phase * sampler.duration, part)
        if way is not None:
            way.take_out(phase, part)
        if not whole:
            pose[:, place] = part
