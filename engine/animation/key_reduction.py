"""Key reduction: the fewest keys, taken greedily, that keep a clip within a stated error of what it was."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.assets.clip import Channel, ClipAsset
from engine.core.errors import InputError
from engine.math import quat

F8 = NDArray[np.float64]
I8 = NDArray[np.int64]

#: (node, path) -> metres, radians or scale that this property may be off by
Budget = Mapping[tuple[int, str], float]


def skin_budget(
    clip: ClipAsset,
    parent: Sequence[int],
    translation: ArrayLike,
    scale: ArrayLike,
    reach: ArrayLike,
    skin_error: float,
) -> dict[tuple[int, str], float]:
    """How far off each animated property may be so that no vertex is off by more than `skin_error` metres.

    `parent` i[n] (parents first), `translation` and `scale` f8[n,3] at rest, `reach` f8[n]: how far from each node, in
    its own space, vertices lie that follow it (0: none; see animation.reach). A turn of a node by t moves what hangs on
    it by at most t times the longest way down the chain to a vertex; such moves add up along a chain, so each animated
    property on it gets an equal share. To first order in the errors, which are small. Raises InputError for an error
    that is not positive.
    """
    if not skin_error > 0.0:
        raise InputError(f"an error of {skin_error} m at the skin", hint="give a positive length, as 0.001")
    count = len(parent)
    length = np.linalg.norm(np.asarray(translation, np.float64).reshape(count, 3), axis=1)
    size = np.abs(np.asarray(scale, np.float64).reshape(count, 3)).max(axis=1)
    users = np.zeros(count)
    for channel in clip.channels:
        if channel.path == "weights" or not 0 <= channel.node < count:
            continue
        users[channel.node] += 1.0
        values = _values(channel)
        if channel.path == "translation":
            length[channel.node] = max(length[channel.node], float(np.linalg.norm(values, axis=1).max(initial=0.0)))
        elif channel.path == "scale":
            size[channel.node] = max(size[channel.node], float(np.abs(values).max(initial=0.0)))
    far = np.array(reach, np.float64)
    above, chain = np.ones(count), users.copy()
    for node in range(count):
        if parent[node] >= 0:
            above[node] = above[parent[node]] * size[parent[node]]
            chain[node] += chain[parent[node]]
    carries = far > 0.0
    most = np.where(carries, chain, 0.0)
    for node in range(count - 1, -1, -1):
        up = parent[node]
        if up >= 0 and carries[node]:
            far[up] = max(far[up], length[node] + size[node] * far[node])
            most[up] = max(most[up], most[node])
            carries[up] = True
    budget = {}
    for channel in clip.channels:
        node = channel.node
        if channel.path == "weights" or not 0 <= node < count:
            continue
        share = skin_error / max(most[node], 1.0)
        moved = above[node] * (1.0 if channel.path == "translation" else size[node] * far[node])
        if channel.path == "scale":
            moved = above[node] * far[node]
        # nothing hangs on it that is seen: a generous but finite error
        budget[node, channel.path] = share / moved if carries[node] and moved > 0.0 else skin_error
    return budget


def reduce_channel(channel: Channel, tolerance: float, *, keep_last: bool = False) -> Channel:
    """The channel with fewer keys; at every key time of the old one it is off by at most `tolerance` (metres, radians,
    or scale). Between keys it is off by no more, to second order in the angles. Cubic channels and morph weights stay.
    What does not move keeps its first key only, and the last with `keep_last`."""
    if channel.interpolation == "cubic" or channel.path == "weights" or len(channel.times) < 2:
        return channel
    times, values = np.asarray(channel.times, np.float64), _values(channel)
    rotation = channel.path == "rotation"
    if rotation:
        values = quat.normalize(values)
    keep = _kept(times, values, rotation, channel.interpolation == "step", tolerance)
    if keep_last and keep[-1] != len(times) - 1:
        keep = np.append(keep, len(times) - 1)
    return Channel(
        channel.node, channel.path, channel.interpolation, channel.times[keep], channel.values[keep], channel.target
    )


def reduce_clip(clip: ClipAsset, budget: Budget) -> ClipAsset:
    """The clip with each channel reduced within its budget (none: left as it is)."""
    last = longest(clip)
    channels = [
        reduce_channel(c, budget[c.node, c.path], keep_last=i == last) if (c.node, c.path) in budget else c
        for i, c in enumerate(clip.channels)
    ]
    return ClipAsset(clip.name, channels, clip.start, clip.frame_rate)


def longest(clip: ClipAsset) -> int:
    """The channel that gives the clip its length, or -1; its last key has to stay."""
    ends = [float(c.times[-1]) if len(c.times) else -1.0 for c in clip.channels]
    return int(np.argmax(ends)) if ends else -1


def _values(channel: Channel) -> F8:
    values = np.asarray(channel.values, np.float64)
    return values[:, 1] if channel.interpolation == "cubic" else values


def _kept(times: F8, values: F8, rotation: bool, step: bool, tolerance: float) -> I8:
    """The numbers of the keys to keep: from each, the farthest key from which all between are still met."""
    last = len(times) - 1
    if _off(values, np.broadcast_to(values[0], values.shape), rotation).max() <= tolerance:
        return np.zeros(1, np.int64)
    rows = np.ascontiguousarray(values.T)  # components first: each operation runs over keys side by side
    kept = [0]
    while kept[-1] < last:
        start = kept[-1]

        def fits(end: int, start: int = start) -> bool:
            return _span_fits(times, rows, start, end, rotation, step, tolerance)

        good, reach = start + 1, 2
        while start + reach <= last and fits(start + reach):
            good, reach = start + reach, reach * 2
        bad = min(start + reach, last + 1)
        while bad - good > 1:
            middle = (good + bad) // 2
            good, bad = (middle, bad) if fits(middle) else (good, middle)
        kept.append(good)
    return np.array(kept)


def _span_fits(times: F8, rows: F8, start: int, end: int, rotation: bool, step: bool, tolerance: float) -> bool:
    if end - start < 2:
        return True
    begin = float(times[start])
    u = (times[start + 1 : end] - begin) / (float(times[end]) - begin)
    a, b, between = rows[:, start], rows[:, end], rows[:, start + 1 : end]
    if step:
        off = between - a[:, None]
    elif rotation:
        return _arc_fits(a, b, between, u, tolerance)
    else:
        off = between - a[:, None] - (b - a)[:, None] * u
    return bool((off * off).sum(axis=0).max() <= tolerance * tolerance)


def _arc_fits(a: F8, b: F8, between: F8, u: F8, tolerance: float) -> bool:
    """Whether slerp from `a` to `b` at `u` f8[k] is within `tolerance` radians of the unit quaternions f8[4,k]."""
    if float(a @ b) < 0.0:
        b = -b
    angle = max(2.0 * math.atan2(math.sqrt(((b - a) ** 2).sum()), math.sqrt(((a + b) ** 2).sum())), 1e-9)
    inverse = 1.0 / math.sin(angle)
    guess = (np.sin((1.0 - u) * angle) * inverse) * a[:, None] + (np.sin(u * angle) * inverse) * b[:, None]
    less, more = between - guess, between + guess
    square = np.minimum((less * less).sum(axis=0), (more * more).sum(axis=0))
    # the angle between rotations whose quaternions are c apart is 4 asin(c / 2)
    return bool(square.max() <= 4.0 * math.sin(min(tolerance / 4.0, math.pi / 2.0)) ** 2)


def _off(values: F8, guess: F8, rotation: bool) -> F8:
    if rotation:
        return quat.angle_between(values, guess)
    result: F8 = np.linalg.norm(values - guess, axis=1)
    return result
