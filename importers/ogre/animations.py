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
    tracks: dict[int, BoneTrack] = {}
    lost: list[int] = []
    for track in animation.tracks:
        row = rig.rows.get(track.bone)
        if row is None:
            lost.append(track.bone)
        elif row in tracks:
            findings.warn("ogre.track", f"bone {rig.nodes[row].name!r} has two tracks; the first counts", where)
        else:
            tracks[row] = track
    if lost:
        findings.error(
            "ogre.track", f"{len(lost)} tracks move bones that the skeleton lacks (handle {lost[0]}); left out", where,
            "export skeleton and animation together",
        )  # fmt: skip
    if tracks:
        _append(clip, tracks, rig, nodes, scale, animation.length, findings, where)
    return clip


def _append(
    clip: ClipAsset, tracks: dict[int, BoneTrack], rig: Rig, nodes: Sequence[int], scale: float, length: float,
    findings: Findings, where: str,
) -> None:  # fmt: skip
    """Add the channels of `tracks` (by joint) to `clip`: all keys of all joints at once."""
    joint = np.repeat(np.array(list(tracks)), [len(track.times) for track in tracks.values()])
    times, rotation, translation, sizes = (
        np.concatenate([getattr(track, name) for track in tracks.values()]).astype(np.float64)
        for name in ("times", "rotation", "translation", "scale")
    )
    usable = (np.abs(times) < 1e18) & (times >= 0)
    for column in (rotation, translation, sizes):
        usable &= (np.abs(column) < 1e18).all(axis=1)
    usable &= np.abs(rotation).max(axis=1, initial=0.0) > 1e-9
    if not usable.all():
        bad = int((~usable).sum())
        name = rig.nodes[int(joint[int(np.argmin(usable))])].name
        findings.error(
            "ogre.not-finite", f"{bad:,} keys are no usable numbers (first: of bone {name!r}); left out", where
        )
        joint, times = joint[usable], times[usable]
        rotation, translation, sizes = rotation[usable], translation[usable], sizes[usable]
    if not len(joint):
        return
    joint, seconds, rows, doubled = _schedule(joint, times.astype(np.float32), length)
    if doubled:
        findings.info("ogre.key-times", f"{doubled:,} keys share the time of another: {clip.name!r} jumps there", where)
    rotation = rotation[rows] / np.linalg.norm(rotation[rows], axis=1, keepdims=True)
    turned = quat.multiply(rig.bind_rotation[joint], rotation)
    turned = (turned / np.linalg.norm(turned, axis=1, keepdims=True)).astype("<f4")
    moved = (rig.bind_translation[joint] + translation[rows] * scale).astype("<f4")
    grown = (rig.bind_scale[joint] * sizes[rows]).astype("<f4")
    scaled = (sizes[rows] != 1.0).any(axis=1)
    starts = np.flatnonzero(np.append(True, joint[1:] != joint[:-1]))
    for first, end in zip(starts.tolist(), [*starts[1:].tolist(), len(joint)], strict=True):
        row, run = int(joint[first]), slice(first, end)
        channels = {"translation": moved[run], "rotation": turned[run]}
        if scaled[run].any():
            channels["scale"] = grown[run]
        for path, values in channels.items():
            clip.channels.append(Channel(nodes[row], path, "linear", seconds[run], values, rig.nodes[row].name))


def _schedule(
    joint: NDArray[np.int64], times: NDArray[np.float32], length: float
) -> tuple[NDArray[np.int64], NDArray[np.float32], NDArray[np.int64], int]:
    """Strictly rising times for each joint: (joint, time, which key) sorted by joint and time, and how many keys
    share the time of another.

    Of keys at one time the first ends what comes before and the last begins what follows: the first goes one step of
    float32 earlier, where there is room. A joint whose last key is before `length` gets its first key again there."""
    order = np.lexsort((times, joint))  # stable: equal ones stay in the file's order
    joint, times = joint[order], times[order]
    fresh = np.append(True, joint[1:] != joint[:-1])
    begins = np.flatnonzero(fresh | np.append(True, times[1:] != times[:-1]))
    ends = np.append(begins[1:] - 1, len(times) - 1)
    run_joint, run_time = joint[begins], times[begins]
    before = np.nextafter(run_time, np.float32(-1))
    floor = np.where(fresh[begins], np.float32(-1), np.append(np.float32(-1), run_time[:-1]))
    twice = (begins != ends) & (before >= 0) & (before > floor)
    final = np.append(run_joint[1:] != run_joint[:-1], True)
    open_end = final & (run_time < np.float32(length) * (1 - 1e-6)) & (abs(length) < 1e18)
    heads = begins[fresh[begins]]
    first_of = dict(zip(joint[heads].tolist(), ends[fresh[begins]].tolist(), strict=True))
    joints = np.concatenate([run_joint, run_joint[twice], run_joint[open_end]])
    seconds = np.concatenate([run_time, before[twice], np.full(int(open_end.sum()), length, np.float32)])
    keys = np.concatenate(
        [ends, begins[twice], np.array([first_of[j] for j in run_joint[open_end].tolist()], np.int64)]
    )
    final_order = np.lexsort((seconds, joints))
    doubled = len(times) - len(begins)
    return joints[final_order], seconds[final_order].astype("<f4"), order[keys[final_order]], doubled
