"""Playing a smooth motion back from its keys: how it is interpolated, and how many keys it needs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from engine.animation import poses
from engine.animation.rig import Rig
from engine.animation.sampler import ClipSampler
from engine.assets.clip import Channel, ClipAsset
from engine.experiments.harness.context import Context
from engine.experiments.harness.experiment import Experiment, Knobs, Order, Outcome, Trial, grid
from engine.math import quat
from engine.report.records import Extreme, Point, Table

F8 = NDArray[np.float64]

JOINTS, CHARACTERS = 20, 64
RATES = (4, 8, 16, 32, 64)
#: metres from a joint to the skin that it turns
ARM = 0.5


def motion(times: F8) -> F8:
    """f8[times, joints, 4]: joints that swing about two axes at several rates: smooth, and known exactly."""
    rate = np.linspace(0.5, 2.0, JOINTS)
    swing = 0.8 * np.sin(2.0 * np.pi * rate * times[:, None])
    twist = 0.5 * np.sin(2.0 * np.pi * rate[::-1] * times[:, None] + 1.0)
    first = quat.from_axis_angle(np.array([1.0, 0.0, 0.0]), swing)
    return quat.multiply(first, quat.from_axis_angle(np.array([0.0, 1.0, 0.0]), twist))


def sampler(method: str, rate: int) -> ClipSampler:
    """Two seconds of the motion with `rate` keys a second, to be played as step, linear or cubic."""
    times = np.arange(2 * rate + 1) / rate
    q = motion(times)
    flips = np.cumprod(np.where(np.sum(q[1:] * q[:-1], axis=2) < 0.0, -1.0, 1.0), axis=0)
    q[1:] *= flips[:, :, None]
    step = 1e-4
    slope = (motion(times + step) - motion(times - step)) / (2.0 * step)
    channels = []
    for joint in range(JOINTS):
        values, kind = q[:, joint], "step" if method == "step" else "linear"
        if method == "cubic":
            tangent = slope[:, joint] * np.sign(np.sum(motion(times)[:, joint] * values, axis=1))[:, None]
            values, kind = np.stack([tangent, values, tangent], axis=1), "cubic"
        channels.append(Channel(joint, "rotation", kind, times.astype(np.float32), values.astype(np.float32)))
    rest = np.zeros((10, JOINTS))
    rest[6], rest[7:10] = 1.0, 1.0
    names = tuple(str(i) for i in range(JOINTS))
    rig = Rig(names, np.full(JOINTS, -1), rest, np.arange(JOINTS))
    return ClipSampler(ClipAsset("swing", channels), rig)


def play(made: ClipSampler, method: str, times: F8, out: F8) -> None:
    """The same keys by one method: slerp, bent nlerp, or plain nlerp."""
    for group in made._groups:
        assert group.theta is not None
        key = np.clip(np.searchsorted(group.times, times, side="right") - 1, 0, len(group.times) - 2)
        u = ((times - group.times[key]) / (group.times[key + 1] - group.times[key]))[:, None]
        start, end, theta = group.values[:, key], group.values[:, key + 1], group.theta[key]
        if method == "slerp":
            weight_a, weight_b = poses.slerp_weights(theta, u)
            out[poses.R, :, group.columns] = weight_a * start + weight_b * end
        else:
            bend = theta * theta / 3.0 if method == "bent nlerp" else np.zeros_like(theta)
            out[poses.R, :, group.columns] = poses.bent_nlerp(start, end, bend, u)


def run(ctx: Context, knobs: Knobs) -> Trial:
    made = sampler("linear", knobs["rate"])
    times = ctx.rng("times").uniform(0.0, 2.0, CHARACTERS)
    truth = poses.resting(made.rig.rest, CHARACTERS)
    play(made, "slerp", times, truth)
    moved = np.moveaxis(motion(times), -1, 0)
    out = poses.resting(made.rig.rest, CHARACTERS)

    def work() -> F8:
        play(made, knobs["method"], times, out)
        return out

    def judge(got: F8) -> Outcome:
        error = apart(got[poses.R], truth[poses.R])
        off = float(apart(got[poses.R], moved).max())
        return Outcome(
            {"max_mm": float(error.max()), "median_mm": float(np.median(error))}, extra={"off the motion, mm": off}
        )

    return Trial(work, judge)


def apart(a: F8, b: F8) -> F8:
    """Millimetres at the skin between rotations [4,...]."""
    x, y = (np.moveaxis(q, 0, -1).reshape(-1, 4) for q in (a, b))
    return np.asarray(ARM * 1e3 * quat.angle_between(x, y), np.float64)


def tables(ctx: Context, points: Sequence[Point]) -> Iterator[Table]:
    """How many keys each kind of interpolation needs, and what they weigh."""
    times = ctx.rng("times").uniform(0.0, 2.0, CHARACTERS)
    moved = np.moveaxis(motion(times), -1, 0)
    rows: list[list[str]] = []
    for kind in ("step", "linear", "cubic"):
        for rate in RATES:
            made = sampler(kind, rate)
            out = poses.resting(made.rig.rest, CHARACTERS)
            made.sample(times, out)
            size = JOINTS * (2 * rate + 1) * (4 + 4 * (12 if kind == "cubic" else 4))
            rows.append([kind, f"{rate}", f"{apart(out[poses.R], moved).max():.3g}", f"{size:,}"])
    yield Table("Keys against the motion they were taken from", ["keys", "a second", "max error, mm", "bytes"], rows)


def _step(knobs: Knobs) -> float:
    return 1.0 / float(knobs["rate"])


def extremes(ctx: Context) -> Iterator[Extreme]:
    made = sampler("cubic", 4)
    out = poses.resting(made.rig.rest, 3)
    made.sample([-1e9, 1e12, float("nan")], out)
    length = np.linalg.norm(out[poses.R], axis=0)
    yield Extreme("times of -1e9, 1e12 and NaN", "unit rotations", bool(np.abs(length - 1.0).max() < 1e-9))


EXPERIMENT = Experiment(
    title="Interpolating a clip's keys",
    method="slerp, nlerp with bent time (the sampler's, up to 24° between keys) and nlerp; 64 characters of 20 joints",
    truth="slerp between the keys, as files define it, float64",
    metric="max_mm",
    unit="mm at 0.5 m from the joint",
    knobs=grid(method=("slerp", "bent nlerp", "nlerp"), rate=RATES),
    default={"method": "bent nlerp", "rate": 32},
    curve="method",
    problem="rate",
    run=run,
    orders=[
        Order(
            3.0,
            "time runs unevenly along the chord",
            "1 / rate",
            step=_step,
            curve="nlerp",
            tolerance=0.4,
            between=(0.0, 0.13),
        ),
        Order(
            5.0,
            "the next term of the bend",
            "1 / rate",
            step=_step,
            curve="bent nlerp",
            tolerance=0.6,
            above=1e-9,
            between=(0.0, 0.13),
        ),
    ],
    extremes=extremes,
    tables=tables,
    step_label="seconds between keys",
    note="Beside the keys' own error (the table) no method's matters at a usual rate, so the time decides.",
)
