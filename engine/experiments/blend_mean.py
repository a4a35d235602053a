"""Blending k clips: the normalised mean of quaternions against the spherical one."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from engine.animation import poses
from engine.animation.blend import BlendJob
from engine.experiments.harness.context import Context
from engine.experiments.harness.experiment import Experiment, Knobs, Outcome, Trial, grid
from engine.math import quat
from engine.report.records import Extreme

F8 = NDArray[np.float64]

CHARACTERS, JOINTS = 64, 20
#: degrees that the clips' rotations of one joint lie apart, about
SPREADS = (5.0, 20.0, 60.0, 120.0)


def inputs(ctx: Context, count: int) -> tuple[list[F8], F8]:
    """k poses whose rotations lie about a common one, with weights f8[k,m]."""
    rng = ctx.rng(f"blend {count}")
    base = quat.normalize(rng.normal(size=(CHARACTERS * JOINTS, 4)))
    spread = np.resize(np.repeat(SPREADS, JOINTS // len(SPREADS)), CHARACTERS * JOINTS)
    made = []
    for _ in range(count):
        angle = np.radians(spread) * rng.uniform(0.3, 0.5, len(spread))
        turn = quat.from_axis_angle(rng.normal(size=(len(spread), 3)), angle)
        pose = np.zeros((10, CHARACTERS, JOINTS))
        pose[7:10] = 1.0
        pose[poses.R] = quat.multiply(turn, base).T.reshape(4, CHARACTERS, JOINTS)
        made.append(pose)
    return made, rng.uniform(0.1, 1.0, (count, CHARACTERS))


def spherical_mean(made: list[F8], weights: F8) -> F8:
    """f8[4,m,n]: where the weighted logarithms sum to nothing (Buss and Fillmore 2001), 60 steps: converged."""
    shares = weights / weights.sum(axis=0)
    mean = made[0][poses.R].copy()
    for _ in range(60):
        step = np.zeros_like(mean)
        for pose, share in zip(made, shares, strict=True):
            q = np.where(poses.dot(pose[poses.R], mean) < 0.0, -pose[poses.R], pose[poses.R])
            cosine = poses.dot(q, mean)
            away = q - cosine * mean
            sine = np.sqrt(poses.dot(away, away))
            step += (
                share[:, None] * away * np.where(sine > 1e-12, np.arctan2(sine, cosine) / np.maximum(sine, 1e-12), 1.0)
            )
        length = np.sqrt(poses.dot(step, step))
        mean = mean * np.cos(length) + step * np.where(length > 1e-15, np.sin(length) / np.maximum(length, 1e-15), 1.0)
        mean /= np.sqrt(poses.dot(mean, mean))
    return mean


def run(ctx: Context, knobs: Knobs) -> Trial:
    count = knobs["clips"]
    made, weights = ctx.once(f"inputs {count}", lambda: inputs(ctx, count))
    truth = ctx.once(f"truth {count}", lambda: spherical_mean(made, weights))
    rest = np.zeros((10, JOINTS))
    rest[6], rest[7:10] = 1.0, 1.0
    out = np.zeros((10, CHARACTERS, JOINTS))
    job = BlendJob(made, weights, rest, out, knobs["method"])
    job.validate()

    def work() -> F8:
        job.run()
        return out

    def judge(got: F8) -> Outcome:
        a, b = (np.moveaxis(q, 0, -1).reshape(-1, 4) for q in (got[poses.R], truth))
        error = np.degrees(quat.angle_between(a, b)).reshape(CHARACTERS, JOINTS)
        width = JOINTS // len(SPREADS)
        rows = [float(error[:, i * width : (i + 1) * width].max()) for i in range(len(SPREADS))]
        return Outcome(
            {"max_angle": float(error.max()), "median_angle": float(np.median(error))},
            profile=list(zip(SPREADS, rows, strict=True)),
        )

    return Trial(work, judge)


def extremes(ctx: Context) -> Iterator[Extreme]:
    rest = np.zeros((10, 1))
    rest[6], rest[7:10] = 1.0, 1.0
    pose = poses.resting(rest, 1)
    turned = pose.copy()
    turned[poses.R] *= -1.0
    out = np.zeros_like(pose)
    BlendJob([pose, turned, pose], np.ones((3, 1)), rest, out).run()
    yield Extreme("q, -q, q", f"{out[poses.R, 0, 0]}", bool(abs(abs(out[6, 0, 0]) - 1.0) < 1e-12))
    BlendJob([pose, turned], np.array([[0.0], [-1.0]]), rest, out).run()
    yield Extreme("weights 0 and -1: the rest pose", f"{out[6, 0, 0]:g}", bool(out[6, 0, 0] == 1.0))


EXPERIMENT = Experiment(
    title="Blending several clips",
    method="BlendJob: weighted mean of aligned quaternions, normalised (nlerp), or on to the spherical mean (slerp)",
    truth="the spherical weighted mean, iterated until it stands, float64",
    metric="max_angle",
    unit="degrees",
    knobs=grid(method=("nlerp", "slerp"), clips=(2, 3, 4, 8)),
    default={"method": "nlerp", "clips": 3},
    curve="method",
    problem="clips",
    run=run,
    extremes=extremes,
    profile_label="degrees between the clips' rotations, at most",
    note="64 characters of 20 joints. The default trades what nobody sees between clips that"
    " are alike for time. No order is expected: the methods have no step.",
)
