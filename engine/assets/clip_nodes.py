"""Which nodes a clip's channels move: clips know nodes by number, and nodes are added, removed, copied, reordered.

A node's clip number is its `clip_node`, else its own index. Several nodes of one number are copies of each other and
move alike; a `placed` one makes the same moves about a place of its own (scene.copies.OwnPlaces).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from engine.assets.clip import Channel, ClipAsset
from engine.assets.scene import NodeAsset
from engine.math import quat


@dataclass(frozen=True, slots=True)
class ClipNodes:
    """Per clip number the index of the node that leads: its first that is not placed. `moved` has none of the placed,
    `weighed` has the placed where there is no other."""

    moved: dict[int, int]
    weighed: dict[int, int]

    def bind(self, clip: ClipAsset) -> ClipAsset:
        """`clip` with channels that count nodes by index; those whose nodes are all gone are left out."""
        channels = []
        for channel in clip.channels:
            index = (self.weighed if channel.path == "weights" else self.moved).get(channel.node)
            if index is not None:
                channels.append(channel.of_node(index))
        return replace(clip, channels=channels)


def clip_number(node: NodeAsset, index: int) -> int:
    """The number that clips know the node by; -1: no clip moves it."""
    return index if node.clip_node is None else node.clip_node


def clip_nodes(nodes: Sequence[NodeAsset]) -> ClipNodes | None:
    """Who leads; None where every node goes by its own index, and there is nothing to bind."""
    if not any(node.placed or node.clip_node is not None for node in nodes):
        return None
    moved: dict[int, int] = {}
    placed: dict[int, int] = {}
    for index, node in enumerate(nodes):
        number = clip_number(node, index)
        if number >= 0:
            (placed if node.placed else moved).setdefault(number, index)
    return ClipNodes(moved, placed | moved)


def spread(clip: ClipAsset, nodes: Sequence[NodeAsset]) -> ClipAsset:
    """`clip` with channels by index, repeated for every node that they move: for writers of other formats."""
    of: dict[int, list[int]] = {}
    for index, node in enumerate(nodes):
        of.setdefault(clip_number(node, index), []).append(index)
    channels = []
    for channel in clip.channels:
        if channel.node >= len(nodes) and channel.node not in of and clip_nodes(nodes) is None:
            channels.append(channel)  # a clip that does not fit: whoever reads it says so
        for index in of.get(channel.node, ()):
            if channel.path == "weights" or not nodes[index].placed:
                channels.append(channel.of_node(index))
            elif (leader := next((i for i in of[channel.node] if not nodes[i].placed), -1)) >= 0:
                channels.append(_about(channel, nodes[leader], nodes[index], index))
    return replace(clip, channels=channels)


def _about(channel: Channel, leader: NodeAsset, node: NodeAsset, index: int) -> Channel:
    """The channel of a placed node: the leader's moves from where that rests, made from where the node stands."""
    keys = np.array(channel.values, np.float64)
    if channel.path == "rotation":
        turn = quat.multiply(quat.normalize(node.rotation), quat.conjugate(quat.normalize(leader.rotation)))
        keys = quat.multiply(np.broadcast_to(turn, keys.shape), keys)
    elif channel.path == "scale":
        rest = np.asarray(leader.scale, np.float64)
        keys *= np.asarray(node.scale, np.float64) / np.where(rest == 0.0, 1.0, rest)
    else:  # of a cubic key the place, not the tangents
        places = keys[:, 1] if channel.interpolation == "cubic" else keys
        places += np.asarray(node.translation, np.float64) - np.asarray(leader.translation, np.float64)
    return Channel(index, channel.path, channel.interpolation, channel.times, keys.astype(np.float32), node.name)
