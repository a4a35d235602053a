"""What a crowd costs the CPU: 1 to 1,000 characters of 19 and 60 joints, each at its own time in a two-clip blend."""

from __future__ import annotations

import numpy as np

from engine.animation.animator import Animator
from engine.animation.blend_space import BlendSpace
from engine.animation.graph import AnimationGraph, ClipUse, Motion, Param, State
from engine.animation.rig import Rig
from engine.animation.sampler import ClipSampler
from engine.assets.clip import Channel, ClipAsset
from engine.scene.nodes import NodeTable
from tests.bench.harness import Context, Row

KEYS = 48


def run(ctx: Context) -> list[Row]:
    counts = (1, 10, 100) if ctx.quick else (1, 10, 100, 1_000)
    return [row for joints in (19, 60) for count in counts for row in crowd(ctx, count, joints)]


def crowd(ctx: Context, count: int, joints: int) -> list[Row]:
    rng = np.random.default_rng(joints)
    # limbs of five joints each on one root, as in people
    parent = np.array([-1] + [0 if i % 5 == 1 else i - 1 for i in range(1, joints)])
    rest = np.zeros((10, joints))
    rest[0:3], rest[6], rest[7:10] = rng.normal(size=(3, joints)) * 0.2, 1.0, 1.0
    rig = Rig(tuple(f"joint {i}" for i in range(joints)), parent, rest, np.arange(joints))
    samplers = [ClipSampler(clip(rng, joints, seconds), rig) for seconds in (1.1, 0.7)]
    graph = AnimationGraph(
        rig, [ClipUse(s) for s in samplers], [State("move", Motion((0, 1), BlendSpace([0.0, 1.0]), (0,)))],
        [Param("speed")],
    )  # fmt: skip
    animator = Animator(graph, count)
    animator.set("speed", rng.uniform(0.1, 0.9, count))
    animator.seek(rng.uniform(0.0, 1.0, count))
    nodes = NodeTable()
    rows = nodes.add_many(
        [""] * (count * joints),
        batch_parents=np.where(parent >= 0, parent + joints * np.arange(count)[:, None], -1).reshape(-1),
    ).reshape(count, joints)
    nodes.update()

    def update() -> None:
        animator.update(1.0 / 60.0)

    def write() -> None:
        animator.write(nodes, rows)

    case = f"{count} x {joints} joints"
    measured = [
        ctx.measure(case, "sample and blend 2 clips", update),
        ctx.measure(case, "write to nodes", write, before=update),
        ctx.measure(case, "hierarchy", nodes.update, before=write),
    ]
    total = sum(row.time.median for row in measured) / count
    return [*measured[:2], Row(case, measured[2].stage, measured[2].time, note=f"all {total:.4f} ms a character")]


def clip(rng: np.random.Generator, joints: int, seconds: float) -> ClipAsset:
    times = np.linspace(0.0, seconds, KEYS).astype(np.float32)
    channels = []
    for joint in range(joints):
        turns = np.cumsum(rng.normal(size=(KEYS, 4)) * 0.05, axis=0) + rng.normal(size=4)
        turns /= np.linalg.norm(turns, axis=1, keepdims=True)
        channels.append(Channel(joint, "rotation", "linear", times, turns.astype(np.float32)))
        for path, values in (("translation", rng.normal(size=(KEYS, 3)) * 0.2), ("scale", np.ones((KEYS, 3)))):
            channels.append(Channel(joint, path, "linear", times, values.astype(np.float32)))
    return ClipAsset(f"{seconds} s", channels)
