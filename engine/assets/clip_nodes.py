"""Which nodes a clip's channels move: clips know nodes by number, and nodes are added, removed, copied, reordered.

A node's clip number is its `clip_node`, else its own index. Several nodes of one number are copies of each other and
move alike; a `placed` one keeps its transform and takes only morph weights.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from engine.assets.clip import ClipAsset
from engine.assets.scene import NodeAsset


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
                channels.append(channel if index == channel.node else replace(channel, node=index))
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
                channels.append(replace(channel, node=index))
    return replace(clip, channels=channels)
