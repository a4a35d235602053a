"""Point caches beside an FBX file: the positions of a mesh's points frame by frame, in Maya's .mc/.mcx and in .pc2.

Maya: IFF chunks, big-endian, FOR4 with 32-bit sizes or FOR8 with 64-bit ones; times in ticks of 1/6000 s (Maya's
nCache file format as the Maya API guide describes it). PC2: a header of 32 bytes and little-endian floats.
"""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import FormatError
from importers.gltf.uris import read_regular_file

#: frames kept of one cache: each becomes a morph target
MOST_FRAMES = 512
_TICKS = 6000.0
_ARRAYS = {b"FVCA": (">f4", 12), b"DVCA": (">f8", 24)}


@dataclass(slots=True)
class PointCache:
    """`times` f8[k] seconds, rising; `points` f8[k,n,3] in the mesh's space and the file's units."""

    times: NDArray[np.float64]
    points: NDArray[np.float64]


def read_cache(path: Path, channel: str, points: int, frame_rate: float, max_bytes: int) -> PointCache:
    """The frames of `channel` (any name in .pc2) for a mesh of `points` points.

    `path` is the .xml, .mc, .mcx or .pc2. Raises InputError, FormatError.
    """
    if path.suffix.lower() == ".pc2":
        return _read_pc2(read_regular_file(path, max_bytes), points, frame_rate)
    frames: dict[float, NDArray[np.float64]] = {}
    for file in data_files(path):
        _read_maya(read_regular_file(file, max_bytes), channel, points, frames, max_bytes)
    if not frames:
        raise FormatError(f"holds no frame of {points:,} positions for {channel!r}", where=path)
    times = sorted(frames)
    return PointCache(np.array(times), np.stack([frames[t] for t in times]))


def data_files(path: Path) -> list[Path]:
    """The data that belongs to an .xml: one file, or one per frame."""
    if path.suffix.lower() != ".xml":
        return [path]
    name = re.compile(re.escape(path.stem) + r"(Frame\d+(Tick\d+)?)?\.mcx?$", re.IGNORECASE)
    found = sorted(p for p in path.parent.iterdir() if name.match(p.name))
    if not found:
        raise FormatError("there is no .mc or .mcx file beside it", where=path)
    return found


def _read_maya(
    data: bytes, channel: str, points: int, frames: dict[float, NDArray[np.float64]], max_bytes: int
) -> None:
    wide = data[:4] == b"FOR8"
    if not wide and data[:4] != b"FOR4":
        raise FormatError("is no Maya cache: it does not begin with FOR4 or FOR8")
    head, align = (16, 8) if wide else (8, 4)
    position, time, name, total = 0, 0.0, "", 0
    while position + head <= len(data):
        tag = data[position : position + 4]
        size = struct.unpack_from(">Q" if wide else ">I", data, position + head - align)[0]
        start = position + head
        if tag in (b"FOR4", b"FOR8"):
            position = start + 4  # a group: its chunks follow its type
            continue
        if size > len(data) - start:
            raise FormatError(f"the chunk {tag!r} at byte {position:,} goes beyond the file's end")
        if tag in (b"TIME", b"STIM") and size >= 4:
            time = struct.unpack_from(">i", data, start)[0] / _TICKS
        elif tag == b"CHNM":
            name = data[start : start + size].split(b"\0")[0].decode("utf-8", "replace")
        elif tag in _ARRAYS and name == channel and size == points * _ARRAYS[tag][1]:
            total += points * 24
            if total > max_bytes:
                raise FormatError(f"needs more than {max_bytes:,} bytes of memory")
            values = np.frombuffer(data, _ARRAYS[tag][0], points * 3, start)
            frames[time] = np.nan_to_num(values.astype(np.float64).reshape(-1, 3), posinf=0.0, neginf=0.0)
        position = start + size + -size % align


def _read_pc2(data: bytes, points: int, frame_rate: float) -> PointCache:
    if data[:12] != b"POINTCACHE2\0" or len(data) < 32:
        raise FormatError("is no PC2 cache")
    count, first, step, samples = struct.unpack_from("<iffi", data, 16)
    if count != points or samples < 1 or len(data) - 32 < samples * count * 12 or not step > 0:
        raise FormatError(f"holds {samples} frames of {count} points in {len(data):,} bytes; the mesh has {points:,}")
    values = np.frombuffer(data, "<f4", samples * count * 3, 32).astype(np.float64).reshape(samples, count, 3)
    times = (first + step * np.arange(samples)) / frame_rate
    return PointCache(times, np.nan_to_num(values, posinf=0.0, neginf=0.0))


def thinned(cache: PointCache) -> PointCache:
    """At most MOST_FRAMES frames, evenly taken, the ends among them."""
    count = len(cache.times)
    if count <= MOST_FRAMES:
        return cache
    kept = np.unique(np.linspace(0, count - 1, MOST_FRAMES).round().astype(np.int64))
    return PointCache(cache.times[kept], cache.points[kept])


def frame_weights(cache_times: NDArray[np.float64], times: NDArray[np.float64]) -> NDArray[np.float64]:
    """The weights [len(times), frames] that mix each time's two neighbouring frames; the ends hold."""
    weights = np.zeros((len(times), len(cache_times)))
    after = np.clip(np.searchsorted(cache_times, times), 1, max(len(cache_times) - 1, 1))
    if len(cache_times) == 1:
        weights[:] = 1.0
        return weights
    span = cache_times[after] - cache_times[after - 1]
    share = np.clip((times - cache_times[after - 1]) / span, 0.0, 1.0)
    rows = np.arange(len(times))
    weights[rows, after - 1] = 1.0 - share
    weights[rows, after] = share
    return weights
