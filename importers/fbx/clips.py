"""Clips: baked tracks become channels of linear keys, timed from the start of the stack."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.assets.clip import Channel, ClipAsset
from engine.assets.scene import NodeAsset
from importers.fbx import morphs
from importers.fbx.document import LARGEST, FbxDocument, Json
from importers.fbx.geometry_cache import frame_weights

Floats = NDArray[np.float64]


def read_clips(
    doc: FbxDocument, nodes: list[NodeAsset], rows: dict[int, int], shapes: dict[int, morphs.Shapes]
) -> list[ClipAsset]:
    """One clip per stack that moves something. `shapes[row]`: what shapes the mesh on that node."""
    clips = []
    for index, stack in enumerate(doc.data["stacks"]):
        name = str(stack["name"]) or f"clip_{index}"
        where = f"stacks[{name}]"
        if stack["error"]:
            doc.findings.error("fbx.stack", f"cannot be sampled: {stack['error']}; left out", where)
            continue
        clip = ClipAsset(name, start=float(stack["begin"]), frame_rate=float(doc.data["frame_rate"]))
        span = (float(stack["begin"]), float(stack["end"]))
        resting: list[Channel] = []
        for node, path, times, values in stack["tracks"]:
            if node not in rows:
                continue
            row = rows[node]
            keys = _keys(doc, times, values, span, f"{where}.{doc.names[node]}.{path}")
            if keys is None:
                continue
            channel = _channel(row, path, *keys, nodes[row].name)
            (resting if _rests(keys[1], path, nodes[row]) else clip.channels).append(channel)
        clip.channels += _weight_channels(doc, stack, span, nodes, shapes, where)
        others = sorted(set(stack["others"]))
        if others:
            some = ", ".join(repr(name) for name in others[:5]) + (" …" if len(others) > 5 else "")
            doc.findings.info("fbx.animation", f"the animation of {some} is not imported", where)
        if not clip.channels and len(doc.data["stacks"]) > 1:
            # of several clips one may hold the rest pose: it brings back what the others moved
            clip.channels = [c for c in resting if c.times[-1] > 0]
        if clip.channels:
            clips.append(clip)
        else:
            doc.findings.info("fbx.empty-clip", f"the animation {name!r} moves nothing; left out", where)
    return clips


def _keys(
    doc: FbxDocument, times: str, values: str, span: tuple[float, float], where: str
) -> tuple[Floats, Floats] | None:
    """Times from 0, cut to the stack's span, and values f8[k,c]; None where there are none."""
    t = np.asarray(doc.array(times), np.float64)
    v = np.asarray(doc.array(values), np.float64).reshape(len(t), -1)
    good = (np.abs(t) < LARGEST) & (np.abs(v) < LARGEST).all(axis=1)
    if not good.all():
        doc.findings.error("fbx.not-finite", f"{int((~good).sum()):,} keys are no numbers; left out", where)
        t, v = t[good], v[good]
    if not len(t):
        return None
    begin, end = span
    if end > begin:
        inside = (t > begin) & (t < end)
        ends = np.array([begin, end])
        t, v = (
            np.concatenate([ends[:1], t[inside], ends[1:]]),
            np.concatenate([_at(t, v, begin), v[inside], _at(t, v, end)]),
        )
    return t - begin, v


def _at(t: Floats, v: Floats, time: float) -> Floats:
    """The values [1,c] at `time`, between keys linearly; quaternions are made unit afterwards."""
    after = int(np.clip(np.searchsorted(t, time), 0, len(t) - 1))
    before = max(after - 1, 0)
    span = t[after] - t[before]
    share = float(np.clip((time - t[before]) / span, 0.0, 1.0)) if span > 0 else 1.0
    other = v[after] if v.shape[1] != 4 or v[after] @ v[before] >= 0 else -v[after]
    result: Floats = (v[before] + (other - v[before]) * share)[None]
    return result


def _rests(values: Floats, path: str, node: NodeAsset) -> bool:
    """Whether all keys are what the node has anyway."""
    rest = np.asarray({"translation": node.translation, "rotation": node.rotation, "scale": node.scale}[path])
    if path == "rotation":
        length = np.maximum(np.linalg.norm(values, axis=1), 1e-30)
        return bool((np.abs(values @ rest) / length >= 1.0 - 1e-12).all())
    return bool(np.allclose(values, rest, rtol=1e-9, atol=1e-12))


def _channel(row: int, path: str, times: Floats, values: Floats, target: str) -> Channel:
    if path == "rotation":
        length = np.linalg.norm(values, axis=1, keepdims=True)
        values = np.where(length > 1e-12, values / np.maximum(length, 1e-30), [0.0, 0.0, 0.0, 1.0])
    single = times.astype("<f4")
    # of keys that fall on one float the last counts: it is where a step arrives
    last = np.append(single[1:] > single[:-1], True)
    return Channel(row, path, "linear", single[last], np.ascontiguousarray(values[last].astype("<f4")), target)


def _weight_channels(
    doc: FbxDocument, stack: Json, span: tuple[float, float], nodes: list[NodeAsset],
    shapes: dict[int, morphs.Shapes], where: str,
) -> list[Channel]:  # fmt: skip
    """One channel per node with animated shapes, holding the weights of all its morph targets."""
    animated = {int(element): (times, values) for element, times, values in stack["weights"]}
    result = []
    for row, entry in shapes.items():
        channels, cached = entry.channels, entry.cache_times - span[0]
        curves: dict[int, tuple[Floats, Floats]] = {}
        for channel in channels:
            if channel.element in animated:
                keys = _keys(doc, *animated[channel.element], span, f"{where}.{nodes[row].name}.weights")
                if keys is not None:
                    curves[channel.element] = (keys[0], keys[1][:, 0] / 100.0)
        if not curves and not len(cached):
            continue
        moments = [t for t, _ in curves.values()]
        if len(cached):
            length = max(span[1] - span[0], 0.0)
            moments += [cached[(cached >= 0.0) & (cached <= length)], np.array([0.0, length])]
        moments += [morphs.crossings(c.targets, *curves[c.element]) for c in channels if c.element in curves]
        times = np.unique(np.concatenate(moments))
        columns = []
        for channel in channels:
            if channel.element in curves:
                weight = np.interp(times, *curves[channel.element])
            else:
                weight = np.full(len(times), channel.weight)
            columns.append(morphs.effective_weights(channel.targets, weight))
        if len(cached):
            columns.append(frame_weights(cached, times))
        values = np.concatenate(columns, axis=1)
        if not np.allclose(values, np.asarray(nodes[row].weights), rtol=1e-9, atol=1e-12):
            result.append(_channel(row, "weights", times, values, nodes[row].name))
    return result
