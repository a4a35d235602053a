"""White furnace: what each pairing of distribution and masking gives back of the light it receives."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from engine.experiments.harness.context import Context
from engine.experiments.harness.experiment import Experiment, Knobs, Outcome, Trial
from engine.math import ggx, microfacet
from engine.report.metrics import energy_deviation
from engine.report.records import Extreme

F8 = NDArray[np.float64]
Masking = Callable[[F8, F8, F8, F8, F8], F8]

ALPHAS = np.array([0.05, 0.1, 0.2, 0.35, 0.5, 0.7, 1.0])
COSINES = np.array([0.05, 0.1, 0.2, 0.4, 0.6, 0.8, 1.0])


def _g(masking: str, distribution: str) -> Masking:
    """G of n.v, n.l, alpha, n.h, v.h from the renderer's V."""

    def term(v: F8, l: F8, alpha: F8, nh: F8, vh: F8) -> F8:
        value: F8 = 4.0 * v * l * microfacet.visibility(masking, distribution, v, l, nh, vh, alpha)
        return value

    return term


def _separable_ggx(v: F8, l: F8, alpha: F8, nh: F8, vh: F8) -> F8:
    result: F8 = ggx.G1_Smith(v, alpha) * ggx.G1_Smith(l, alpha)
    return result


_D = microfacet.D_TERMS
#: name -> (distribution, masking, whether multiple scattering is added)
PAIRS: dict[str, tuple[Callable[[F8, F8], F8], Masking, bool]] = {
    "GGX, Smith, multiple": (_D["ggx"], _g("smith", "ggx"), True),
    "GGX, Smith": (_D["ggx"], _g("smith", "ggx"), False),
    "GGX, separable": (_D["ggx"], _separable_ggx, False),
    "GGX, Schlick": (_D["ggx"], _g("schlick", "ggx"), False),
    "GGX, Cook-Torrance": (_D["ggx"], _g("cook_torrance", "ggx"), False),
    "Beckmann, Walter": (_D["beckmann"], _g("walter", "beckmann"), False),
    "Beckmann, Schlick": (_D["beckmann"], _g("schlick", "beckmann"), False),
    "Blinn-Phong, Walter": (_D["blinn_phong"], _g("walter", "blinn_phong"), False),
    "Blinn-Phong, implicit": (_D["blinn_phong"], _g("implicit", "blinn_phong"), False),
    "GGX, Walter (mismatched)": (_D["ggx"], _g("walter", "ggx"), False),
    "GGX, implicit": (_D["ggx"], _g("implicit", "ggx"), False),
}
#: those whose masking was derived for their distribution
MATCHED = ("GGX, Smith, multiple", "GGX, Smith", "GGX, separable", "GGX, Cook-Torrance", "Beckmann, Walter")
#: alpha up to which Beckmann's masking serves Blinn-Phong, which is no longer like Beckmann when rougher
ALIKE = 0.35


def albedo(pair: str, alpha: F8, mu: F8, order: int) -> F8:
    """Directional albedo with F = 1, by Gauss-Legendre over the half vector warped by D's elevation.

    The half vector's slope is tan = alpha sqrt(u / (1 - u)), GGX's own warp, which also resolves Beckmann's lobe.
    """
    distribution, masking, multiple = PAIRS[pair]
    nodes, weights = np.polynomial.legendre.leggauss(order)
    u, du = (nodes + 1.0) / 2.0, weights / 2.0
    phi, dphi = (nodes + 1.0) / 2.0 * math.pi, weights / 2.0 * math.pi
    a, m = alpha[:, None, None], mu[:, None, None]
    # a cubic warp towards both ends: roots and the horizon lie there
    s, ds = u * u * (3.0 - 2.0 * u), 6.0 * u * (1.0 - u) * du
    c2 = (1.0 - s) / (1.0 + (a * a - 1.0) * s[None, None, :])
    nh = np.sqrt(c2)
    sh = np.sqrt(1.0 - c2)
    vh = np.sqrt(1.0 - m * m) * sh * np.cos(phi)[None, :, None] + m * nh
    nl = 2.0 * vh * nh - m
    valid = (vh > 0.0) & (nl > 1e-9)
    light = np.where(valid, nl, 1.0)
    # f nl dl = D G / (4 nv nl) nl 4 vh dh, and D_GGX nh dh = ds dphi / (2 pi)
    relative = distribution(nh, a) / np.maximum(ggx.D_GGX(nh, a), 1e-300)
    value = np.where(valid, relative * masking(m, light, a, nh, vh) * vh / (m * nh), 0.0)
    single: F8 = (value * ds[None, None, :] * (dphi / math.pi)[None, :, None]).sum(axis=(1, 2))
    if not multiple:
        return single
    # what single scattering loses comes back (Fdez-Aguera 2019 with F = 1): fss + fms, fms = 1 - fss
    one, more = ggx.multiple_scattering(np.ones_like(single), np.stack([single, 0.0 * single], axis=-1))
    result: F8 = one + more
    return result


def run(ctx: Context, knobs: Knobs) -> Trial:
    alpha, mu = (v.ravel() for v in np.meshgrid(ALPHAS, COSINES, indexing="ij"))
    order = 96 if ctx.quick else 256
    pair = knobs["pair"]
    found = albedo(pair, alpha, mu, order)
    fine = (alpha[::7], mu[::7])
    uncertain = float(np.max(np.abs(albedo(pair, *fine, order) - albedo(pair, *fine, order // 2))))
    deviation = np.abs(found - 1.0).reshape(len(ALPHAS), -1).max(axis=1)

    def judge(_: object) -> Outcome:
        return Outcome(
            {"energy_deviation": energy_deviation(found), "gain": max(float(found.max()) - 1.0, 0.0)},
            profile=list(zip(ALPHAS, np.maximum(deviation, 1e-16), strict=True)),
            extra={"least albedo": float(found.min()), "greatest": float(found.max()), "quadrature ±": uncertain},
        )

    # the shading work of one pair, on as many samples as a small picture has
    rng = np.random.default_rng(0)
    distribution, masking, multiple = PAIRS[pair]
    c, v, l = (rng.uniform(0.05, 1.0, 1 << 14) for _ in range(3))
    a = np.full_like(c, 0.3)
    table = np.stack([np.full_like(c, 0.6), np.full_like(c, 0.2)], axis=-1)

    def work() -> F8:
        value: F8 = distribution(c, a) * masking(v, l, a, c, c) / (4.0 * v * l)
        return value + ggx.multiple_scattering(c, table)[1] if multiple else value

    return Trial(work, judge)


def extremes(ctx: Context) -> Iterator[Extreme]:
    alpha, mu = (v.ravel() for v in np.meshgrid(ALPHAS, COSINES, indexing="ij"))
    for pair in MATCHED:
        most = float(albedo(pair, alpha, mu, 128).max())
        yield Extreme(f"{pair}: a matched pair makes no light", f"at most {most:.5f}", most <= 1.0 + 1e-3)
    borrowed = albedo("Blinn-Phong, Walter", alpha, mu, 128)
    smooth, rough = float(borrowed[alpha <= ALIKE].max()), float(borrowed.max())
    yield Extreme(
        f"Blinn-Phong with Beckmann's masking keeps energy up to alpha {ALIKE:g}, and makes light beyond",
        f"at most {smooth:.4f}, {rough:.2f}", smooth <= 1.0 + 1e-3 < rough,
    )  # fmt: skip
    most = float(albedo("GGX, Walter (mismatched)", alpha, mu, 128).max())
    yield Extreme("GGX with Beckmann's masking does make light", f"up to {most:.2f}", most > 1.1)


EXPERIMENT = Experiment(
    title="Energy of matched and mismatched pairs",
    method="directional albedo of a white (F = 1) surface for pairs of D and G, with and without multiple scattering",
    truth="a furnace: everything comes back, albedo 1; integrated by float64 Gauss-Legendre over the half vector",
    metric="energy_deviation",
    unit="of albedo",
    knobs=[{"pair": pair} for pair in PAIRS],
    default={"pair": "GGX, Smith, multiple"},
    curve="pair",
    run=run,
    extremes=extremes,
    profile_label="alpha",
    note="Time is NumPy's for 16,384 samples of the term. A gain above 1e-3 means that the pairing makes light; loss is"
    " what single scattering does not bring back. With multiple scattering the sum is 1 by construction; how well the"
    " shaders' table holds it is what dfg_table asks. No order is expected: these are models, not discretisations.",
)
