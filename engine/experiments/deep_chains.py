"""Transforms down a deep hierarchy: how many digits the end of a chain keeps."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.experiments.harness.context import Context
from engine.experiments.harness.experiment import Experiment, Knobs, Order, Outcome, Trial, grid
from engine.math import quat
from engine.math.transform import compose
from engine.report.records import Extreme

F8 = NDArray[np.float64]
Array = NDArray[Any]

CHAINS = 32
DEPTHS = (10, 30, 100, 300, 1000)
#: metres from a joint to its parent, as in a rope or a tail
LINK = 0.1
#: a line of the diagram each: how, and in which numbers
METHODS: dict[str, tuple[str, type[np.float32 | np.float64]]] = {
    f"{by}, {kind.__name__[5:]} bits": (by, kind)
    for by in ("matrices", "quaternions") for kind in (np.float32, np.float64)
}  # fmt: skip


def links(ctx: Context, depth: int) -> F8:
    """f8[depth, chains, 4, 4]: each joint's own transform: a link, turned a little."""
    rng = ctx.rng(f"chain {depth}")
    turn = quat.from_axis_angle(rng.normal(size=(depth, CHAINS, 3)), rng.uniform(0.0, 0.2, (depth, CHAINS)))
    place = np.zeros((depth, CHAINS, 3))
    place[..., 1] = LINK
    return compose(place, turn, np.ones((depth, CHAINS, 3)))


def by_matrices(local: Array) -> Array:
    world = local[0]
    for step in local[1:]:
        world = world @ step
    return np.asarray(world[:, :3, 3])


def by_quaternions(place: Array, turn: Array) -> Array:
    """Rotations and translations apart, as dual quaternions would: half the numbers."""
    at, q = place[0], turn[0]
    for step, more in zip(place[1:], turn[1:], strict=True):
        cross = 2.0 * np.cross(q[:, :3], step)
        at = at + step + q[:, 3:] * cross + np.cross(q[:, :3], cross)
        ax, ay, az, aw = q.T
        bx, by, bz, bw = more.T
        q = np.stack(
            [
                aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
                aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz,
            ], axis=1,
        )  # fmt: skip
    return np.asarray(at)


def truth_of(local: F8) -> Array:
    """By extended precision: 64 bits of fraction where the machine has them."""
    return by_matrices(local.astype(np.longdouble))


def run(ctx: Context, knobs: Knobs) -> Trial:
    depth = knobs["depth"]
    local = ctx.once(f"links {depth}", lambda: links(ctx, depth))
    by, kind = METHODS[knobs["method"]]
    given = local.astype(kind)
    # the truth is of the very numbers that the method is given: their own rounding is not its doing
    truth = ctx.once(f"truth {depth} {kind.__name__}", lambda: truth_of(given.astype(np.float64)))
    if by == "matrices":
        work = lambda: by_matrices(given)  # noqa: E731  (a name for a choice of two)
    else:
        place = np.ascontiguousarray(given[..., :3, 3])
        turn = quat.from_matrix3(local[..., :3, :3]).astype(kind)
        truth = ctx.once(
            f"truth q {depth} {kind.__name__}",
            lambda: by_quaternions(place.astype(np.longdouble), turn.astype(np.longdouble)),
        )
        work = lambda: by_quaternions(place, turn)  # noqa: E731  (as above)

    def judge(got: Array) -> Outcome:
        error = np.linalg.norm((got.astype(np.longdouble) - truth).astype(np.float64), axis=1) * 1e3
        return Outcome({"max_mm": float(error.max()), "median_mm": float(np.median(error))})

    return Trial(work, judge)


def extremes(ctx: Context) -> Iterator[Extreme]:
    local = np.tile(np.eye(4), (1000, 1, 1, 1))
    local[:, :, 1, 3] = LINK
    end = by_matrices(local)[0, 1]
    yield Extreme("1,000 links straight up: 100 m", f"off by {abs(end - 100.0):.1g} m", bool(abs(end - 100.0) < 1e-10))


EXPERIMENT = Experiment(
    title="Deep chains of transforms",
    method="products of 4x4 matrices, and of rotations and translations apart, in float32 and float64",
    truth="the same numbers multiplied in extended precision",
    metric="max_mm",
    unit="mm at the end of the chain",
    knobs=grid(method=tuple(METHODS), depth=DEPTHS),
    default={"method": "matrices, 64 bits", "depth": 100},
    curve="method",
    problem="depth",
    run=run,
    orders=[
        Order(
            1.5,
            "errors add up at random, on arms that grow with the depth",
            "depth",
            step=lambda k: float(k["depth"]),
            curve="matrices, 64 bits",
            tolerance=0.6,
        ),
        Order(
            1.5,
            "the same in float32, a billion times as much",
            "depth",
            step=lambda k: float(k["depth"]),
            curve="matrices, 32 bits",
            tolerance=0.6,
        ),
    ],
    extremes=extremes,
    step_label="joints in the chain",
    note="The scene's hierarchy is float64: a tail of a thousand joints is still exact to less than a wavelength.",
)
