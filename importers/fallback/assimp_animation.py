"""Animations in the worker: Assimp's keys, from ticks to seconds, by node and path."""

from __future__ import annotations

import ctypes as c
from typing import Any

import numpy as np
from numpy.typing import NDArray

from importers.fallback import structs
from importers.fallback.entries import Json, Output

#: where a file does not say how long a tick is
_USUAL_RATE = 25.0


def read_stacks(
    scene: structs.Scene, nodes: dict[str, int], shapes: dict[str, list[int]], out: Output, quat_size: int
) -> list[Json]:
    """One entry per animation; `shapes`: by name of mesh or node, the elements of its morph targets."""
    stacks = []
    for i in range(scene.animation_count):
        animation = scene.animations[i].contents
        rate = float(animation.rate) if np.isfinite(animation.rate) and animation.rate > 0 else _USUAL_RATE
        stack: Json = {"name": animation.name.text(), "error": "", "tracks": [], "weights": [], "others": []}
        end = 0.0
        for k in range(animation.channel_count):
            channel = animation.channels[k].contents
            node = nodes.get(channel.name.text())
            if node is None:
                out.warn("an animated node does not exist; its keys are left out")
                continue
            for path, address, count, size, order in (
                ("translation", channel.positions, channel.position_count, 24, [0, 1, 2]),
                ("rotation", channel.rotations, channel.rotation_count, quat_size, [1, 2, 3, 0]),
                ("scale", channel.scales, channel.scale_count, 24, [0, 1, 2]),
            ):
                times, values = _keys(address, int(count), size, order)
                if len(times):
                    times = times / rate
                    end = max(end, float(np.nan_to_num(times.max(), posinf=0.0)))
                    stack["tracks"].append([node, path, out.put(times), out.put(values)])
        for k in range(animation.morph_count):
            morph = animation.morphs[k].contents
            elements = shapes.get(morph.name.text()) or shapes.get(morph.name.text().partition("*")[0])
            if not elements:
                out.warn("animated morph targets do not exist; their keys are left out")
                continue
            times, weights = _morph_keys(morph, len(elements))
            times = times / rate
            end = max(end, float(times.max(initial=0.0)))
            for column, element in enumerate(elements):
                stack["weights"].append([element, out.put(times), out.put(100.0 * weights[:, column : column + 1])])
        length = float(animation.duration) / rate if np.isfinite(animation.duration) else 0.0
        stack["begin"], stack["end"] = 0.0, length if 0.0 < length < 1e6 else end
        stacks.append(stack)
    return stacks


def _keys(
    address: int | None, count: int, size: int, order: list[int]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Times in ticks, rising, and values in the given order of components."""
    if not address or not count:
        return np.zeros(0), np.zeros((0, len(order)))
    raw = np.frombuffer(c.string_at(address, count * size), np.uint8).reshape(count, size)
    times = np.ascontiguousarray(raw[:, :8]).view("<f8")[:, 0]
    values = np.ascontiguousarray(raw[:, 8 : 8 + 4 * len(order)]).view("<f4").astype(np.float64)[:, order]
    rising = np.argsort(times, kind="stable")
    return times[rising], values[rising]


def _morph_keys(morph: Any, shapes: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    times, weights = np.zeros(morph.count), np.zeros((morph.count, shapes))
    for row in range(morph.count):
        key = morph.keys[row]
        times[row] = key.time
        for k in range(key.count):
            if key.values[k] < shapes:
                weights[row, key.values[k]] = key.weights[k]
    return np.nan_to_num(times), np.nan_to_num(weights)
