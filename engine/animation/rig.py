"""Rig: the nodes that a kind of character is posed by; all characters of one rig are posed together."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.assets.clip import ClipAsset
from engine.assets.records import did_you_mean
from engine.assets.scene import NodeAsset
from engine.core.errors import InputError
from engine.math import quat

F8 = NDArray[np.float64]
I8 = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Rig:
    """n nodes, ancestors first. `parent` i8[n]: the nearest ancestor among them, or -1. `rest` f8[10,n]: the pose of a
    node that nothing moves (see poses.py). `source` i8[n]: the nodes' numbers where they came from.

    Raises InputError for lengths that differ, a parent that comes later, or a rest that is not finite.
    """

    names: tuple[str, ...]
    parent: I8
    rest: F8
    source: I8

    def __post_init__(self) -> None:
        count = len(self.names)
        if self.parent.shape != (count,) or self.rest.shape != (10, count) or self.source.shape != (count,):
            raise InputError(f"a rig of {count} names, parents {self.parent.shape}, rest {self.rest.shape}")
        if ((self.parent >= np.arange(count)) | (self.parent < -1)).any():
            raise InputError("a rig's parents must come before their children")
        if not np.isfinite(self.rest).all():
            raise InputError("a rig's rest pose must be finite")

    def __len__(self) -> int:
        return len(self.names)

    def index(self, name: str) -> int:
        """The node of that name. Raises InputError with what was perhaps meant."""
        try:
            return self.names.index(name)
        except ValueError:
            raise InputError(f"there is no node {name!r} that moves", hint=did_you_mean(name, self.names)) from None

    def below(self, root: int) -> I8:
        """i8[n]: how many rig nodes below `root` each node is: 0 for `root` itself, -1 outside its subtree."""
        distance = np.full(len(self), -1, np.int64)
        distance[root] = 0
        for node in range(root + 1, len(self)):
            above = self.parent[node]
            if above >= 0 and distance[above] >= 0:
                distance[node] = distance[above] + 1
        return distance


def rig_of(nodes: Sequence[NodeAsset], keep: ArrayLike | None = None) -> Rig:
    """The rig of a scene's nodes `keep` (all without it), resting where the nodes stand.

    Raises InputError for a node that does not exist.
    """
    kept = np.arange(len(nodes)) if keep is None else np.unique(np.asarray(keep, np.int64))
    if len(kept) and not 0 <= kept[0] <= kept[-1] < len(nodes):
        raise InputError(f"nodes {kept[0]} to {kept[-1]} of {len(nodes)}")
    place = {int(node): i for i, node in enumerate(kept)}
    parent = np.full(len(kept), -1, np.int64)
    for i, node in enumerate(kept):
        above = nodes[int(node)].parent
        while above >= 0 and above not in place:
            above = nodes[above].parent
        parent[i] = place.get(above, -1)
    chosen = [nodes[int(i)] for i in kept]
    rest = np.zeros((10, len(kept)))
    rest[0:3] = np.array([n.translation for n in chosen], np.float64).reshape(-1, 3).T
    rest[3:7] = quat.normalize(np.array([n.rotation for n in chosen], np.float64).reshape(-1, 4)).T
    rest[7:10] = np.array([n.scale for n in chosen], np.float64).reshape(-1, 3).T
    return Rig(tuple(n.name for n in chosen), parent, rest, kept)


def moved_nodes(clips: Iterable[ClipAsset], count: int) -> I8:
    """i8[k]: the nodes, of `count`, whose transform some clip has a channel for, rising."""
    channels = (c for clip in clips for c in clip.channels if c.path != "weights" and 0 <= c.node < count)
    return np.array(sorted({c.node for c in channels}), np.int64)
