"""Skinning a twisted limb: linear blending loses its volume, dual quaternions keep it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from engine.animation.skinning import transform_points, vertex_matrices, vertex_matrices_dual_quaternion
from engine.experiments.harness.context import Context
from engine.experiments.harness.experiment import Experiment, Knobs, Outcome, Trial, grid
from engine.math import quat
from engine.math.transform import compose
from engine.report.records import Extreme

F8 = NDArray[np.float64]

#: a forearm: a tube 0.25 m long and 4 cm thick along +Y between two joints, weights running from one to the other
RADIUS, LENGTH, RINGS, AROUND = 0.04, 0.25, 33, 48
TWISTS = (15, 45, 90, 135, 180)


def tube() -> tuple[F8, F8, F8]:
    """Points f8[n,3], joints i8[n,2] and weights f8[n,2]."""
    share = np.repeat(np.linspace(0.0, 1.0, RINGS), AROUND)
    angle = np.tile(np.arange(AROUND) * 2.0 * np.pi / AROUND, RINGS)
    points = np.stack([RADIUS * np.cos(angle), LENGTH * share, RADIUS * np.sin(angle)], axis=1)
    return points, np.tile([0, 1], (len(points), 1)), np.stack([1.0 - share, share], axis=1)


def joints(degrees: float) -> F8:
    """f8[2,4,4]: world from mesh of a joint that stands and one that is twisted about +Y."""
    turn = quat.from_axis_angle(np.array([[0.0, 1.0, 0.0]] * 2), np.radians([0.0, degrees]))
    return compose(np.zeros((2, 3)), turn, np.ones((2, 3)))


def truth_of(degrees: float) -> F8:
    """Each ring turned by its share of the twist, as flesh on a bone is: no thinner anywhere."""
    points, _, weights = tube()
    turn = quat.from_axis_angle(np.array([[0.0, 1.0, 0.0]] * len(points)), np.radians(degrees) * weights[:, 1])
    return np.asarray(quat.rotate(turn, points), np.float64)


def run(ctx: Context, knobs: Knobs) -> Trial:
    points, which, weights = tube()
    matrices, truth = joints(knobs["twist"]), truth_of(knobs["twist"])
    blend = vertex_matrices if knobs["method"] == "linear" else vertex_matrices_dual_quaternion

    def judge(got: F8) -> Outcome:
        error = np.linalg.norm(got - truth, axis=1) * 1e3
        radius = np.hypot(got[:, 0], got[:, 2]).reshape(RINGS, AROUND).mean(axis=1)
        rows = zip(
            np.linspace(0.0, 1.0, RINGS).tolist(), error.reshape(RINGS, AROUND).max(axis=1).tolist(), strict=True
        )
        return Outcome(
            {"max_mm": float(error.max()), "rms_mm": float(np.sqrt(np.mean(error**2)))}, profile=list(rows),
            extra={"thinnest": f"{radius.min() / RADIUS:.0%}"},
        )  # fmt: skip

    return Trial(lambda: transform_points(blend(which, weights, matrices), points), judge)


def extremes(ctx: Context) -> Iterator[Extreme]:
    points, which, weights = tube()
    linear = transform_points(vertex_matrices(which, weights, joints(180.0)), points)
    middle = np.hypot(linear[:, 0], linear[:, 2]).min()
    yield Extreme("twisted by 180°, linear: the middle is a point", f"{middle * 1e3:.2g} mm", bool(middle < 1e-9))
    dual = transform_points(vertex_matrices_dual_quaternion(which, weights, joints(180.0)), points)
    off = np.abs(np.hypot(dual[:, 0], dual[:, 2]) - RADIUS).max()
    yield Extreme("the same by dual quaternions: as thick as ever", f"off by {off * 1e3:.2g} mm", bool(off < 1e-9))


EXPERIMENT = Experiment(
    title="Skinning a twist: linear or dual quaternions",
    method="vertex_matrices, vertex_matrices_dual_quaternion of engine.animation.skinning (the twins of the shaders)",
    truth="every ring of a tube turned by its share of the twist, float64",
    metric="max_mm",
    unit="mm",
    knobs=grid(method=("linear", "dual quaternions"), twist=TWISTS),
    default={"method": "linear", "twist": 45},
    curve="method",
    problem="twist",
    run=run,
    extremes=extremes,
    step_label="twist (degrees)",
    profile_label="share of the way from joint to joint",
    note="A tube 4 cm thick. Linear is the default because files are weighted for it, and it bends without bulging;"
    " each mesh, or the inspector, may choose dual quaternions. No order is expected: there is no step.",
)
