"""Compact clips: keys reduced within an error at the skin, then written in 16 bits where the error allows.

    ClipAsset ─ key_reduction ─> fewer keys ─ key_codes, measured ─> ClipAsset of coded channels ─ lanim ─> file

Each channel takes the shortest coding (engine.assets.key_codes) that its own keys, read again, are near enough with.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from engine.animation.key_reduction import longest, reduce_channel
from engine.assets.clip import Channel, ClipAsset, CodedChannel
from engine.assets.key_codes import KeyCodes, candidates, unit
from engine.assets.lanim import clip_arrays

F8 = NDArray[np.float64]

#: how much of a budget rounding may take; the rest is for leaving out keys
_ROUNDING = 0.5


def compress(clip: ClipAsset, budget: Mapping[tuple[int, str], float]) -> ClipAsset:
    """Reduce and code `clip` so that each property stays within its budget (key_reduction.skin_budget).

    Rounding's share is taken off first; where it would take more than half of the budget, where 16 bits are no fewer
    bytes, and where there is no budget, the keys stay float32. So do cubic keys and morph weights.
    """
    last = longest(clip)
    channels = [
        compress_channel(c, budget[c.node, c.path], keep_last=i == last) if (c.node, c.path) in budget else c
        for i, c in enumerate(clip.channels)
    ]
    return ClipAsset(clip.name, channels, clip.start, clip.frame_rate)


def compress_channel(channel: Channel, tolerance: float, *, keep_last: bool = False) -> Channel:
    """`channel` with fewer keys in fewer bits, off by at most `tolerance` (metres, radians, or scale)."""
    if channel.interpolation == "cubic" or channel.path == "weights" or not len(channel.times):
        return channel
    rotation = channel.path == "rotation"
    whole = np.asarray(channel.values, np.float64)
    whole = unit(whole) if rotation else whole
    for coded in candidates(whole):
        error = float(coding_error(coded, whole).max(initial=0.0))
        if error > _ROUNDING * tolerance:
            continue
        # what is left of the tolerance goes to the keys between
        short = reduce_channel(channel, tolerance - error, keep_last=keep_last)
        kept = np.isin(channel.times, short.times)
        codes = KeyCodes(coded.coding, coded.codes[kept], coded.low, coded.step)
        if codes.nbytes < short.values.nbytes:
            return CodedChannel(channel.node, channel.path, channel.interpolation, short.times, codes, channel.target)
        break
    return reduce_channel(channel, tolerance, keep_last=keep_last)


def coding_error(codes: KeyCodes, values: F8) -> F8:
    """f8[k]: how far each key is off once read again: metres or scale; radians for unit rotations `values` f8[k,4]."""
    back = codes.decode().astype(np.float64)
    if values.shape[1] != 4:
        return _length(back - values)
    off = np.minimum(_length(back - values), _length(back + values))
    # an angle a is a chord of 2 sin(a / 4); to third order and from above
    return 2.0 * off * (1.0 + off * off / 16.0)


def clip_nbytes(clip: ClipAsset) -> int:
    """Bytes of a clip's arrays as a file has them."""
    return sum(array.nbytes for array in clip_arrays(clip).values())


def _length(rows: F8) -> F8:
    result: F8 = np.sqrt(np.sum(rows * rows, axis=1))
    return result
