"""Animations: samplers and channels become clips.

Source: glTF 2.0 specification (Khronos, 2021), section 3.11 and appendix C (interpolation).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.assets.clip import PATHS, Channel, ClipAsset
from importers.gltf.accessors import Accessors
from importers.gltf.document import Document, JsonObject
from importers.gltf.extras import CLIP_KEYS, read_extras

_INTERPOLATIONS = {"STEP": "step", "LINEAR": "linear", "CUBICSPLINE": "cubic"}


def read_animation(
    doc: Document, accessors: Accessors, index: int, rows: dict[int, int], names: list[str], morphs: dict[int, int]
) -> ClipAsset:
    """Animation `index`. `rows`: node of the source -> node of the scene; `morphs`: node -> number of morph targets."""
    animation, where = doc.objects("animations")[index], f"animations[{index}]"
    clip = ClipAsset(doc.name(animation, where, f"clip_{index}"))
    own = read_extras(doc, animation, where, CLIP_KEYS)
    start, rate = own.get("start"), own.get("frame_rate")
    clip.start = float(start) if isinstance(start, (int, float)) else 0.0
    clip.frame_rate = float(rate) if isinstance(rate, (int, float)) and rate > 0 else 0.0
    samplers = doc.child_objects(animation, "samplers", where)
    taken: set[tuple[int, str]] = set()
    for number, channel in enumerate(doc.child_objects(animation, "channels", where)):
        place = f"{where}.channels[{number}]"
        target = doc.child(channel, "target", place)
        kind = doc.text(target, "path", f"{place}.target")
        if kind not in PATHS:
            doc.findings.warn("gltf.channel", f"the path {kind[:60]!r} is not animated here; left out", place)
            continue
        node = doc.index(target, "node", f"{place}.target", "nodes")
        if node is None:
            if "node" not in target:
                doc.findings.info("gltf.channel", "the channel names no node; left out", place)
            continue
        if node not in rows:
            doc.findings.info("gltf.channel", f"nodes[{node}] is in no imported scene; left out", place)
            continue
        if (node, kind) in taken:
            doc.findings.warn("gltf.channel", f"nodes[{node}].{kind} is animated twice; the first counts", place)
            continue
        taken.add((node, kind))
        sampler = doc.integer(channel, "sampler", place)
        if sampler is None or not 0 <= sampler < len(samplers):
            doc.findings.error("gltf.index", f"sampler {sampler} does not exist; there are {len(samplers)}", place)
            continue
        width = PATHS[kind] or morphs.get(node, 0)
        if not width:
            doc.findings.warn("gltf.channel", f"nodes[{node}] has no morph targets to animate; left out", place)
            continue
        keys = _keys(doc, accessors, samplers[sampler], f"{where}.samplers[{sampler}]", kind, width)
        if keys is not None:
            interpolation, times, values = keys
            clip.channels.append(Channel(rows[node], kind, interpolation, times, values, names[node]))
    if not clip.channels:
        doc.findings.warn("gltf.empty-clip", f"the animation {clip.name!r} moves nothing", where)
    return clip


def _keys(
    doc: Document, accessors: Accessors, sampler: JsonObject, where: str, kind: str, width: int
) -> tuple[str, NDArray[np.float32], NDArray[np.float32]] | None:
    """(interpolation, times f4[k] strictly rising, values f4[k,c] or f4[k,3,c]); None where they cannot be used."""
    findings = doc.findings
    interpolation = _INTERPOLATIONS[doc.choice(sampler, "interpolation", where, tuple(_INTERPOLATIONS), "LINEAR")]
    arrays = []
    for key in ("input", "output"):
        number = doc.index(sampler, key, where, "accessors")
        values = None if number is None else accessors.floats(number)
        if values is None:
            findings.error("gltf.sampler", f"the {key} cannot be read; the channel is left out", f"{where}.{key}")
            return None
        arrays.append(values)
    times = arrays[0].reshape(-1)
    parts = 3 if interpolation == "cubic" else 1
    if arrays[0].shape[1] != 1 or arrays[1].size != len(times) * parts * width:
        findings.error(
            "gltf.sampler",
            f"{len(times):,} times want {len(times) * parts * width:,} numbers of {kind}, not {arrays[1].size:,}",
            where, "export the animation again",
        )  # fmt: skip
        return None
    values = arrays[1].reshape(len(times), parts, width)
    usable = np.isfinite(times) & np.isfinite(values).all(axis=(1, 2))
    if not usable.all():
        bad = int((~usable).sum())
        findings.error("gltf.not-finite", f"{bad:,} of {len(times):,} keys are no numbers; left out", where)
        times, values = times[usable], values[usable]
    if not len(times):
        findings.error("gltf.sampler", "no key is left; the channel is left out", where)
        return None
    times, values = _in_order(doc, times, values, where)
    values = values.astype("<f4")
    if kind == "rotation":
        values = _unit_rotations(doc, values, where)
    return interpolation, times.astype("<f4"), values if parts == 3 else np.ascontiguousarray(values[:, 0])


def _in_order(doc: Document, times: Any, values: Any, where: str) -> tuple[Any, Any]:
    if (times[1:] > times[:-1]).all():
        return times, values
    order = np.argsort(times, kind="stable")
    sorted_times = times[order]
    # of keys at one time the last one counts
    last = np.append(sorted_times[1:] != sorted_times[:-1], True)
    doc.findings.warn(
        "gltf.key-times",
        f"the times do not strictly rise; sorted, and {int((~last).sum()):,} repeated keys left out", f"{where}.input",
    )  # fmt: skip
    return sorted_times[last], values[order][last]


def _unit_rotations(doc: Document, values: NDArray[np.float32], where: str) -> NDArray[np.float32]:
    """Quaternion keys (the middle of cubic ones) of length 1; tangents scale with them."""
    middle = values[:, values.shape[1] // 2].astype(np.float64)
    length = np.linalg.norm(middle, axis=1)
    zero = length < 1e-12
    if zero.any():
        count = int(zero.sum())
        doc.findings.error("gltf.rotation", f"{count:,} keys are no rotations; taken as none", f"{where}.output")
        values = values.copy()
        values[zero] = 0.0
        values[zero, values.shape[1] // 2, 3] = 1.0
        length = np.where(zero, 1.0, length)
    if (np.abs(length - 1.0) > 1e-2).any():
        doc.findings.warn("gltf.rotation", "some keys are not of length 1; normalised", f"{where}.output")
    # what float32 calls 1 stays bit by bit: keys written out and read again are the same
    length = np.where(np.abs(length - 1.0) < 3e-7, 1.0, length)
    return np.asarray(values / length[:, None, None], np.float32)
