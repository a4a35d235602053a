"""Integrating the lobes of Beckmann and Blinn-Phong: importance sampling of D against quadrature."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from engine.experiments.albedo_integration import shifted
from engine.experiments.brdf_energy import albedo
from engine.experiments.harness.context import Context
from engine.experiments.harness.experiment import Experiment, Knobs, Order, Outcome, Trial
from engine.math import microfacet
from engine.report.records import Extreme, Floor

F8 = NDArray[np.float64]

#: distribution -> its pair in brdf_energy, and its key in engine.math.microfacet
PAIRS = {"Beckmann": ("Beckmann, Walter", "beckmann"), "Blinn-Phong": ("Blinn-Phong, Walter", "blinn_phong")}
#: (alpha, n.v) of the lobes that are integrated
LOBES = tuple((a, c) for a in (0.09, 0.25, 0.64) for c in (0.1, 0.3, 0.6, 0.95))
ALPHA, COSINE = (np.array(column) for column in zip(*LOBES, strict=True))
SETS = 8
SAMPLES = (16, 64, 256, 1024, 4096)
ORDERS = (4, 8, 16, 32, 64)


def by_half(distribution: str, u: F8, alpha: float, mu: float) -> F8:
    """Estimates f8[sets] of the albedo with F = 1 from `u` f8[sets,n,2]: D (n.h) is sampled, G v.h / (n.v n.h) left."""
    h = microfacet.sample_half(distribution, u, alpha)
    vh = h @ np.array([math.sqrt(1.0 - mu * mu), 0.0, mu])
    nl = 2.0 * vh * h[..., 2] - mu
    lit = (nl > 0.0) & (vh > 0.0) & (h[..., 2] > 0.0)
    light, nh = np.where(lit, nl, 1.0), np.where(lit, h[..., 2], 1.0)
    v = np.full_like(light, mu)
    masking = microfacet.visibility("walter", distribution, v, light, nh, vh, np.full_like(light, alpha))
    return np.asarray(np.where(lit, 4.0 * masking * light * vh / nh, 0.0).mean(axis=-1))


def run(ctx: Context, knobs: Knobs) -> Trial:
    pair, distribution = PAIRS[str(knobs["lobe"])]
    method, n = knobs["method"], int(knobs["n"])
    truth = reference(ctx, str(knobs["lobe"]))["albedo"]
    if method == "quadrature":
        return Trial(lambda: albedo(pair, ALPHA, COSINE, n)[:, None], lambda got: _judge(got, truth))
    if method == "random":
        sets = ctx.rng("u").uniform(size=(SETS, n, 2))
    else:
        sets = np.stack([shifted(n, ctx.seed + i) for i in range(SETS)])

    def work() -> F8:
        return np.stack([by_half(distribution, sets, a, c) for a, c in LOBES])

    return Trial(work, lambda got: _judge(got, truth))


def _judge(got: F8, truth: F8) -> Outcome:
    error = got - truth[:, None]
    return Outcome({"rmse": float(np.sqrt(np.mean(error**2))), "max_error": float(np.abs(error).max())})


def reference(ctx: Context, lobe: str) -> dict[str, F8]:
    """The truth and how sure it is: 512 nodes, and their difference to 384."""

    def make() -> dict[str, F8]:
        coarse, fine = (albedo(PAIRS[lobe][0], ALPHA, COSINE, order) for order in (384, 512))
        return {"albedo": fine, "noise_floor": np.maximum(np.abs(fine - coarse).max(), 1e-16)}

    return ctx.references.get(f"albedo-{lobe}", {"lobes": LOBES, "orders": (384, 512)}, make)


def noise_floor(ctx: Context) -> Floor:
    worst = max(float(reference(ctx, lobe)["noise_floor"]) for lobe in PAIRS)
    return Floor(worst, "truth: 384 against 512 nodes")


def extremes(ctx: Context) -> Iterator[Extreme]:
    u = np.array([[[0.0, 0.0], [0.0, 1.0], [1.0 - 2.0**-53, 0.5], [1e-300, 0.25]]])
    for lobe, (_, distribution) in PAIRS.items():
        for alpha in (1e-3, 1.0):
            h = microfacet.sample_half(distribution, u, alpha)
            length = np.linalg.norm(h, axis=-1)
            ok = bool(np.isfinite(h).all() and np.allclose(length, 1.0) and (h[..., 2] >= 0.0).all())
            yield Extreme(f"{lobe}: u at its ends, alpha {alpha:g}", f"n·h from {h[..., 2].min():.3g}", ok)
            got = by_half(distribution, u, alpha, 1e-4)
            yield Extreme(f"{lobe}: n·v of 1e-4, alpha {alpha:g}", f"{got[0]:.3g}", bool(np.isfinite(got).all()))


EXPERIMENT = Experiment(
    title="Integrating the lobes of Beckmann and Blinn-Phong",
    method="directional albedo with Walter's masking: D sampled (random, Hammersley), and Gauss-Legendre",
    truth="Gauss-Legendre with 512 nodes each way, float64",
    metric="rmse",
    unit="of albedo",
    knobs=[
        {"lobe": lobe, "method": method, "n": n}
        for lobe in PAIRS
        for method, counts in (("random", SAMPLES), ("hammersley", SAMPLES), ("quadrature", ORDERS))
        for n in counts
    ],
    default={"method": "quadrature", "n": 32},
    curve="method",
    problem="lobe",
    run=run,
    quick=lambda k: k["n"] <= 1024,
    orders=[
        Order(
            0.5,
            "random points: N^-1/2",
            "1 / evaluations",
            curve="random",
            tolerance=0.15,
            cost=1.0,
            step=lambda knobs: 1.0 / float(knobs["n"]),
        ),
    ],
    noise_floor=noise_floor,
    extremes=extremes,
    step_label="1 / evaluations of the integrand",
    note="Sampling is repeated with eight point sets, so its times are those of eight estimates. Walter's masking is a"
    " rational fit with a corner, where it is cut to 1: it ends the fast fall of quadrature.",
)
