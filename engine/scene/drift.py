"""Lights that drift: the clip that moves what was scattered, and how a written scene's nodes are named in it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from engine.assets.clip import Channel, ClipAsset
from engine.assets.clip_nodes import clip_number
from engine.assets.scene import SceneAsset
from engine.scene.scene import Scene

#: the name of such clips: a scene that opens plays them beside its first clip
DRIFT = "drift"
#: seconds of a turn, and keys
TURN, KEYS = 16.0, 33


def drift_clip(scene: Scene, top: int, distance: float, seed: int) -> ClipAsset:
    """Return a clip in which each child of node `top` circles by `distance` metres about where it is, 16 s a turn.

    Its channels count nodes by their rows. Playing it runs no code per light.
    """
    rows = np.flatnonzero(scene.nodes.alive & (scene.nodes.parent == top))
    rng = np.random.default_rng(seed)
    times = np.linspace(0.0, TURN, KEYS).astype(np.float32)
    turn = np.linspace(0.0, 2.0 * np.pi, KEYS)[:, None] + rng.uniform(0.0, 2.0 * np.pi, len(rows))
    circle = np.stack([np.cos(turn), 0.4 * np.sin(2.0 * turn), np.sin(turn)], axis=-1)
    path = (scene.nodes.translation[rows] + distance * circle).astype(np.float32)
    return ClipAsset(
        DRIFT,
        [
            Channel(row, "translation", "linear", times, np.ascontiguousarray(path[:, i]), scene.nodes.name[row])
            for i, row in enumerate(rows.tolist())
        ],
    )


def free_name(asset: SceneAsset, stem: str) -> str:
    """Return a file name for a drift that `asset`, to be written as STEM.scene.json, does not name yet."""
    name, number = f"{stem}.{DRIFT}.lanim", 1
    while name in asset.clips:
        number += 1
        name = f"{stem}.{DRIFT}{number}.lanim"
    return name


def add_clips(asset: SceneAsset, file: str, clips: Sequence[ClipAsset], index_of: Mapping[int, int]) -> ClipAsset:
    """Name `file` among the clips of `asset`, and return what belongs into it: all of `clips` as one.

    `index_of`: the index in `asset` of each node row that is in it; channels of others are left out. Where the scene
    has other clips its nodes go by numbers of their own (see clip_nodes), and these nodes get new ones."""
    numbers = [clip_number(node, index) for index, node in enumerate(asset.nodes)]
    plain = all(node.clip_node is None and not node.placed for node in asset.nodes)
    free = max([len(asset.nodes), *(n + 1 for n in numbers)])
    channels = []
    for clip in clips:
        for channel in clip.channels:
            index = index_of.get(channel.node)
            if index is None:
                continue
            if not plain and numbers[index] < 0:
                numbers[index] = asset.nodes[index].clip_node = free
                free += 1
            channels.append(replace(channel, node=numbers[index], target=asset.nodes[index].name))
    asset.clips = [*asset.clips, file]
    return ClipAsset(DRIFT, channels)
