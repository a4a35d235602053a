"""Carrying normals through transforms: cofactors, inverse transpose, and the matrix itself."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from engine.experiments.harness.context import Context
from engine.experiments.harness.experiment import Experiment, Knobs, Order, Outcome, Trial
from engine.math import quat
from engine.math.transform import compose
from engine.report.metrics import max_angle
from engine.report.records import Extreme

F8 = NDArray[np.float64]

#: how much longer one axis is than the others, minus 1
STRETCHES = (1e-3, 3e-3, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 100.0, 1e4)
FORMS = {
    "cofactor": "cofactor(mat3(c0, c1, c2)) * n",
    "inverse transpose": "transpose(inverse(mat3(c0, c1, c2))) * n",
    "matrix itself": "mat3(c0, c1, c2) * n",
}
FUNCTIONS = """
mat3 cofactor(mat3 m) { return mat3(cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])); }
"""
INPUTS = {"c0": "vec3", "c1": "vec3", "c2": "vec3", "n": "vec3"}


def inputs(ctx: Context) -> tuple[dict[str, NDArray[np.float32]], F8]:
    rng = ctx.rng("normals")
    count = 1 << (14 if ctx.quick else 15)
    total = count * len(STRETCHES)
    scale = np.ones((total, 3))
    scale[:, 0] += np.repeat(STRETCHES, count)
    m = compose(np.zeros((total, 3)), quat.normalize(rng.normal(size=(total, 4))), scale)[:, :3, :3].astype(np.float32)
    n = rng.normal(size=(total, 3))
    n = (n / np.linalg.norm(n, axis=1, keepdims=True)).astype(np.float32)
    exact = np.einsum("nji,nj->ni", np.linalg.inv(m.astype(np.float64)), n.astype(np.float64))
    return {"c0": m[:, :, 0], "c1": m[:, :, 1], "c2": m[:, :, 2], "n": n}, exact


def run(ctx: Context, knobs: Knobs) -> Trial:
    arrays, exact = ctx.once("inputs", lambda: inputs(ctx))
    kernel = ctx.shaders().kernel(f"normalize({FORMS[knobs['form']]})", INPUTS, "vec3", functions=FUNCTIONS)
    dispatch = kernel.bind(**arrays)

    def judge(_: object) -> Outcome:
        got = dispatch.read().reshape(len(STRETCHES), -1, 3)
        want = exact.reshape(got.shape)
        rows = [math.degrees(max_angle(g, w)) for g, w in zip(got, want, strict=True)]
        return Outcome({"max_angle": max(rows)}, profile=list(zip(STRETCHES, rows, strict=True)))

    return Trial(dispatch.run, judge, gpu=True, close=dispatch.release)


def extremes(ctx: Context) -> Iterator[Extreme]:
    n = np.array([[0.0, 0.0, 1.0]], np.float32)
    for what, scale in (("scale (1, 1, 0), the flat side", (1.0, 1.0, 0.0)), ("scale 1e-4", (1e-4, 1e-4, 1e-4)),
                        ("scale 1e6", (1e6, 1e6, 1e6))):  # fmt: skip
        axes = np.diag(scale).astype(np.float32)
        kernel = ctx.shaders().kernel(FORMS["cofactor"], INPUTS, "vec3", functions=FUNCTIONS)
        got = kernel(c0=axes[None, :, 0], c1=axes[None, :, 1], c2=axes[None, :, 2], n=n)
        ok = bool(np.isfinite(got).all() and max_angle(got, n) < 1e-6)
        yield Extreme(what, f"({got[0, 0]:.3g}, {got[0, 1]:.3g}, {got[0, 2]:.3g})", ok)


EXPERIMENT = Experiment(
    title="Carrying normals through transforms",
    method="cofactor matrix (surface.vert), transpose of inverse(), and the matrix itself, float32 in GLSL",
    truth="inverse transpose of the same rounded matrix in float64",
    metric="max_angle",
    unit="degrees",
    knobs=[{"form": f} for f in FORMS],
    default={"form": "cofactor"},
    curve="form",
    run=run,
    orders=[
        Order(
            1.0,
            "for a small stretch the wrong normal is off by as much",
            "stretch",
            point={"form": "matrix itself"},
            between=(1e-3, 0.3),
        ),
    ],
    needs=frozenset({"gpu"}),
    timed="gpu",
    extremes=extremes,
    profile_label="stretch of one axis (1 = twice as long)",
    note="The cofactor matrix is the inverse transpose times the determinant: as right, without a division, and finite"
    " where a scale is zero.",
)
