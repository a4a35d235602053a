"""Diffuse light from an environment: spherical harmonics by bands, and convolution of a coarser cube."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from engine.experiments.environment_prefilter import solid_angles
from engine.experiments.harness.context import Context, Floats
from engine.experiments.harness.experiment import Experiment, Knobs, Order, Outcome, Trial
from engine.math import sh
from engine.math.sphere import fibonacci

F8 = NDArray[np.float64]

SOURCE = 32
DIRECTIONS, SHADED = 512, 1 << 13


def cosine_factor(band: int) -> float:
    """A_l, by which band l of radiance becomes irradiance (Ramamoorthi and Hanrahan 2001, eq. 7 to 9)."""
    if band == 1:
        return 2.0 * math.pi / 3.0
    if band % 2:
        return 0.0
    half = band // 2
    sign = -1.0 if half % 2 == 0 else 1.0
    ratio = math.factorial(band) / (2.0**band * math.factorial(half) ** 2)
    return 2.0 * math.pi * sign / ((band + 2) * (band - 1)) * ratio


def harmonics(d: F8, bands: int) -> F8:
    """Real orthonormal spherical harmonics f8[n,bands^2] at unit `d` [n,3], by recurrence; +z is the pole."""
    x, y, z = d.T
    out = np.empty((len(d), bands * bands))
    # cos and sin of m phi times sin^m theta, so that nothing is divided by sin theta
    c, s = np.ones_like(x), np.zeros_like(x)
    diagonal = np.ones_like(x)
    for m in range(bands):
        if m > 0:
            c, s = x * c - y * s, x * s + y * c
            diagonal = diagonal * (1.0 - 2.0 * m)
        before, p = np.zeros_like(x), diagonal
        for band in range(m, bands):
            if band > m:
                before, p = p, ((2 * band - 1) * z * p - (band + m - 1) * before) / (band - m)
            k = math.sqrt((2 * band + 1) / (4.0 * math.pi) * math.factorial(band - m) / math.factorial(band + m))
            k *= math.sqrt(2.0) if m else 1.0
            out[:, band * band + band + m] = k * p * c
            if m:
                out[:, band * band + band - m] = k * p * s
    return out


def inputs(ctx: Context, kind: str) -> tuple[Floats, F8, F8]:
    """A source cube, its directions, and the exact irradiance / pi in DIRECTIONS directions."""
    tools = ctx.lent()
    d = tools.cube_directions(SOURCE)
    faces = tools.source_faces(kind, SOURCE)
    truth = ctx.references.get(
        "irradiance", {"faces": faces, "directions": DIRECTIONS}, lambda: {"e": convolve(faces, d)}
    )["e"]
    return faces, d, truth


def convolve(faces: Floats, directions: F8) -> F8:
    """Irradiance / pi by a sum over every texel, f8[DIRECTIONS,3]."""
    n = fibonacci(DIRECTIONS)
    weight = np.maximum(n @ directions.reshape(-1, 3).T, 0.0) * solid_angles(directions).ravel()
    result: F8 = weight @ faces.reshape(-1, 3).astype(np.float64) / math.pi
    return result


def project(faces: Floats, directions: F8, bands: int) -> F8:
    """Coefficients f8[bands^2,3] of irradiance / pi."""
    weights = solid_angles(directions).ravel()
    if bands == 3:  # the renderer's own
        radiance = sh.project(faces.reshape(-1, 3), directions.reshape(-1, 3), weights)
        return np.asarray(sh.irradiance_coefficients(radiance) / math.pi)
    basis = harmonics(directions.reshape(-1, 3), bands)
    factors = np.concatenate([np.full(2 * band + 1, cosine_factor(band)) for band in range(bands)])
    return np.asarray((basis.T @ (faces.reshape(-1, 3) * weights[:, None])) * factors[:, None] / math.pi)


def run(ctx: Context, knobs: Knobs) -> Trial:
    n = int(knobs["n"])
    faces, d, truth = ctx.once("studio", lambda: inputs(ctx, "studio"))
    if knobs["method"] == "harmonics":
        coefficients = project(faces, d, n)

        def evaluate(at: F8) -> F8:
            result: F8 = (sh.basis9(at) if n == 3 else harmonics(at, n)) @ coefficients
            return result
    else:
        step = SOURCE // n
        radiance = faces.reshape(6, n, step, n, step, 3).mean(axis=(2, 4), dtype=np.float64)
        coarse = ctx.lent().cube_directions(n)
        weighted = radiance.reshape(-1, 3) * solid_angles(coarse).reshape(-1, 1) / math.pi

        def evaluate(at: F8) -> F8:
            result: F8 = np.maximum(at @ coarse.reshape(-1, 3).T, 0.0) @ weighted
            return result

    points = fibonacci(SHADED)

    def judge(_: object) -> Outcome:
        got = evaluate(fibonacci(DIRECTIONS))
        error = got - truth
        return Outcome(
            {
                "rel_rmse": float(np.sqrt(np.mean(error**2) / np.mean(truth**2))),
                "max_error": float(np.abs(error).max() / truth.max()),
            },
            extra={"numbers stored": 3 * n * n * (1 if knobs["method"] == "harmonics" else 6)},
        )

    return Trial(lambda: evaluate(points), judge)


def _step(knobs: Knobs) -> float:
    return 1.0 / float(knobs["n"])


EXPERIMENT = Experiment(
    title="Diffuse light from an environment",
    method="irradiance by spherical harmonics of n bands, and by summing a cube of n² texels a face",
    truth="the cosine-weighted sum over all texels of the 32² source, float64, studio, in 512 directions",
    metric="rel_rmse",
    unit="of the rms",
    knobs=[{"method": "harmonics", "n": n} for n in (1, 2, 3, 5, 7, 9, 11)]
    + [{"method": "convolution", "n": n} for n in (2, 4, 8, 16)],
    default={"method": "harmonics", "n": 3},
    curve="method",
    run=run,
    orders=[
        Order(
            2.5,
            "the cosine's coefficients fall as band^-5/2",
            "1 / bands",
            step=_step,
            curve="harmonics",
            between=(0.0, 0.35),
            tolerance=1.2,
        ),
        Order(
            2.0,
            "midpoint sums over texels: h²",
            "1 / texels of an edge",
            step=_step,
            curve="convolution",
            tolerance=0.6,
        ),
    ],
    needs=frozenset({"tools"}),
    step_label="1 / n (bands, or texels of an edge)",
    time_label=f"median time of {SHADED:,} directions",
    note="Three bands (nine colours) are the renderer's. Odd bands beyond the first add nothing, so 3, 5, 7 … are"
    " the choices. The light's own spectrum adds to the fall of the cosine's coefficients.",
)
