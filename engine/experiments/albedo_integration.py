"""Integrating the GGX lobe: sampling by chance, by low-discrepancy points, of visible normals, and quadrature."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from engine.experiments.harness.context import Context
from engine.experiments.harness.experiment import Experiment, Knobs, Order, Outcome, Trial
from engine.math import ggx
from engine.math.sphere import hammersley
from engine.report.records import Floor

F8 = NDArray[np.float64]

#: (perceptual roughness, n.v) of the lobes that are integrated
LOBES = tuple((r, c) for r in (0.3, 0.5, 0.8) for c in (0.1, 0.3, 0.6, 0.95))
SETS = 8
SAMPLES = (16, 64, 256, 1024, 4096)
ORDERS = (4, 6, 8, 12, 16, 24, 32)


def by_half(u: F8, roughness: float, mu: float) -> F8:
    """Estimates f8[sets] from `u` f8[sets,n,2], importance sampling D (n.h): weight 4 V n.l v.h / n.h."""
    alpha = roughness * roughness
    h = ggx.sample_half(u, alpha)
    vh = h @ np.array([math.sqrt(1.0 - mu * mu), 0.0, mu])
    nl = 2.0 * vh * h[..., 2] - mu
    weight = 4.0 * ggx.V_SmithGGXCorrelated(mu, np.maximum(nl, 0.0), alpha) * nl * vh / h[..., 2]
    return np.asarray(np.where((nl > 0.0) & (vh > 0.0), weight, 0.0).mean(axis=-1))


def by_visible(u: F8, roughness: float, mu: float) -> F8:
    """The same, sampling visible normals: weight G2 / G1 (Heitz 2018, eq. 19)."""
    alpha = roughness * roughness
    v = np.array([math.sqrt(1.0 - mu * mu), 0.0, mu])
    h = ggx.sample_visible_half(u, np.broadcast_to(v, (*u.shape[:-1], 3)), np.full(u.shape[:-1], alpha))
    nl = 2.0 * (h @ v) * h[..., 2] - mu
    safe = np.maximum(nl, 1e-9)
    g2 = 4.0 * mu * safe * ggx.V_SmithGGXCorrelated(mu, safe, alpha)
    return np.asarray(np.where(nl > 0.0, g2 / ggx.G1_Smith(mu, alpha), 0.0).mean(axis=-1))


def shifted(n: int, seed: int) -> F8:
    """Hammersley points, moved on the torus by a random vector (Cranley and Patterson 1976)."""
    result: F8 = (hammersley(n) + np.random.default_rng(seed).uniform(size=2)) % 1.0
    return result


def run(ctx: Context, knobs: Knobs) -> Trial:
    method, n = knobs["method"], int(knobs["n"])
    truth = reference(ctx)["albedo"]
    if method == "quadrature":
        return Trial(lambda: np.array([[float(ggx.albedo(r, c, n))] for r, c in LOBES]), lambda got: _judge(got, truth))
    estimate = by_visible if method == "visible normals" else by_half
    if method == "random":
        sets = ctx.rng("u").uniform(size=(SETS, n, 2))
    else:
        sets = np.stack([shifted(n, ctx.seed + i) for i in range(SETS)])

    def work() -> F8:
        return np.stack([estimate(sets, r, c) for r, c in LOBES])

    return Trial(work, lambda got: _judge(got, truth))


def _judge(got: F8, truth: F8) -> Outcome:
    error = got - truth[:, None]
    return Outcome({"rmse": float(np.sqrt(np.mean(error**2))), "max_error": float(np.abs(error).max())})


def reference(ctx: Context) -> dict[str, F8]:
    """The truth and how sure it is: 256 nodes, and their difference to 192."""

    def make() -> dict[str, F8]:
        coarse, fine = (np.array([ggx.albedo(r, c, order) for r, c in LOBES]) for order in (192, 256))
        return {"albedo": fine, "noise_floor": np.maximum(np.abs(fine - coarse).max(), 1e-16)}

    return ctx.references.get("ggx-albedo", {"lobes": LOBES, "orders": (192, 256)}, make)


def noise_floor(ctx: Context) -> Floor:
    return Floor(float(reference(ctx)["noise_floor"]), "truth: 192 against 256 nodes")


def _step(knobs: Knobs) -> float:
    return 1.0 / float(knobs["n"] ** (2 if knobs["method"] == "quadrature" else 1))


EXPERIMENT = Experiment(
    title="Integrating the GGX lobe",
    method="directional albedo by importance sampling (random, Hammersley, visible normals) and by Gauss-Legendre",
    truth="Gauss-Legendre with 256 nodes each way, float64",
    metric="rmse",
    unit="of albedo",
    knobs=[{"method": m, "n": n} for m in ("random", "hammersley", "visible normals") for n in SAMPLES]
    + [{"method": "quadrature", "n": n} for n in ORDERS],
    default={"method": "quadrature", "n": 32},
    curve="method",
    run=run,
    quick=lambda k: k["n"] <= 1024,
    orders=[
        Order(0.5, "random points: N^-1/2", "1 / evaluations", step=_step, curve="random", cost=1.0, tolerance=0.15),
        Order(
            0.75,
            "Hammersley: N^-3/4, the horizon is an edge in the integrand",
            "1 / evaluations",
            step=_step,
            curve="hammersley",
            tolerance=0.25,
        ),
        Order(
            1.0,
            "Hammersley on a nearly smooth integrand: N^-1",
            "1 / evaluations",
            step=_step,
            curve="visible normals",
            tolerance=0.3,
        ),
    ],
    noise_floor=noise_floor,
    step_label="1 / evaluations of the integrand",
    note="Sampling is repeated with eight point sets, so its times are those of eight estimates. Quadrature falls"
    " faster than any power once the lobe is resolved. engine.math.ggx takes 48 nodes for what is baked.",
)
