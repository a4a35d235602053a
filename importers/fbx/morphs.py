"""Blend shapes: channels with in-between shapes become plain morph targets and their weights.

A channel of FBX runs through its shapes at rising target weights; between two neighbours the shapes are mixed
linearly, with the unmoved mesh at 0; beyond the ends the mix of the last two goes on.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.assets.mesh import MorphTarget
from importers.fbx.document import FbxDocument, Json

Floats = NDArray[np.float64]


@dataclass(slots=True)
class Shapes:
    """All that shapes the mesh of one node: blend channels, and after their targets one per frame of a point cache,
    with the frames' times f8[k] in the file's own seconds."""

    channels: list[Channel]
    cache_times: NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Channel:
    """`first`: its first morph target; `targets`: rising target weights, one per morph target."""

    element: int
    first: int
    targets: tuple[float, ...]
    weight: float


def read_channels(mesh: Json) -> list[Channel]:
    channels: list[Channel] = []
    first = 0
    for entry in mesh["channels"]:
        targets = tuple(float(key["target"]) for key in entry["keys"])
        channels.append(Channel(int(entry["element"]), first, targets, float(entry["weight"])))
        first += len(targets)
    return channels


def rest_weights(channels: list[Channel]) -> list[float]:
    """The weights of all morph targets as the file has them."""
    return [float(v) for channel in channels for v in effective_weights(channel.targets, np.array([channel.weight]))[0]]


def effective_weights(targets: tuple[float, ...], weight: Floats) -> Floats:
    """The weights [n, targets] of a channel's shapes where the channel has `weight` [n]."""
    points = np.array(sorted({*targets, 0.0}))
    result = np.zeros((len(weight), len(targets)))
    if len(points) < 2:
        return result
    upper = np.clip(np.searchsorted(points, weight, "right"), 1, len(points) - 1)
    share = (weight - points[upper - 1]) / (points[upper] - points[upper - 1])
    for column, target in enumerate(targets):
        index = int(np.searchsorted(points, target))
        result[:, column] += np.where(upper == index, share, 0.0) + np.where(upper - 1 == index, 1.0 - share, 0.0)
        if targets.index(target) != column:
            result[:, column] = 0.0  # two shapes at one weight: the first counts
    return result


def crossings(targets: tuple[float, ...], times: Floats, weight: Floats) -> Floats:
    """The times between keys at which the channel's weight passes one of its targets or 0."""
    found = []
    for level in {*targets, 0.0}:
        before, after = weight[:-1] - level, weight[1:] - level
        passed = before * after < 0
        share = before[passed] / (before[passed] - after[passed])
        found.append(times[:-1][passed] + share * (times[1:] - times[:-1])[passed])
    result: Floats = np.concatenate(found)
    return result


def read_morphs(doc: FbxDocument, mesh: Json, source: NDArray[np.int64], where: str) -> list[MorphTarget]:
    """The targets of all channels for vertices that copy the control points `source`."""
    points = len(doc.array(mesh["positions"]))
    result: list[MorphTarget] = []
    for entry in mesh["channels"]:
        for key in entry["keys"]:
            name = str(entry["name"]) or str(key["name"]) or f"shape_{len(result)}"
            if len(entry["keys"]) > 1:
                name = f"{name}@{key['target']:g}"
            result.append(MorphTarget(name, _streams(doc, key, points, source, f"{where}.{name}")))
    return result


def _streams(
    doc: FbxDocument, key: Json, points: int, source: NDArray[np.int64], where: str
) -> dict[str, NDArray[np.float32]]:
    vertices = doc.array(key["vertices"]).astype(np.int64)
    streams: dict[str, NDArray[np.float32]] = {}
    for stream, name in (("position", "positions"), ("normal", "normals")):
        offsets = doc.floats(key[name], 3)
        if stream == "normal" and (len(offsets) != len(vertices) or not offsets.any()):
            continue
        if len(offsets) != len(vertices):
            doc.findings.error("fbx.shape", f"{len(offsets):,} offsets for {len(vertices):,} points; left out", where)
            offsets = np.zeros((len(vertices), 3))
        # Blender's vertex group of a shape key: how much of its offset each point takes
        share = np.asarray(doc.array(key["weights"]), np.float64)
        if len(share) == len(vertices):
            offsets = offsets * np.nan_to_num(share, posinf=0.0, neginf=0.0)[:, None]
        inside = vertices < points
        if not inside.all():
            doc.findings.error("fbx.shape", f"points beyond the mesh's {points:,}; their offsets are left out", where)
        dense = np.zeros((points, 3))
        dense[vertices[inside]] = offsets[inside]
        streams[stream] = np.ascontiguousarray(dense[source].astype("<f4"))
    return streams
