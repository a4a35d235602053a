"""Tracks: a clip's channels packed for sampling, all of one path and interpolation end to end in the same arrays."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.assets.clip import INTERPOLATIONS, Channel, ClipAsset
from engine.core.findings import Findings
from engine.math import quat

F8 = NDArray[np.float64]
I8 = NDArray[np.int64]

#: The properties that a node has a column for, with their widths.
WIDTHS = {"translation": 3, "rotation": 4, "scale": 3}


@dataclass(frozen=True, slots=True)
class Track:
    """k channels of one `path` and `interpolation`. Channel i has keys first[i] .. first[i] + count[i].

    `rows` i8[k]: node rows. `times` f8[n] seconds, strictly rising in each channel. `values` f8[n,w], or f8[n,3,w] for
    cubic (in-tangent, value, out-tangent). Rotations are unit.
    """

    path: str
    interpolation: str
    rows: I8
    first: I8
    count: I8
    times: F8
    values: F8


def pack(clip: ClipAsset, node_rows: ArrayLike, findings: Findings | None = None) -> list[Track]:
    """Return the tracks of `clip`; `node_rows[i]` is the scene row of node i, or -1 to leave it alone.

    Bad keys (not finite) are dropped, unsorted ones sorted, of keys at one time the last counts, of channels for one
    property the last; a channel for no known node, path or interpolation is left out. All of it is noted in `findings`.
    Morph weights are no node column and left to whoever owns the mesh.
    """
    notes = findings if findings is not None else Findings()
    channels: dict[tuple[int, str], tuple[str, F8, F8]] = {}
    for row, channel, place in _usable(clip, np.asarray(node_rows, np.int64), notes):
        keys = _keys(channel, notes, place)
        if keys is None or row < 0:
            continue
        if (row, channel.path) in channels:
            _note_twice(channel, notes, place)
        channels[row, channel.path] = (channel.interpolation, *keys)
    tracks = []
    for path in WIDTHS:
        for interpolation in INTERPOLATIONS:
            found = [(r, t, v) for (r, p), (i, t, v) in channels.items() if (p, i) == (path, interpolation)]
            if found:
                found.sort(key=lambda item: item[0])
                count = np.array([len(t) for _, t, _ in found], np.int64)
                tracks.append(
                    Track(
                        path, interpolation, np.array([r for r, _, _ in found], np.int64), np.cumsum(count) - count,
                        count, np.concatenate([t for _, t, _ in found]), np.concatenate([v for _, _, v in found]),
                    )
                )  # fmt: skip
    return tracks


def survey(clip: ClipAsset, node_rows: ArrayLike, findings: Findings) -> tuple[I8, float]:
    """What `pack` would find of a clip whose keys are good, without reading them: the rows that it moves, rising, and
    the seconds to the last key."""
    found: dict[tuple[int, str], float] = {}
    for row, channel, place in _usable(clip, np.asarray(node_rows, np.int64), findings):
        if row >= 0 and len(channel.times):
            if (row, channel.path) in found:
                _note_twice(channel, findings, place)
            found[row, channel.path] = float(channel.times[-1])
    return np.array(sorted({row for row, _ in found}), np.int64), max(found.values(), default=0.0)


def _usable(clip: ClipAsset, rows: I8, notes: Findings) -> Iterator[tuple[int, Channel, str]]:
    """(row, channel, place in the clip) of channels of known paths, interpolations and nodes."""
    for index, channel in enumerate(clip.channels):
        place = f"channels[{index}]"
        if channel.path not in WIDTHS:
            if channel.path != "weights":
                notes.warn("clip.path", f"unknown path {channel.path!r}, left out", place)
        elif channel.interpolation not in INTERPOLATIONS:
            notes.warn("clip.interpolation", f"unknown interpolation {channel.interpolation!r}, left out", place)
        elif not 0 <= channel.node < len(rows):
            notes.warn("clip.node", f"no node {channel.node} ({channel.target!r}), left out", place)
        else:
            yield int(rows[channel.node]), channel, place


def _note_twice(channel: Channel, notes: Findings, place: str) -> None:
    notes.warn("clip.twice", f"{channel.path} of {channel.target!r} is animated twice, the last counts", place)


def _keys(channel: Channel, notes: Findings, place: str) -> tuple[F8, F8] | None:
    width = WIDTHS[channel.path]
    times = np.asarray(channel.times, np.float64)
    values = np.asarray(channel.values, np.float64)
    cubic = channel.interpolation == "cubic"
    expected = (len(times), 3, width) if cubic else (len(times), width)
    if times.ndim != 1 or values.shape != expected:
        notes.warn("clip.shape", f"values have shape {values.shape}, expected {expected}; left out", place)
        return None
    good = np.isfinite(times) & np.isfinite(values).all(axis=tuple(range(1, values.ndim)))
    if not good.all():
        notes.warn("clip.finite", f"{np.count_nonzero(~good)} keys are not finite, dropped", place)
        times, values = times[good], values[good]
    if len(times) == 0:
        notes.warn("clip.empty", "no keys, left out", place)
        return None
    if (np.diff(times) <= 0.0).any():
        notes.warn("clip.order", "key times do not rise: sorted, the last of equal times counts", place)
        order = np.argsort(times, kind="stable")
        times, values = times[order], values[order]
        last = np.append(np.diff(times) > 0.0, True)
        times, values = times[last], values[last]
    if channel.path == "rotation":
        values = values.copy()
        if cubic:
            values[:, 1] = quat.normalize(values[:, 1])
        else:
            values = quat.normalize(values)
    return times, values
