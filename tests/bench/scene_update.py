"""What a frame costs the CPU before anything is drawn: set transforms, update, cull, by number of nodes."""

from __future__ import annotations

import numpy as np

from engine.math import frustum, projection, quat, transform
from engine.scene.culling import visible_instances
from engine.scene.scene import Scene
from tests.bench.harness import Context, Row


def run(ctx: Context) -> list[Row]:
    rows: list[Row] = []
    for count in (100, 1_000, 10_000) if ctx.quick else (100, 1_000, 10_000, 100_000):
        rows += flat(ctx, count)
        rows += tree(ctx, count)
    return rows


def flat(ctx: Context, count: int) -> list[Row]:
    """`count` roots with one instance each."""
    rng = np.random.default_rng(count)
    scene = Scene()
    where = rng.uniform(-100, 100, size=(2, count, 3))
    turns = quat.normalize(rng.normal(size=(count, 4)))
    nodes = scene.nodes.add_many([""] * count, translations=where[0])
    scene.instances.add_many(nodes, 0, 0, 0, rng.normal(size=(count, 3)), 1.0)
    scene.update()
    lens = projection.perspective_reversed(1.0, 16 / 9, 0.1)
    view = transform.inverse_affine(transform.look_at([120.0, 40.0, 90.0], [0.0, 0.0, 0.0]))
    planes = frustum.planes_from_matrix(lens @ view)
    step = 0

    def move() -> None:
        nonlocal step
        step += 1
        scene.nodes.set_translation(nodes, where[step % 2])

    def move_and_update() -> None:
        move()
        scene.update()

    def turn_and_update() -> None:
        scene.nodes.set_rotation(nodes, turns)
        scene.update()

    some = rng.choice(count, size=max(1, count // 100), replace=False)

    def move_some() -> None:
        scene.nodes.set_translation(some, where[1][some])
        scene.update()

    case = f"{count} roots"
    return [
        ctx.measure(case, "static: update", scene.update),
        ctx.measure(case, "moving: set_translation", move),
        ctx.measure(case, "moving: nodes.update", scene.nodes.update, before=move),
        ctx.measure(
            case, "moving: instances.update", scene.instances.update, before=lambda: (move(), scene.nodes.update())
        ),
        ctx.measure(case, "moving: set + update", move_and_update, note="budget 10 ms at 100k, 1 ms at 10k"),
        ctx.measure(case, "turning: set + update", turn_and_update),
        ctx.measure(case, "1 % moving: set + update", move_some),
        ctx.measure(case, "cull", lambda: visible_instances(scene, planes), note="budget 2.5 ms at 100k"),
        ctx.measure(case, "bounds", scene.bounds),
        ctx.measure(case, "counts", scene.counts),
    ]


def tree(ctx: Context, count: int) -> list[Row]:
    """`count` nodes in six levels, rows in random order."""
    rng = np.random.default_rng(count)
    level = np.sort(rng.integers(0, 6, size=count))
    parents = np.full(count, -1)
    for depth in range(1, 6):
        here, above = np.flatnonzero(level == depth), np.flatnonzero(level == depth - 1)
        if len(above):
            parents[here] = rng.choice(above, size=len(here))
    scene = Scene()
    rows = scene.nodes.add_many([""] * count, batch_parents=parents, translations=rng.normal(size=(count, 3)))
    scene.instances.add_many(rows, 0, 0, 0, np.zeros((count, 3)), 1.0)
    scene.update()
    roots = rows[parents < 0]

    def move_roots() -> None:
        scene.nodes.set_translation(roots, [1.0, 2.0, 3.0])
        scene.update()

    def turn_all() -> None:
        scene.nodes.set_rotation(rows, [0.0, 0.6, 0.0, 0.8])
        scene.update()

    def move_one() -> None:
        scene.nodes.set_translation(int(roots[0]), [1.0, 2.0, 3.0])
        scene.update()

    def rehang() -> None:
        scene.nodes.reparent(int(roots[0]), -1)

    case = f"{count} nodes, 6 levels"
    return [
        ctx.measure(case, "roots move: set + update", move_roots),
        ctx.measure(case, "all turn: set + update", turn_all),
        ctx.measure(case, "one root moves: set + update", move_one),
        ctx.measure(case, "structure change: rebuild + update", scene.update, before=rehang),
    ]
