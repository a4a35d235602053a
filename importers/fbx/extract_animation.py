"""Animation in the worker: each stack, all its layers blended, sampled so that linear keys reproduce it on frames."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import ufbx
from numpy.typing import NDArray

from importers.fbx.native import Handle, bake, wrap

if TYPE_CHECKING:
    from importers.fbx.extract import Output

#: (our path, ufbx's list, ufbx's flag, components)
_TRACKS = (
    ("translation", "translation_keys", "constant_translation", 3),
    ("rotation", "rotation_keys", "constant_rotation", 4),
    ("scale", "scale_keys", "constant_scale", 3),
)


def read_stacks(scene: Handle, out: Output, frame_rate: float) -> list[dict[str, Any]]:
    """One entry per animation stack; times are those of the file, in seconds.

    Curves that are not linear get a key on every frame; at low frame rates, on halves or quarters of frames.
    """
    rate = frame_rate
    while rate < 24.0:
        rate *= 2.0
    return [_stack(scene, stack, out, rate) for stack in scene.anim_stacks]


def _stack(scene: Handle, stack: Handle, out: Output, rate: float) -> dict[str, Any]:
    described: dict[str, Any] = {"name": stack.name, "error": "", "tracks": [], "weights": [], "others": []}
    try:
        baked = bake(scene, stack.anim, resample_rate=rate, max_keyframe_segments=4096)
    except (ufbx.OutOfMemoryError, ufbx.MemoryLimitError, ufbx.AllocationLimitError) as error:
        raise MemoryError from error
    except ufbx.UfbxError as error:
        return described | {"error": str(error), "begin": 0.0, "end": 0.0}
    described["begin"] = _finite(baked.playback_time_begin)
    described["end"] = _finite(baked.playback_time_end)
    if described["end"] <= described["begin"]:
        described["begin"], described["end"] = _finite(baked.key_time_min), _finite(baked.key_time_max)
    for node in baked.nodes:
        for path, keys, constant, components in _TRACKS:
            times, values = _keys(getattr(node, keys), components, getattr(node, constant))
            described["tracks"].append([int(node.typed_id), path, out.put(times), out.put(values)])
    for element in baked.elements:
        for prop in element.props:
            if prop.name == "DeformPercent":
                times, values = _keys(prop.keys, 1, prop.constant_value)
                described["weights"].append([int(element.element_id), out.put(times), out.put(values)])
            elif not prop.constant_value:
                described["others"].append(prop.name)
    return described


def _keys(keys: Handle, components: int, constant: bool) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Times f8[k] and values f8[k, components] of a baked list; the ends alone where nothing changes."""
    count = len(keys)
    chosen = range(count) if not constant or count < 3 else (0, count - 1)
    times, values = np.empty(len(chosen)), np.empty((len(chosen), components))
    for row, index in enumerate(chosen):
        key = wrap(keys.raw[index]).raw
        times[row] = key.time
        values[row] = key.value[:components]
    return times, values


def _finite(value: float) -> float:
    return float(value) if np.isfinite(value) else 0.0
