"""Poses and morph keys become morph targets, and their tracks one channel of weights a clip. Nothing is lost by it.

A pose is a target. A morph key (all positions at a time) is a target too: between keys k and k + 1 Ogre's positions run
straight from one to the other, and so do weights that run from (1, 0) to (0, 1).

Source: Ogre manual, vertex animation (morph and pose animation, both linear in time).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.assets.clip import Channel
from engine.core.findings import Findings
from importers.ogre.data import Floats, Geometry, MorphKey, OgreMesh, Pose, VertexAnimation, VertexTrack


@dataclass(slots=True)
class Offsets:
    """A morph target over all vertices of the source's geometry `target`: position f4[n,3], normal the same or None."""

    name: str
    target: int
    position: Floats
    normal: Floats | None


@dataclass(slots=True)
class _Ramp:
    """Linear weights of one morph target: times f8[k], values f8[k]."""

    target: int
    times: NDArray[np.float64]
    values: NDArray[np.float64]


class Morphs:
    """The morph targets of a mesh and, by animation, the ramps of their weights.

    `budget` bytes may be spent on targets: a mesh of many vertices and keys can ask for more than a machine has."""

    def __init__(self, mesh: OgreMesh, findings: Findings, budget: int) -> None:
        self.targets: list[Offsets] = []
        self._mesh = mesh
        self._findings = findings
        self._budget = budget
        self._ramps: dict[str, list[_Ramp]] = {}
        self._lengths: dict[str, float] = {}
        self._pose_rows: dict[int, int] = {}
        for number, pose in enumerate(mesh.poses):
            offsets = self._pose(pose, number)
            if offsets is not None:
                self._pose_rows[number] = len(self.targets)
                self.targets.append(offsets)
        for number, animation in enumerate(mesh.animations):
            self._animation(animation, number)

    def channels(self, node: int, target: str) -> dict[str, Channel]:
        """Animation name -> its channel of weights for the node `node` named `target`."""
        result: dict[str, Channel] = {}
        for name, ramps in self._ramps.items():
            length = self._lengths[name]
            times = np.unique(np.concatenate([*(ramp.times for ramp in ramps), [0.0, length]])).astype(np.float32)
            times = np.unique(times)
            values = np.zeros((len(times), len(self.targets)), "<f4")
            for ramp in ramps:
                values[:, ramp.target] += np.interp(times, ramp.times, ramp.values).astype(np.float32)
            result[name] = Channel(node, "weights", "linear", times.astype("<f4"), values, target)
        return result

    # --- targets ---

    def _geometry(self, target: int) -> Geometry | None:
        if target == 0:
            return self._mesh.shared
        parts = self._mesh.submeshes
        return parts[target - 1].geometry if target <= len(parts) else None

    def _room(self, vertices: int, streams: int, where: str) -> bool:
        self._budget -= vertices * streams * 12
        if self._budget < 0:
            self._findings.error(
                "ogre.morph-limit", "the morph targets would take too much memory; the rest is left out", where,
                "raise max_decoded_bytes",
            )  # fmt: skip
        return self._budget >= 0

    def _pose(self, pose: Pose, number: int) -> Offsets | None:
        where = f"poses[{number}]"
        geometry = self._geometry(pose.target)
        if geometry is None:
            self._findings.error("ogre.pose", f"its target {pose.target} has no vertices; left out", where)
            return None
        if not self._room(geometry.count, 1 if pose.normals is None else 2, where):
            return None
        usable = pose.vertices < geometry.count
        usable &= (np.abs(pose.offsets) < 1e18).all(axis=1)
        if not usable.all():
            self._findings.error(
                "ogre.pose", f"{int((~usable).sum()):,} offsets name no vertex or are no numbers; left out", where
            )
        position = np.zeros((geometry.count, 3), np.float32)
        position[pose.vertices[usable]] = pose.offsets[usable]
        normal = None
        if pose.normals is not None and geometry.normal is not None:
            given = np.where(np.abs(pose.normals[usable]) < 4, pose.normals[usable], np.float32(0))
            if given.any():
                normal = np.zeros((geometry.count, 3), np.float32)
                normal[pose.vertices[usable]] = given
        return Offsets(pose.name or f"pose_{number}", pose.target, position, normal)

    def _morph(self, key: MorphKey, geometry: Geometry, target: int, name: str, where: str) -> Offsets | None:
        if len(key.positions) != geometry.count:
            self._findings.error(
                "ogre.morph", f"{len(key.positions):,} positions for {geometry.count:,} vertices; left out", where
            )
            return None
        if not self._room(geometry.count, 1 if key.normals is None else 2, where):
            return None
        with np.errstate(over="ignore", invalid="ignore"):
            position = key.positions - geometry.position
        if not (np.abs(position) < 1e18).all():
            self._findings.error("ogre.morph", "some positions are no numbers; they stay as they are", where)
            position = np.where(np.abs(position) < 1e18, position, np.float32(0))
        normal = None
        if key.normals is not None and geometry.normal is not None:
            with np.errstate(over="ignore", invalid="ignore"):
                normal = key.normals - geometry.normal
            normal = np.where(np.abs(normal) < 4, normal, np.float32(0))
        return Offsets(name, target, position, normal)

    # --- tracks ---

    def _animation(self, animation: VertexAnimation, number: int) -> None:
        where = f"animations[{number}]"
        name = animation.name or f"animation_{number}"
        if name in self._ramps:
            self._findings.warn("ogre.animation", f"a second animation {name!r} is left out", where)
            return
        if animation.base:
            self._findings.info(
                "ogre.base-key", f"{name!r} is meant to be added to {animation.base!r}; kept by itself", where
            )
        ramps: list[_Ramp] = []
        for k, track in enumerate(animation.tracks):
            place = f"{where}.tracks[{k}]"
            ramps += self._pose_track(track, animation.length, place)
            ramps += self._morph_track(track, name, animation.length, place)
        if ramps:
            self._ramps[name] = ramps
            self._lengths[name] = max(animation.length, 0.0)

    def _pose_track(self, track: VertexTrack, length: float, where: str) -> list[_Ramp]:
        keys = sorted((k for k in track.poses if k.time >= 0), key=lambda key: key.time)
        if not keys:
            return []
        times, last = _rising(np.array([key.time for key in keys]))
        keys = [keys[i] for i in last]
        columns: dict[int, NDArray[np.float64]] = {}
        for row, key in enumerate(keys):
            for pose, influence in key.poses:
                if pose not in self._pose_rows:
                    self._findings.error("ogre.pose", f"pose {pose} does not exist or was left out", where)
                    continue
                columns.setdefault(self._pose_rows[pose], np.zeros(len(keys)))[row] = influence
        return [_Ramp(target, *_wrapped(times, values, length)) for target, values in sorted(columns.items())]

    def _morph_track(self, track: VertexTrack, name: str, length: float, where: str) -> list[_Ramp]:
        geometry = self._geometry(track.target)
        keys = sorted((k for k in track.morphs if k.time >= 0), key=lambda key: key.time)
        if not keys:
            return []
        if geometry is None:
            self._findings.error("ogre.morph", f"its target {track.target} has no vertices; left out", where)
            return []
        times, last = _rising(np.array([key.time for key in keys]))
        ramps = []
        for row, i in enumerate(last):
            offsets = self._morph(keys[i], geometry, track.target, f"{name}_{row}", f"{where}.keys[{row}]")
            if offsets is None:
                continue
            if not offsets.position.any() and (offsets.normal is None or not offsets.normal.any()):
                continue  # the mesh as it is: no weight on any target
            values = np.zeros(len(last))
            values[row] = 1.0
            ramps.append(_Ramp(len(self.targets), *_wrapped(times, values, length)))
            self.targets.append(offsets)
        return ramps


def _rising(times: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Strictly rising times, and which of the keys is at each (the last of equal ones)."""
    keep = np.append(times[1:] != times[:-1], True)
    return times[keep], np.flatnonzero(keep)


def _wrapped(
    times: NDArray[np.float64], values: NDArray[np.float64], length: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """After its last key an animation runs on to its first, which it reaches at its length."""
    if times[-1] >= length - 1e-6:
        return times, values
    return np.append(times, length), np.append(values, values[0])
