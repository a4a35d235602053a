"""Morph targets on the CPU: their weights at a time, the shape they give, and a clip's weights played, float64."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.animation.sample import sample_track
from engine.animation.tracks import Track
from engine.assets.clip import Channel, ClipAsset
from engine.assets.mesh import MorphTarget
from engine.scene.morphs import MorphTable

F8 = NDArray[np.float64]
I8 = NDArray[np.int64]


def sample_weights(channel: Channel, time: float) -> F8:
    """The weights f8[targets] of a `weights` channel at `time` (seconds); the end values hold outside the keys."""
    times = np.asarray(channel.times, np.float64)
    values = np.asarray(channel.values, np.float64)
    first, count = np.zeros(1, np.int64), np.array([len(times)], np.int64)
    track = Track("weights", channel.interpolation, first, first, count, times, values)
    result: F8 = sample_track(track, time)[0]
    return result


def morphed(base: ArrayLike, targets: Sequence[MorphTarget], weights: ArrayLike, stream: str = "position") -> F8:
    """base + sum of weight * offsets, f8[n,3] (glTF 2.0, 3.7.2.2). Targets without that stream do not move it; missing
    weights are 0."""
    result = np.array(base, np.float64)
    for target, weight in zip(targets, np.asarray(weights, np.float64), strict=False):
        offsets = target.streams.get(stream)
        if offsets is not None and weight != 0.0:
            result += float(weight) * offsets.astype(np.float64)
    return result


def target_reach(targets: Sequence[MorphTarget]) -> F8:
    """f8[t]: the farthest, in metres of mesh space, that each target moves a vertex at weight 1."""
    far = [np.linalg.norm(t.streams["position"], axis=1).max(initial=0.0) if "position" in t.streams else 0.0
           for t in targets]  # fmt: skip
    return np.nan_to_num(np.array(far, np.float64), posinf=0.0)


class WeightPlayer:
    """The `weights` channels of a clip, bound to the rows of a MorphTable by node. `numbers` i8[k]: what it sets.

    `node_rows[i]`: the scene row of the clip's node i. A channel with another number of targets than its mesh has is
    left out."""

    def __init__(self, clip: ClipAsset, node_rows: ArrayLike, morphs: MorphTable) -> None:
        rows = np.asarray(node_rows, np.int64)
        found: dict[str, list[tuple[I8, F8, F8]]] = {}
        self.duration = 0.0
        for channel in clip.channels:
            if channel.path != "weights" or not 0 <= channel.node < len(rows) or rows[channel.node] < 0:
                continue
            row = int(morphs.of_nodes(rows[channel.node : channel.node + 1])[0])
            times, values = np.asarray(channel.times, np.float64), np.asarray(channel.values, np.float64)
            good = np.isfinite(times) & np.isfinite(values).all(axis=tuple(range(1, values.ndim)))
            times, values = times[good], values[good]
            if row < 0 or values.shape[-1] != morphs.count[row] or len(times) == 0 or (np.diff(times) <= 0.0).any():
                continue
            numbers = morphs.first[row] + np.arange(morphs.count[row])
            found.setdefault(channel.interpolation, []).append((numbers, times, values))
            self.duration = max(self.duration, float(times[-1]))
        self._tracks = [_weight_track(kind, parts) for kind, parts in found.items()]
        self.numbers: I8 = np.concatenate([t.rows for t in self._tracks]) if self._tracks else np.zeros(0, np.int64)

    def sample(self, time: float) -> F8:
        """f8[k]: the weights at `time` (seconds, in the clip)."""
        values = [sample_track(track, time)[:, 0] for track in self._tracks]
        return np.concatenate(values) if values else np.zeros(0)


def _weight_track(interpolation: str, parts: Sequence[tuple[I8, F8, F8]]) -> Track:
    """Every target of every channel as a channel of one number."""
    rows, firsts, counts, times, values = [], [], [], [], []
    at = 0
    for numbers, keys, weights in parts:
        for i, number in enumerate(numbers.tolist()):
            rows.append(number)
            firsts.append(at)
            counts.append(len(keys))
            times.append(keys)
            values.append(weights[..., i : i + 1])
            at += len(keys)
    return Track(
        "weights", interpolation, np.array(rows, np.int64), np.array(firsts, np.int64), np.array(counts, np.int64),
        np.concatenate(times), np.concatenate(values),
    )  # fmt: skip
