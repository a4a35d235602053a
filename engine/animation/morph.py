"""Morph targets on the CPU: their weights at a time, and the shape they give. Pure functions, float64."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.animation.sample import sample_track
from engine.animation.tracks import Track
from engine.assets.clip import Channel
from engine.assets.mesh import MorphTarget

F8 = NDArray[np.float64]


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
