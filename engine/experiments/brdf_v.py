"""Masking and shadowing: the height-correlated Smith term, and the cheaper forms used for it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.experiments.harness.context import Context
from engine.experiments.harness.experiment import Experiment, Knobs, Order, Outcome, Trial
from engine.math import ggx
from engine.report.records import Extreme, Floor

F8 = NDArray[np.float64]

FORMS = {
    "correlated": "V_SmithGGXCorrelated(alpha, nv, nl)",  # shaders/lib/brdf.glsl
    "separable": "separable(alpha, nv, nl)",
    "hammon": "hammon(alpha, nv, nl)",
    "schlick": "schlick(alpha, nv, nl)",
    "implicit": "0.25 + 0.0 * alpha",
}
FUNCTIONS = """
// Walter et al. 2007, eq. 34, for each direction alone
float g1(float a2, float c) { return 1.0 / (c + sqrt(a2 + (1.0 - a2) * c * c)); }
float separable(float alpha, float nv, float nl) { float a2 = alpha * alpha; return g1(a2, nv) * g1(a2, nl); }
// Hammon 2017, "PBR Diffuse Lighting for GGX+Smith Microsurfaces", p. 82
float hammon(float alpha, float nv, float nl) { return 0.5 / max(mix(2.0 * nl * nv, nl + nv, alpha), 1e-7); }
// Schlick 1994, eq. 19, with k = alpha / 2 (Karis 2013)
float schlick(float alpha, float nv, float nl) {
    float k = 0.5 * alpha;
    return 0.25 / ((nv * (1.0 - k) + k) * (nl * (1.0 - k) + k));
}
"""
ALPHAS = (2.025e-3, 0.01, 0.05, 0.1, 0.2, 0.4, 0.7, 1.0)
INPUTS = {"alpha": "float", "nv": "float", "nl": "float"}


def inputs(ctx: Context) -> tuple[dict[str, NDArray[Any]], F8]:
    """Cosines down to grazing, and G2 = 4 n.v n.l V in float64."""
    rng = ctx.rng("cosines")
    count = 1 << (15 if ctx.quick else 16)
    alpha = np.repeat(np.array(ALPHAS, np.float32), count)
    nv, nl = (np.maximum(rng.uniform(size=len(alpha)) ** 2, 1e-4).astype(np.float32) for _ in range(2))
    truth = 4.0 * nv.astype(np.float64) * nl * ggx.V_SmithGGXCorrelated(nv, nl, alpha)
    return {"alpha": alpha, "nv": nv, "nl": nl}, truth


def run(ctx: Context, knobs: Knobs) -> Trial:
    arrays, truth = ctx.once("inputs", lambda: inputs(ctx))
    kernel = ctx.shaders().kernel(FORMS[knobs["form"]], INPUTS, "float", include=["lib/brdf.glsl"], functions=FUNCTIONS)
    dispatch = kernel.bind(**arrays)

    def judge(_: object) -> Outcome:
        g2 = 4.0 * arrays["nv"].astype(np.float64) * arrays["nl"] * dispatch.read()
        error = np.abs(g2 - truth).reshape(len(ALPHAS), -1)
        rows = np.where(np.isfinite(error), error, np.inf).max(axis=1)
        return Outcome(
            {"max_error": float(rows.max()), "rmse": float(np.sqrt(np.mean(error**2)))},
            profile=list(zip(ALPHAS, rows, strict=True)),
        )

    return Trial(dispatch.run, judge, gpu=True, close=dispatch.release)


def extremes(ctx: Context) -> Iterator[Extreme]:
    kernel = ctx.shaders().kernel(FORMS["correlated"], INPUTS, "float", include=["lib/brdf.glsl"])
    zero = np.zeros(3, np.float32)
    got = kernel(alpha=np.array([0.0, 1e-8, 1.0], np.float32), nv=zero, nl=zero)
    yield Extreme("n·v = n·l = 0", ", ".join(f"{v:.3g}" for v in got), bool(np.isfinite(got).all()))
    rng = ctx.rng("reciprocity")
    a, b, alpha = (rng.uniform(1e-4, 1.0, 4096).astype(np.float32) for _ in range(3))
    forth, back = kernel(alpha=alpha, nv=a, nl=b), kernel(alpha=alpha, nv=b, nl=a)
    off = float(np.max(np.abs(forth - back) / forth))
    yield Extreme("reciprocity: view and light exchanged", f"{off:.1g} relative", off < 1e-6)


EXPERIMENT = Experiment(
    title="Masking-shadowing V in float32",
    method="the height-correlated Smith form of shaders/lib/brdf.glsl, and four cheaper ones, in GLSL",
    truth="Heitz 2014, eq. 99, in float64; compared as G2 = 4 n·v n·l V, which lies in [0, 1]",
    metric="max_error",
    unit="of G2",
    knobs=[{"form": form} for form in FORMS],
    default={"form": "correlated"},
    curve="form",
    run=run,
    orders=[
        Order(0.0, "rounding alone, whatever alpha", "alpha"),
    ],
    format_floor=Floor(2.0**-24, "float32 rounding"),
    needs=frozenset({"gpu"}),
    timed="gpu",
    extremes=extremes,
    profile_label="alpha",
)
