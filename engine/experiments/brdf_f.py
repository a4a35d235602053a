"""Fresnel reflection of dielectrics: Schlick's polynomial, ways of writing it, and the exact equations."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.experiments.harness.context import Context
from engine.experiments.harness.experiment import Experiment, Knobs, Order, Outcome, Trial
from engine.report.records import Extreme, Floor

F8 = NDArray[np.float64]

FORMS = {
    "schlick": "F_Schlick(vec3(f0), vec3(1.0), c).x",  # shaders/lib/brdf.glsl
    "schlick pow": "f0 + (1.0 - f0) * pow(1.0 - c, 5.0)",
    "schlick exp2": "f0 + (1.0 - f0) * exp2((-5.55473 * c - 6.98316) * c)",  # Lagarde 2012, spherical Gaussian
    "exact": "exact(f0, c)",
}
FUNCTIONS = """
// Unpolarised Fresnel reflectance of a dielectric, index of refraction from f0 (Cook and Torrance 1982, appendix)
float exact(float f0, float c) {
    float r = sqrt(f0); float n = (1.0 + r) / (1.0 - r); float g = sqrt(n * n - 1.0 + c * c);
    float a = (g - c) / (g + c); float b = ((g + c) * c - 1.0) / ((g - c) * c + 1.0);
    return 0.5 * a * a * (1.0 + b * b);
}
"""
F0S = (0.02, 0.04, 0.08, 0.16, 0.3)  # water to diamond and beyond
COSINES = np.concatenate([np.geomspace(1e-3, 0.05, 8), np.linspace(0.1, 0.95, 18)])
INPUTS = {"f0": "float", "c": "float"}


def exact(f0: F8, c: F8) -> F8:
    """Unpolarised Fresnel reflectance in float64."""
    root = np.sqrt(f0)
    n = (1.0 + root) / (1.0 - root)
    g = np.sqrt(n * n - 1.0 + c * c)
    a, b = (g - c) / (g + c), ((g + c) * c - 1.0) / ((g - c) * c + 1.0)
    result: F8 = 0.5 * a * a * (1.0 + b * b)
    return result


def inputs(ctx: Context) -> tuple[dict[str, NDArray[Any]], F8]:
    repeat = 1 << (10 if ctx.quick else 12)
    f0, c = (v.ravel() for v in np.meshgrid(np.array(F0S), COSINES, indexing="ij"))
    arrays = {"f0": np.tile(f0, repeat).astype(np.float32), "c": np.tile(c, repeat).astype(np.float32)}
    truth = exact(arrays["f0"][: len(f0)].astype(np.float64), arrays["c"][: len(f0)].astype(np.float64))
    return arrays, truth


def run(ctx: Context, knobs: Knobs) -> Trial:
    arrays, truth = ctx.once("inputs", lambda: inputs(ctx))
    kernel = ctx.shaders().kernel(FORMS[knobs["form"]], INPUTS, "float", include=["lib/brdf.glsl"], functions=FUNCTIONS)
    dispatch = kernel.bind(**arrays)

    def judge(_: object) -> Outcome:
        error = np.abs(dispatch.read()[: len(truth)] - truth).reshape(len(F0S), -1)
        return Outcome(
            {"max_error": float(error.max()), "rmse": float(np.sqrt(np.mean(error**2)))},
            profile=list(zip(COSINES, error.max(axis=0), strict=True)),
        )

    return Trial(dispatch.run, judge, gpu=True, close=dispatch.release)


def extremes(ctx: Context) -> Iterator[Extreme]:
    c = np.array([-1.0, -1e-7, 0.0, 1.0, 1.0 + 1e-6], np.float32)
    kernel = ctx.shaders().kernel(FORMS["schlick"], INPUTS, "float", include=["lib/brdf.glsl"])
    got = kernel(f0=np.full(5, 0.04, np.float32), c=c)
    ok = bool(((got >= 0.04 - 1e-7) & (got <= 1.0)).all())
    yield Extreme("v·h of -1, -1e-7, 0, 1, 1 + 1e-6", ", ".join(f"{v:.4g}" for v in got), ok)


EXPERIMENT = Experiment(
    title="Fresnel reflection F",
    method="Schlick 1994 by multiplications (shaders/lib/brdf.glsl), by pow, by exp2, and the exact dielectric in GLSL",
    truth="unpolarised Fresnel equations in float64, f0 from 0.02 to 0.3",
    metric="rmse",
    unit="reflectance",
    knobs=[{"form": form} for form in FORMS],
    default={"form": "schlick"},
    curve="form",
    run=run,
    orders=[
        Order(1.0, "at grazing both go to 1, with different slopes", "v·h", between=(1e-3, 0.05), tolerance=0.3),
    ],
    format_floor=Floor(2.0**-24, "float32 rounding"),
    needs=frozenset({"gpu"}),
    timed="gpu",
    extremes=extremes,
    profile_label="v·h",
    note="Schlick's own error against the exact equations is what a renderer pays; the forms of writing it differ by"
    " rounding and time.",
)
