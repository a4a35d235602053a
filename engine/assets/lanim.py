"""`.lanim`: one animation clip in a safetensors container, mapped.

Schema `lucarna.anim/2`, arrays:

    channels  i4[c,7]   node | path | interpolation | coding | components | keys | first of them in `keys`
    times     f4[t]     seconds, strictly rising: of every key of every channel
    keys      u2|u4[…]  numbers in `times`; channels with keys at the same times share a run
    codes     u2[…]     channel after channel, key after key: those whose coding is not float (key_codes)
    ranges    f4[…]     channel after channel: lows, then steps, where the coding has a box
    floats    f4[…]     channel after channel: the keys of the others; a cubic one has three times the components

Paths, interpolations, codings and lengths count as in clip.PATHS, clip.INTERPOLATIONS, key_codes.CODINGS. Metadata:

    {"schema", "name", "start", "frame_rate", "targets": [node name, …], "provenance": {…}}

What is in codes is decoded when it is first asked for. Files of schema 1 (float32, two arrays a channel) are read too.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from engine.assets.clip import INTERPOLATIONS, PATHS, Channel, ClipAsset, CodedChannel
from engine.assets.container import natural, read_container, write_container
from engine.assets.key_codes import BOX, CODINGS, FLOAT, KeyCodes, box_width, code_width
from engine.core.errors import FormatError, Place

SCHEMA = "lucarna.anim/2"
OLD_SCHEMA = "lucarna.anim/1"
_PATHS = tuple(PATHS)
_COLUMNS = 7
_DTYPES = {"channels": "<i4", "times": "<f4", "codes": "<u2", "ranges": "<f4", "floats": "<f4"}

Arrays = Mapping[str, NDArray[Any]]


def write_lanim(path: Path, clip: ClipAsset, provenance: Mapping[str, str] | None = None) -> None:
    """Write `clip`, checked as on reading. Raises FormatError, OutputError."""
    for i, channel in enumerate(clip.channels):
        check_channel(channel, Place(str(path), path=f"channels[{i}]"))
    metadata = {
        "schema": SCHEMA, "name": clip.name, "start": float(clip.start), "frame_rate": float(clip.frame_rate),
        "targets": [c.target for c in clip.channels], "provenance": dict(provenance or {}),
    }  # fmt: skip
    write_container(path, metadata, clip_arrays(clip))


def clip_arrays(clip: ClipAsset) -> dict[str, NDArray[Any]]:
    """The arrays of a file of `clip`, whose channels are good."""
    channels = clip.channels
    table = [np.zeros(0, np.float32), *(np.asarray(c.times, np.float32) for c in channels)]
    times = np.unique(np.concatenate(table) + np.float32(0.0))  # -0 is 0
    number: type[np.unsignedinteger[Any]] = np.uint16 if len(times) <= 1 << 16 else np.uint32
    runs: dict[bytes, int] = {}
    keys: list[NDArray[Any]] = [np.zeros(0, number)]
    parts: dict[str, list[NDArray[Any]]] = {"codes": [], "ranges": [], "floats": []}
    rows, at = [], 0
    for channel in channels:
        run = np.searchsorted(times, channel.times).astype(number)
        first = runs.setdefault(run.tobytes(), at)
        if first == at:
            keys.append(run)
            at += len(run)
        codes = channel.codes
        if codes is None:
            parts["floats"].append(np.asarray(channel.values, np.float32).reshape(-1))
        else:
            parts["codes"].append(codes.codes.reshape(-1))
            parts["ranges"] += [codes.low, codes.step]
        width = PATHS[channel.path] or channel.values.shape[-1]
        rows.append([
            channel.node, _PATHS.index(channel.path), INTERPOLATIONS.index(channel.interpolation),
            FLOAT if codes is None else codes.coding, width, len(run), first,
        ])  # fmt: skip
    arrays: dict[str, NDArray[Any]] = {
        "channels": np.array(rows, np.int32).reshape(-1, _COLUMNS), "times": times, "keys": np.concatenate(keys)
    }  # fmt: skip
    for name, found in parts.items():
        dtype = np.dtype(_DTYPES[name])
        arrays[name] = np.concatenate([np.zeros(0, dtype), *found]).astype(dtype, copy=False)
    return arrays


def read_lanim(path: Path) -> ClipAsset:
    """The clip; float32 keys are read-only views of the mapped file, others are decoded when first asked for.

    Checked: dtypes, shapes, sizes, times strictly rising, finite keys. Raises InputError, FormatError.
    """
    metadata, arrays = read_container(path, SCHEMA, OLD_SCHEMA)
    try:
        clip = ClipAsset(str(metadata["name"]))
        clip.start, clip.frame_rate = float(metadata.get("start", 0.0)), float(metadata.get("frame_rate", 0.0))
        clip.channels = _old(metadata, arrays) if metadata["schema"] == OLD_SCHEMA else _Reader(arrays).channels
        if metadata["schema"] == SCHEMA:
            targets = metadata["targets"]
            if not isinstance(targets, list) or len(targets) != len(clip.channels):
                raise ValueError(f"{len(clip.channels)} channels have other targets: {targets!r:.80}")
            for channel, target in zip(clip.channels, targets, strict=True):
                channel.target = str(target)
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise FormatError(f"bad description: {type(error).__name__}: {error}", where=path) from error
    for i, channel in enumerate(clip.channels):
        check_channel(channel, Place(str(path), path=f"channels[{i}]"))
    return clip


@dataclass(slots=True)
class _Reader:
    """Takes channels off the arrays one after another. Raises ValueError where something does not fit."""

    arrays: Arrays

    @property
    def channels(self) -> list[Channel]:
        for name, dtype in _DTYPES.items():
            array = self.arrays[name]
            if array.dtype != np.dtype(dtype) or array.ndim != (2 if name == "channels" else 1):
                raise ValueError(f"{name} are {array.dtype}{list(array.shape)}, expected {dtype}")
        keys, times, table = self.arrays["keys"], self.arrays["times"], self.arrays["channels"]
        if keys.dtype not in (np.dtype("<u2"), np.dtype("<u4")) or keys.ndim != 1:
            raise ValueError(f"keys are {keys.dtype}{list(keys.shape)}, expected <u2 or <u4")
        if table.shape[1] != _COLUMNS:
            raise ValueError(f"channels have {table.shape[1]} columns, expected {_COLUMNS}")
        if len(keys) and int(keys.max()) >= len(times):
            raise ValueError(f"key {int(keys.max())} of {len(times)} times")
        at = dict.fromkeys(("codes", "ranges", "floats"), 0)
        found = [self._channel(row, at) for row in table.tolist()]
        for name, end in at.items():
            if end != len(self.arrays[name]):
                raise ValueError(f"{name} has {len(self.arrays[name])} numbers, the channels have {end}")
        return found

    def _channel(self, row: list[int], at: dict[str, int]) -> Channel:
        node, path, interpolation, coding, width, count, first = row
        named = 0 <= path < len(_PATHS) and 0 <= interpolation < len(INTERPOLATIONS) and 0 <= coding < len(CODINGS)
        if not named or width < 1 or count < 1 or not 0 <= first <= len(self.arrays["keys"]) - count:
            raise ValueError(f"a channel {row} of {len(self.arrays['keys'])} keys")
        kind = _PATHS[path]
        if PATHS[kind] not in (0, width) or (coding > BOX and kind != "rotation"):
            raise ValueError(f"a channel {row}: {kind} of {width} components as {CODINGS[coding]}")
        if coding != FLOAT and (kind == "weights" or INTERPOLATIONS[interpolation] == "cubic"):
            raise ValueError(f"a channel {row}: {INTERPOLATIONS[interpolation]} {kind} as {CODINGS[coding]}")
        times = self.arrays["times"][self.arrays["keys"][first : first + count]]
        if coding == FLOAT:
            cubic = INTERPOLATIONS[interpolation] == "cubic"
            shape = (count, 3, width) if cubic else (count, width)
            values = self._take("floats", int(np.prod(shape, dtype=object)), at).reshape(shape)
            return Channel(natural(node), kind, INTERPOLATIONS[interpolation], times, values)
        codes = self._take("codes", count * code_width(coding, width), at).reshape(count, -1)
        low, step = (self._take("ranges", box_width(coding, width), at) for _ in range(2))
        packed = KeyCodes(coding, cast("NDArray[np.uint16]", codes), low, step)
        return CodedChannel(natural(node), kind, INTERPOLATIONS[interpolation], times, packed)

    def _take(self, name: str, count: int, at: dict[str, int]) -> NDArray[Any]:
        begin = at[name]
        at[name] = begin + count
        if at[name] > len(self.arrays[name]):
            raise ValueError(f"{name} has {len(self.arrays[name])} numbers, too few")
        return self.arrays[name][begin : at[name]]


def _old(metadata: Mapping[str, Any], arrays: Arrays) -> list[Channel]:
    """The channels of a file of schema 1."""
    return [
        Channel(
            natural(node), str(kind), str(interpolation), arrays[f"c{i}.times"], arrays[f"c{i}.values"], str(target)
        )
        for i, (node, kind, interpolation, target) in enumerate(metadata["channels"])
    ]


def check_channel(channel: Channel, place: Place) -> None:
    """Raise FormatError at `place` when the channel breaks its contract (see engine.assets.clip)."""
    times, codes = channel.times, channel.codes
    if channel.path not in PATHS:
        raise FormatError(f"path {channel.path!r} is none of {', '.join(PATHS)}", where=place)
    if channel.interpolation not in INTERPOLATIONS:
        raise FormatError(
            f"interpolation {channel.interpolation!r} is none of {', '.join(INTERPOLATIONS)}", where=place
        )
    if channel.node < 0:
        raise FormatError(f"node {channel.node} is not an index", where=place)
    if times.dtype != np.dtype("<f4") or times.ndim != 1 or not len(times):
        raise FormatError(f"times are {times.dtype}{list(times.shape)}, expected <f4[k], k > 0", where=place)
    if not np.isfinite(times).all() or not (times[1:] > times[:-1]).all():
        raise FormatError("times are not finite and strictly rising", where=place)
    if codes is not None:
        _check_codes(codes, len(times), PATHS[channel.path], place)
        return
    values = channel.values
    components = PATHS[channel.path] or values.shape[-1] if values.ndim else 0
    shape = (len(times), 3, components) if channel.interpolation == "cubic" else (len(times), components)
    if values.dtype != np.dtype("<f4") or values.shape != shape:
        raise FormatError(f"values are {values.dtype}{list(values.shape)}, expected <f4{list(shape)}", where=place)
    if not np.isfinite(values).all():
        raise FormatError("values are not finite", where=place)


def _check_codes(codes: KeyCodes, count: int, width: int, place: Place) -> None:
    """Without decoding: of a box whose corners are finite all is."""
    shape = (count, code_width(codes.coding, width))
    if codes.codes.shape != shape or len(codes.low) != box_width(codes.coding, width):
        raise FormatError(f"codes are {list(codes.codes.shape)}, expected {list(shape)}", where=place)
    low, step = codes.low.astype(np.float64), codes.step.astype(np.float64)
    # a component of a rotation is 1 at most
    largest = 4.0 if width == 4 else float(np.finfo(np.float32).max)
    far = np.abs(low) + 65535.0 * np.abs(step)
    if not np.isfinite(far).all() or (far > largest).any():
        raise FormatError("the range of the keys is not finite, or larger than these keys can be", where=place)
