"""`.lanim`: one animation clip in a safetensors container, mapped.

Arrays of channel i: `c<i>.times`, `c<i>.values`. Metadata, schema `lucarna.anim/1`:

    {"schema", "name", "start", "frame_rate", "provenance": {…},
     "channels": [[node, path, interpolation, target], …]}
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from engine.assets.clip import INTERPOLATIONS, PATHS, Channel, ClipAsset
from engine.assets.container import natural, read_container, write_container
from engine.core.errors import FormatError, Place

SCHEMA = "lucarna.anim/1"


def write_lanim(path: Path, clip: ClipAsset, provenance: Mapping[str, str] | None = None) -> None:
    """Write `clip`, checked as on reading. Raises FormatError, OutputError."""
    arrays: dict[str, NDArray[Any]] = {}
    channels = []
    for i, channel in enumerate(clip.channels):
        check_channel(channel, Place(str(path), path=f"channels[{i}]"))
        arrays[f"c{i}.times"] = channel.times
        arrays[f"c{i}.values"] = channel.values
        channels.append([int(channel.node), channel.path, channel.interpolation, channel.target])
    metadata = {
        "schema": SCHEMA, "name": clip.name, "channels": channels, "provenance": dict(provenance or {}),
        "start": float(clip.start), "frame_rate": float(clip.frame_rate),
    }  # fmt: skip
    write_container(path, metadata, arrays)


def read_lanim(path: Path) -> ClipAsset:
    """The clip; arrays are read-only views of the mapped file.

    Checked: dtypes, shapes, times strictly rising, finite keys. Raises InputError, FormatError.
    """
    metadata, arrays = read_container(path, SCHEMA)
    try:
        clip = ClipAsset(str(metadata["name"]))
        clip.start, clip.frame_rate = float(metadata.get("start", 0.0)), float(metadata.get("frame_rate", 0.0))
        for i, (node, kind, interpolation, target) in enumerate(metadata["channels"]):
            times = cast("NDArray[np.float32]", arrays[f"c{i}.times"])
            values = cast("NDArray[np.float32]", arrays[f"c{i}.values"])
            clip.channels.append(Channel(natural(node), str(kind), str(interpolation), times, values, str(target)))
    except (KeyError, TypeError, ValueError) as error:
        raise FormatError(f"bad description: {type(error).__name__}: {error}", where=path) from error
    for i, channel in enumerate(clip.channels):
        check_channel(channel, Place(str(path), path=f"channels[{i}]"))
    return clip


def check_channel(channel: Channel, place: Place) -> None:
    """Raise FormatError at `place` when the channel breaks its contract (see engine.assets.clip)."""
    times, values = channel.times, channel.values
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
    components = PATHS[channel.path] or values.shape[-1] if values.ndim else 0
    shape = (len(times), 3, components) if channel.interpolation == "cubic" else (len(times), components)
    if values.dtype != np.dtype("<f4") or values.shape != shape:
        raise FormatError(f"values are {values.dtype}{list(values.shape)}, expected <f4{list(shape)}", where=place)
    if not np.isfinite(times).all() or not (times[1:] > times[:-1]).all():
        raise FormatError("times are not finite and strictly rising", where=place)
    if not np.isfinite(values).all():
        raise FormatError("values are not finite", where=place)
