"""Compact clips: keys reduced within an error at the skin, then quantised to 16 bits where the error allows.

    ClipAsset ─ key_reduction ─> fewer keys ─ quantise ─> PackedClip ─ unpack ─> ClipAsset (float32 again)

Rotations keep their three smaller components (15 bits each) and the number of the largest, in 6 bytes; translations
and scales 3 x 16 bits between the channel's least and greatest values. Key times are numbers into one table: exact.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.animation.key_reduction import longest, reduce_channel
from engine.assets.clip import Channel, ClipAsset
from engine.math import quat

F8 = NDArray[np.float64]
U2 = NDArray[np.uint16]

#: radians that 15-bit components may turn a rotation by: 2 |dq|, three components half a step of sqrt(2)/32767 off
#: each, the fourth up to three times one of them
ROTATION_ERROR = 2.0 * np.sqrt(3.0 + 9.0) * 0.5 * np.sqrt(2.0) / 32767.0


@dataclass(slots=True)
class PackedChannel:
    """`keys` u2|u4[k]: numbers in the clip's table of times. `values`: u2[k,3] with `low`, `step` f8[3] (translation,
    scale), u2[k,3] (rotation), or float32 as they were."""

    node: int
    path: str
    interpolation: str
    target: str
    keys: NDArray[Any]
    values: NDArray[Any]
    low: F8 | None = None
    step: F8 | None = None


@dataclass(slots=True)
class PackedClip:
    name: str
    start: float
    frame_rate: float
    times: NDArray[np.float32]
    channels: list[PackedChannel] = field(default_factory=list)

    @property
    def nbytes(self) -> int:
        """Bytes of all arrays; 16 for each channel's header."""
        return self.times.nbytes + sum(
            c.keys.nbytes + c.values.nbytes + 16 + (24 if c.low is not None else 0) for c in self.channels
        )

    def unpack(self) -> ClipAsset:
        """The clip with float32 keys."""
        channels = [
            Channel(c.node, c.path, c.interpolation, self.times[c.keys], _decode(c), c.target) for c in self.channels
        ]
        return ClipAsset(self.name, channels, self.start, self.frame_rate)


def compress(clip: ClipAsset, budget: Mapping[tuple[int, str], float]) -> PackedClip:
    """Reduce and quantise `clip` so that each property stays within its budget (key_reduction.skin_budget).

    The quantisation's share is taken off first; where it would take more than half of the budget, and where there is
    no budget, the keys stay float32.
    """
    last = longest(clip)
    coded = [_encode(c, budget.get((c.node, c.path)), i == last) for i, c in enumerate(clip.channels)]
    tables = [times for _, times in coded]
    times = np.unique(np.concatenate(tables)) if tables else np.zeros(0, np.float32)
    number = np.uint16 if len(times) <= 65536 else np.uint32
    for packed, own in coded:
        packed.keys = np.searchsorted(times, own).astype(number)
    return PackedClip(clip.name, clip.start, clip.frame_rate, times, [packed for packed, _ in coded])


def clip_nbytes(clip: ClipAsset) -> int:
    """Bytes of a clip's arrays as they are."""
    return sum(c.times.nbytes + c.values.nbytes + 16 for c in clip.channels)


def encode_rotations(q: F8) -> U2:
    """u2[k,3] of unit quaternions f8[k,4]: 15 bits each of the three smaller, the largest's number in the top bits."""
    largest = np.argmax(np.abs(q), axis=1)
    sign = np.where(np.take_along_axis(q, largest[:, None], axis=1) < 0.0, -1.0, 1.0)
    rest = np.array([[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]])[largest]
    small = np.take_along_axis(q * sign, rest, axis=1)  # in [-1/sqrt 2, 1/sqrt 2]
    code: U2 = np.rint((small * np.sqrt(2.0) + 1.0) * 0.5 * 32767.0).clip(0, 32767).astype(np.uint16)
    code[:, 0] |= ((largest >> 1) << 15).astype(np.uint16)
    code[:, 1] |= ((largest & 1) << 15).astype(np.uint16)
    return code


def decode_rotations(code: U2) -> F8:
    """Unit quaternions f8[k,4]."""
    wide = code.astype(np.int64)
    largest = (wide[:, 0] >> 15) * 2 + (wide[:, 1] >> 15)
    small = ((wide & 32767) / 32767.0 * 2.0 - 1.0) / np.sqrt(2.0)
    rest = np.array([[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]])[largest]
    q = np.zeros((len(code), 4))
    np.put_along_axis(q, rest, small, axis=1)
    missing = np.sqrt(np.maximum(1.0 - np.sum(small * small, axis=1), 0.0))
    np.put_along_axis(q, largest[:, None], missing[:, None], axis=1)
    return quat.normalize(q)


def _encode(channel: Channel, tolerance: float | None, keep_last: bool) -> tuple[PackedChannel, NDArray[np.float32]]:
    empty = np.zeros(0, np.uint16)
    packed = PackedChannel(
        channel.node, channel.path, channel.interpolation, channel.target, empty, np.asarray(channel.values, np.float32)
    )
    if tolerance is None or channel.interpolation == "cubic" or channel.path == "weights":
        return packed, channel.times
    if channel.path == "rotation":
        error, low, step = ROTATION_ERROR, None, None
    else:
        values = np.asarray(channel.values, np.float64)
        low = values.min(axis=0)
        step = (values.max(axis=0) - low) / 65535.0
        # half a step, and the rounding of the result to float32
        error = 0.5 * float(np.linalg.norm(step)) + float(np.abs(values).max()) * 2.0**-22
    coarse = error <= 0.5 * tolerance
    short = reduce_channel(channel, tolerance - error if coarse else tolerance, keep_last=keep_last)
    packed.values = np.asarray(short.values, np.float32)
    if coarse and low is None:
        packed.values = encode_rotations(quat.normalize(np.asarray(short.values, np.float64)))
    elif coarse and low is not None and step is not None:
        packed.low, packed.step = low, step
        scaled = (np.asarray(short.values, np.float64) - low) / np.where(step > 0.0, step, 1.0)
        packed.values = np.rint(scaled).clip(0, 65535).astype(np.uint16)
    return packed, short.times


def _decode(channel: PackedChannel) -> NDArray[np.float32]:
    if channel.values.dtype != np.uint16:
        return channel.values
    if channel.path == "rotation":
        return decode_rotations(channel.values).astype(np.float32)
    assert channel.low is not None
    assert channel.step is not None
    return (channel.low + channel.values * channel.step).astype(np.float32)
