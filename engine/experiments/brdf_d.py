"""The GGX normal distribution in float32: which way of writing it keeps its digits as the lobe gets narrow."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.experiments.harness.context import Context
from engine.experiments.harness.experiment import Experiment, Knobs, Order, Outcome, Trial
from engine.report.metrics import count_nonfinite, relative_error
from engine.report.records import Extreme

F8 = NDArray[np.float64]

#: GLSL of each way; all take alpha, the half vector's cosine c, and the unit vectors n, h
FORMS = {
    "cross": "D_GGX(alpha, c, n, h)",  # shaders/lib/brdf.glsl
    "textbook": "textbook(alpha, c)",
    "one minus": "one_minus(alpha, c)",
    "double": "in_double(alpha, n, h)",
}
FUNCTIONS = """
// Walter et al. 2007, eq. 33, as usually typed: (n.h)^2 (a^2 - 1) + 1
float textbook(float alpha, float c) {
    float a2 = alpha * alpha; float d = c * c * (a2 - 1.0) + 1.0;
    return a2 / (PI * d * d);
}
// 1 - c^2 as (1 - c)(1 + c)
float one_minus(float alpha, float c) {
    float a = c * alpha; float k = alpha / ((1.0 - c) * (1.0 + c) + a * a);
    return k * k / PI;
}
float in_double(float alpha, vec3 n, vec3 h) {
    dvec3 m = dvec3(n); dvec3 w = dvec3(h); dvec3 x = cross(m, w); double nn = dot(m, m) * dot(w, w);
    double s2 = dot(x, x) / nn; double a = double(alpha); double k = a / (s2 + (1.0LF - s2) * a * a);
    return float(k * k / 3.14159265358979323846LF);
}
"""
ALPHAS = (1e-4, 3e-4, 1e-3, 2.025e-3, 0.01, 0.03, 0.1, 0.3, 1.0)
INPUTS = {"alpha": "float", "c": "float", "n": "vec3", "h": "vec3"}


def inputs(ctx: Context, count: int) -> tuple[dict[str, NDArray[Any]], F8]:
    """float32 inputs in the lobe of each alpha, and the truth: float64 of the same rounded vectors."""
    rng = ctx.rng("lobe")
    alpha = np.repeat(np.array(ALPHAS, np.float32), count)
    n = rng.normal(size=(len(alpha), 3))
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    t = np.cross(n, rng.normal(size=n.shape))
    t /= np.linalg.norm(t, axis=1, keepdims=True)
    u = rng.uniform(0.0, 0.99, len(alpha))  # of the lobe's energy: Walter et al. 2007, eq. 35
    tangent = alpha * np.sqrt(u / (1.0 - u))
    h = n + t * tangent[:, None]
    h /= np.linalg.norm(h, axis=1, keepdims=True)
    n32, h32 = n.astype(np.float32), h.astype(np.float32)
    c = np.einsum("ij,ij->i", n32, h32, dtype=np.float32)
    m, w = n32.astype(np.float64), h32.astype(np.float64)
    m /= np.linalg.norm(m, axis=1, keepdims=True)
    w /= np.linalg.norm(w, axis=1, keepdims=True)
    s2 = np.sum(np.cross(m, w) ** 2, axis=1)
    k = alpha.astype(np.float64) / (s2 + (1.0 - s2) * alpha.astype(np.float64) ** 2)
    return {"alpha": alpha, "c": np.minimum(c, np.float32(1.0)), "n": n32, "h": h32}, k * k / math.pi


def run(ctx: Context, knobs: Knobs) -> Trial:
    count = 1 << (14 if ctx.quick else 16)
    arrays, truth = ctx.once("inputs", lambda: inputs(ctx, count))
    kernel = ctx.shaders().kernel(FORMS[knobs["form"]], INPUTS, "float", include=["lib/brdf.glsl"], functions=FUNCTIONS)
    dispatch = kernel.bind(**arrays)

    def judge(_: object) -> Outcome:
        got = dispatch.read().reshape(len(ALPHAS), -1)
        want = truth.reshape(got.shape)
        rows = [relative_error(g, w, 0.99) for g, w in zip(got, want, strict=True)]
        # the shader never sees an alpha below the square of MIN_ROUGHNESS: that is what the score is taken over
        seen = [r for a, r in zip(ALPHAS, rows, strict=True) if a >= 2e-3]
        return Outcome(
            {"p99_relative": max(seen), "p99_any_alpha": max(rows), "max_relative": relative_error(got[3:], want[3:])},
            profile=list(zip(ALPHAS, rows, strict=True)),
            extra={"not finite": count_nonfinite(got)},
        )

    return Trial(dispatch.run, judge, gpu=True, close=dispatch.release)


def extremes(ctx: Context) -> Iterator[Extreme]:
    n = np.array([[0.0, 0.0, 1.0]] * 3, np.float32)
    h = np.array([[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [1.0, 0.0, 0.0]], np.float32)
    kernel = ctx.shaders().kernel(FORMS["cross"], INPUTS, "float", include=["lib/brdf.glsl"])
    for alpha in (0.0, 1e-8, 2e-3, 1.0):
        got = kernel(alpha=np.full(3, alpha, np.float32), c=h[:, 2], n=n, h=h)
        yield Extreme(
            f"alpha {alpha:g} at n·h = 1, 0.8 and 0",
            ", ".join(f"{v:.3g}" for v in got),
            bool(np.isfinite(got).all() and (got >= 0).all()),
        )


EXPERIMENT = Experiment(
    title="GGX distribution D in float32",
    method="D(h) of GGX written four ways in GLSL; shaders/lib/brdf.glsl has “cross” (Lagrange's identity)",
    truth="closed form in float64 of the same rounded vectors (Walter et al. 2007, eq. 33)",
    metric="p99_relative",
    unit="relative",
    # doubles show what float32 costs in accuracy; they do not compete: nearly free on a processor, but on most GPUs a
    # 32nd or 64th of the speed
    knobs=[{"form": form, "arithmetic": "float64" if form == "double" else "float32"} for form in FORMS],
    default={"form": "cross", "arithmetic": "float32"},
    curve="form",
    problem="arithmetic",
    run=run,
    orders=[
        Order(-1.0, "one cancellation: rounding / alpha", "alpha", between=(1e-4, 0.05), tolerance=0.3),
        Order(
            -2.0,
            "the square cancels: rounding / alpha²",
            "alpha",
            point={"form": "textbook"},
            between=(2e-3, 0.2),
            tolerance=0.4,
        ),
    ],
    needs=frozenset({"gpu"}),
    timed="gpu",
    extremes=extremes,
    profile_label="alpha (width of the lobe)",
    note="99th percentile over half vectors that carry 99 % of the lobe's energy, the worst over alpha ≥ 0.002, which"
    " is where the shaders clamp it.",
)
