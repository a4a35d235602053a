"""Interpolating rotations: slerp and what is used in its place."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.experiments.harness.context import Context
from engine.experiments.harness.experiment import Experiment, Knobs, Order, Outcome, Trial
from engine.math import quat
from engine.report.records import Extreme

F8 = NDArray[np.float64]
Array = NDArray[Any]

ANGLES = np.radians([1e-7, 1e-5, 1e-3, 0.1, 1.0, 5.0, 15.0, 30.0, 60.0, 90.0, 120.0, 150.0, 175.0])


def _near(a: Array, b: Array) -> tuple[Array, Array]:
    d = np.einsum("ij,ij->i", a, b)[:, None]
    return np.where(d < 0, -b, b), np.abs(d)


def _unit(q: Array) -> Array:
    return np.asarray(q / np.sqrt(np.einsum("ij,ij->i", q, q))[:, None])


def nlerp(a: Array, b: Array, t: Array) -> Array:
    """Normalised lerp."""
    b, _ = _near(a, b)
    return _unit(a + (b - a) * t[:, None])


def corrected_nlerp(a: Array, b: Array, t: Array) -> Array:
    """nlerp with its time bent by a polynomial in t and the cosine (Kapoulkine 2018, "Approximating slerp", onlerp)."""
    b, d = _near(a, b)
    k_a = 1.0904 + d * (-3.2452 + d * (3.55645 - d * 1.43519))
    k_b = 0.848013 + d * (-1.06021 + d * 0.215638)
    s = t[:, None]
    k = k_a * (s - 0.5) ** 2 + k_b
    s = s + s * (s - 0.5) * (s - 1.0) * k
    return _unit(a * (1.0 - s) + b * s)


def slerp_acos(a: Array, b: Array, t: Array) -> Array:
    """Shoemake 1985 as printed: the angle from acos of the dot product."""
    b, d = _near(a, b)
    theta = np.arccos(np.minimum(d, 1.0))
    s = t[:, None]
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray((np.sin((1.0 - s) * theta) * a + np.sin(s * theta) * b) / np.sin(theta))


METHODS: dict[str, Callable[[Array, Array, Array], Array]] = {
    "slerp": quat.slerp,
    "slerp acos": slerp_acos,
    "nlerp": nlerp,
    "corrected nlerp": corrected_nlerp,
}


def inputs(ctx: Context) -> tuple[F8, F8, F8, F8]:
    """Pairs (a, b) at each angle, times t, and the truth: a turned by t times the angle about its axis, float64."""
    count = 1 << (9 if ctx.quick else 12)
    rng = ctx.rng("rotations")
    angle = np.repeat(ANGLES, count)
    axis = rng.normal(size=(len(angle), 3))
    a = quat.normalize(rng.normal(size=(len(angle), 4)))
    t = rng.uniform(size=len(angle))
    b = quat.multiply(quat.from_axis_angle(axis, angle), a)
    truth = quat.multiply(quat.from_axis_angle(axis, angle * t), a)
    return a, b, t, truth


def run(ctx: Context, knobs: Knobs) -> Trial:
    a, b, t, truth = ctx.once("inputs", lambda: inputs(ctx))
    kind = np.float32 if knobs["digits"] == 32 else np.float64
    method = METHODS[knobs["method"]]
    x, y, s = a.astype(kind), b.astype(kind), t.astype(kind)

    def judge(got: Array) -> Outcome:
        finite = np.isfinite(got).all(axis=1)
        error = np.where(finite, np.degrees(quat.angle_between(quat.normalize(got), truth)), np.inf)
        rows = error.reshape(len(ANGLES), -1).max(axis=1)
        return Outcome(
            {"max_angle": float(rows.max()), "median_angle": float(np.median(error))},
            profile=list(zip(np.degrees(ANGLES), rows, strict=True)),
            extra={"not finite": int((~finite).sum())},
        )

    return Trial(lambda: method(x, y, s), judge)


def extremes(ctx: Context) -> Iterator[Extreme]:
    one = np.array([[0.0, 0.0, 0.0, 1.0]])
    half = np.array([0.5])
    same = quat.slerp(one, one, half)
    yield Extreme("equal rotations", f"{same[0]}", bool(np.allclose(same, one)))
    other = quat.slerp(one, -one, half)
    yield Extreme("q and -q, the same rotation", f"{other[0]}", bool(quat.angle_between(other, one)[0] < 1e-12))
    turn = quat.slerp(one, quat.from_axis_angle([[0.0, 1.0, 0.0]], [math.pi]), half)
    off = abs(float(np.linalg.norm(turn)) - 1.0)
    yield Extreme("180° apart: unit result", f"length off by {off:.1g}", off < 1e-12)


EXPERIMENT = Experiment(
    title="Interpolating rotations",
    method="slerp of engine.math.quat (angle by atan2), slerp by acos, nlerp, nlerp with bent time; NumPy arrays",
    truth="the first rotation turned by t times the angle about the axis, float64",
    metric="max_angle",
    unit="degrees",
    knobs=[{"method": m, "digits": d} for m in METHODS for d in (32, 64)],
    default={"method": "slerp", "digits": 64},
    curve="method",
    run=run,
    orders=[
        Order(
            3.0,
            "time runs unevenly along the chord",
            "angle",
            point={"method": "nlerp", "digits": 64},
            between=(0.5, 100.0),
        ),
    ],
    extremes=extremes,
    profile_label="angle between the rotations (degrees)",
    note="The worst of all angles up to 175°. The acos form is no choice: in float32 it divides zero by zero below a"
    " thousandth of a degree, and its angle keeps half of the digits. `digits`: bits of the inputs (engine.math works"
    " in float64 whatever it is given).",
)
