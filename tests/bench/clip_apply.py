"""What playing a clip costs the CPU: sample all channels and write them to the nodes, by number of nodes."""

from __future__ import annotations

import numpy as np

from engine.animation.sample import ClipPlayer
from engine.assets.clip import Channel, ClipAsset
from engine.scene.nodes import NodeTable
from tests.bench.harness import Context, Row

KEYS = 100


def run(ctx: Context) -> list[Row]:
    return [row for count in (60, 1_000) for row in play(ctx, count)]


def play(ctx: Context, count: int) -> list[Row]:
    """`count` nodes with translation, rotation and scale, each channel with times of its own."""
    rng = np.random.default_rng(count)
    channels = [
        Channel(
            node, path, "linear", np.sort(rng.uniform(0, 5, KEYS)).astype(np.float32),
            rng.normal(size=(KEYS, width)).astype(np.float32),
        )
        for node in range(count)
        for path, width in (("translation", 3), ("rotation", 4), ("scale", 3))
    ]  # fmt: skip
    clip = ClipAsset("bench", channels)
    nodes = NodeTable()
    rows = nodes.add_many([""] * count)
    nodes.update()
    player = ClipPlayer(clip, rows)
    time = 0.0

    def apply() -> None:
        nonlocal time
        time += 0.016
        player.apply(nodes, time)

    case = f"{count} nodes, {len(channels)} channels"
    return [ctx.measure(case, "apply", apply), ctx.measure(case, "update", nodes.update, before=apply)]
