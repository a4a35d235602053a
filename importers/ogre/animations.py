"""Skeleton animations become clips: keys relative to the binding pose become keys of the joints' own transforms.

    translation = bind + key        rotation = bind * key        scale = bind * key (by component)

Source: Ogre manual, skeletal animation: a key's translation is added in the parent's space, its rotation is applied in
the bone's own; between keys translations, scales and rotations (shortest way) are linear; after the last key the
animation runs on to its first one, which it reaches at its length.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from engine.assets.clip import Channel, ClipAsset
from engine.core.findings import Findings
from engine.math import quat
from importers.ogre.data import BoneTrack, SkeletonAnimation
from importers.ogre.skeletons import Rig


def make_clip(
    animation: SkeletonAnimation, rig: Rig, nodes: Sequence[int], scale: float, findings: Findings, where: str
) -> ClipAsset:
    """The clip of `animation`; `nodes[row]` is the scene's node of a joint. `scale` multiplies the translations of
    keys (1 but for linked skeletons). Tracks that do not fit are findings."""
    clip = ClipAsset(animation.name or where)
    if animation.base:
        findings.info(
            "ogre.base-key", f"{clip.name!r} is meant to be added to {animation.base!r}; kept by itself", where
        )
    taken: set[int] = set()
    lost: list[int] = []
    doubled = 0
    for track in animation.tracks:
        row = rig.rows.get(track.bone)
        if row is None:
            lost.append(track.bone)
            continue
        if row in taken:
            findings.warn("ogre.track", f"bone {rig.nodes[row].name!r} has two tracks; the first counts", where)
            continue
        taken.add(row)
        doubled += _append(clip, track, rig, row, nodes[row], scale, animation.length, findings, where)
    if lost:
        findings.error(
            "ogre.track", f"{len(lost)} tracks move bones that the skeleton lacks (handle {lost[0]}); left out", where,
            "export skeleton and animation together",
        )  # fmt: skip
    if doubled:
        findings.info("ogre.key-times", f"{doubled:,} keys share the time of another: {clip.name!r} jumps there", where)
    return clip


def _append(
    clip: ClipAsset, track: BoneTrack, rig: Rig, row: int, node: int, scale: float, length: float,
    findings: Findings, where: str,
) -> int:  # fmt: skip
    """Add the track's channels to `clip`; returns how many keys shared the time of another."""
    name = rig.nodes[row].name
    columns = [track.times[:, None], track.rotation, track.translation, track.scale]
    usable = np.all([(np.abs(column) < 1e18).all(axis=1) for column in columns], axis=0)
    usable &= (np.linalg.norm(np.where(usable[:, None], track.rotation, 1.0), axis=1) > 1e-9) & (track.times >= 0)
    if not usable.all():
        findings.error(
            "ogre.not-finite", f"{int((~usable).sum()):,} keys of bone {name!r} are no usable numbers; left out", where
        )
    if not usable.any():
        return 0
    order = np.argsort(track.times[usable], kind="stable")
    times, rotation, translation, sizes = (
        np.asarray(column[usable][order], np.float64) for column in (track.times, *columns[1:])
    )
    doubled = int((times[1:] == times[:-1]).sum())
    times, kept = _rising(times)
    rotation, translation, sizes = rotation[kept], translation[kept], sizes[kept]
    if times[-1] < length - 1e-6 and np.isfinite(length):
        times = np.append(times, length)
        rotation, translation, sizes = (np.concatenate([a, a[:1]]) for a in (rotation, translation, sizes))
    rotation = rotation / np.linalg.norm(rotation, axis=1, keepdims=True)
    seconds = times.astype("<f4")
    turned = quat.multiply(rig.bind_rotation[row], rotation)
    turned /= np.linalg.norm(turned, axis=1, keepdims=True)
    values: dict[str, NDArray[np.float64]] = {
        "translation": rig.bind_translation[row] + translation * scale,
        "rotation": turned,
    }
    if np.abs(sizes - 1.0).max() > 0:
        values["scale"] = rig.bind_scale[row] * sizes
    for path, keys in values.items():
        clip.channels.append(Channel(node, path, "linear", seconds, keys.astype("<f4"), name))
    return doubled


def _rising(times: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Strictly rising times for sorted ones, and which keys they are.

    Of keys at one time the first ends what comes before and the last begins what follows: the first goes one step of
    float32 earlier, where there is room."""
    first = np.flatnonzero(np.append(True, times[1:] != times[:-1]))
    last = np.append(first[1:] - 1, len(times) - 1)
    seconds = times[first].astype(np.float32)
    before = np.nextafter(seconds, np.float32(-1))
    earlier = np.append(np.float32(-1), seconds[:-1])
    twice = (first != last) & (before >= 0) & (before > earlier)
    merged = np.concatenate([seconds, before[twice]]).astype(np.float64)
    rows = np.concatenate([last, first[twice]])
    order = np.argsort(merged, kind="stable")
    return merged[order], rows[order]
