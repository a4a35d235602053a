"""Microfacet terms computed in half precision: what 16-bit arithmetic, not storage, does to each form."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.experiments.harness.context import Context
from engine.experiments.harness.experiment import Experiment, Knobs, Outcome, Trial
from engine.math import ggx, microfacet
from engine.report.metrics import count_nonfinite
from engine.report.records import Extreme, Floor

F8 = NDArray[np.float64]
Arrays = dict[str, NDArray[Any]]
Term = Callable[[Arrays], Any]

#: greatest half
GREATEST = 65504.0
#: roughness below which surfaces are not drawn in halves: its alpha is 0.0079 (Filament's bound for mobile GPUs)
LEAST_ALPHA = 0.0079
ALPHAS = (0.01, 0.05, 0.2, 0.5, 1.0)
TYPES: dict[str, type[np.floating[Any]]] = {"half": np.float16, "float": np.float32}


def _dot(a: NDArray[Any], b: NDArray[Any]) -> Any:
    """Rounded after each step: numpy's own sums are not."""
    return a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1] + a[:, 2] * b[:, 2]


def _sin2(x: Arrays) -> Any:
    """|n x h|^2 (Lagrange's identity), as shaders/lib has it."""
    n, h = x["n"], x["h"]
    c = np.stack([n[:, i - 2] * h[:, i - 1] - n[:, i - 1] * h[:, i - 2] for i in range(3)], axis=1)
    return _dot(c, c)


def _one(x: Arrays, value: float) -> Any:
    return x["alpha"].dtype.type(value)


def _ggx_cross(x: Arrays) -> Any:
    a = x["c"] * x["alpha"]
    k = x["alpha"] / (_sin2(x) + a * a)
    return np.minimum(k * k * _one(x, 1.0 / math.pi), _one(x, GREATEST))


def _ggx_textbook(x: Arrays) -> Any:
    a2, one = x["alpha"] * x["alpha"], _one(x, 1.0)
    d = x["c"] * x["c"] * (a2 - one) + one
    return a2 / (_one(x, math.pi) * d * d)


def _beckmann(x: Arrays) -> Any:
    a, c2 = x["alpha"], np.maximum(x["c"] * x["c"], _one(x, 1e-3))
    s2, inverse = _sin2(x), _one(x, 1.0) / a
    power = np.exp(-(s2 * inverse * inverse) / c2)
    return np.minimum(power * inverse * inverse * _one(x, 1.0 / math.pi) / (c2 * c2), _one(x, GREATEST))


def _beckmann_textbook(x: Arrays) -> Any:
    a2, c2, one = x["alpha"] * x["alpha"], x["c"] * x["c"], _one(x, 1.0)
    return np.exp((c2 - one) / (a2 * c2)) / (_one(x, math.pi) * a2 * c2 * c2)


def _blinn(x: Arrays) -> Any:
    inverse, s2 = _one(x, 1.0) / x["alpha"], _sin2(x)
    # exp(p / 2 log(1 - s2)), near the peak the logarithm by its series; p = 2 / alpha^2 - 2
    near = s2 + s2 * s2 * _one(x, 0.5) + s2 * s2 * s2 * _one(x, 1.0 / 3.0)
    series = np.where(s2 < _one(x, 1.0 / 16.0), near, _one(x, -2.0) * np.log(np.maximum(x["c"], _one(x, 1e-4))))
    power = np.exp(-(series * inverse * inverse - series))
    return np.minimum(power * (inverse * inverse) * _one(x, 1.0 / math.pi), _one(x, GREATEST))


def _blinn_textbook(x: Arrays) -> Any:
    p = _one(x, 2.0) / (x["alpha"] * x["alpha"]) - _one(x, 2.0)
    return (p + _one(x, 2.0)) / _one(x, 2.0 * math.pi) * np.power(x["c"], p)


def _schlick(x: Arrays) -> Any:
    y = _one(x, 1.0) - np.clip(x["a"], _one(x, 0.0), _one(x, 1.0))
    y2 = y * y
    return x["f0"] + (_one(x, 1.0) - x["f0"]) * (y2 * y2 * y)


def _schlick_textbook(x: Arrays) -> Any:
    return x["f0"] + (_one(x, 1.0) - x["f0"]) * np.power(_one(x, 1.0) - x["a"], _one(x, 5.0))


def _dielectric(x: Arrays) -> Any:
    root, one = np.sqrt(x["f0"]), _one(x, 1.0)
    n, c = (one + root) / (one - root), x["a"]
    g = np.sqrt(np.maximum(n * n - one + c * c, _one(x, 0.0)))
    across, along = (g - c) / (g + c), (c * (g + c) - one) / (c * (g - c) + one)
    return _one(x, 0.5) * across * across * (one + along * along)


def _smith(x: Arrays) -> Any:
    a2, one = x["alpha"] * x["alpha"], _one(x, 1.0)
    v, l = x["a"], x["b"]
    s = l * np.sqrt(v * v * (one - a2) + a2) + v * np.sqrt(l * l * (one - a2) + a2)
    return np.minimum(_one(x, 0.5) / s, _one(x, GREATEST))


def _v_schlick(x: Arrays) -> Any:
    k, one = x["alpha"] * _one(x, math.sqrt(2.0 / math.pi)), _one(x, 1.0)
    sides = [c * (one - k) + k for c in (x["a"], x["b"])]
    return _one(x, 0.25) / (sides[0] * sides[1])


def _walter(x: Arrays) -> Any:
    """Without dividing by the cosine twice: G1 / cosine of each side, times each other."""
    one, sides = _one(x, 1.0), []
    for c in (x["a"], x["b"]):
        tangent = np.sqrt(np.maximum(one - c * c, _one(x, 0.0))) / c
        t = _one(x, 1.0) / np.maximum(x["alpha"] * tangent, _one(x, 0.5))  # above 1.6 it does not matter by how much
        fit = (_one(x, 3.535) * t + _one(x, 2.181) * t * t) / (one + _one(x, 2.276) * t + _one(x, 2.577) * t * t)
        sides.append(np.where(t < _one(x, 1.6), fit, one) / c)
    return np.minimum(_one(x, 0.25) * sides[0] * sides[1], _one(x, GREATEST))


def _d_truth(name: str) -> Callable[[Arrays], F8]:
    def truth(x: Arrays) -> F8:
        n, h, a = (x[key].astype(np.float64) for key in ("n", "h", "alpha"))
        n, h = n / np.linalg.norm(n, axis=1, keepdims=True), h / np.linalg.norm(h, axis=1, keepdims=True)
        s2 = np.sum(np.cross(n, h) ** 2, axis=1)
        c2 = 1.0 - s2
        if name == "ggx":
            k = a / (s2 + c2 * a * a)
            return np.asarray(k * k / math.pi)
        if name == "beckmann":
            return np.asarray(np.exp(-s2 / (c2 * a * a)) / (math.pi * a * a * c2 * c2))
        p = 2.0 / (a * a) - 2.0
        return np.asarray((p + 2.0) / (2.0 * math.pi) * np.exp(0.5 * p * np.log1p(-s2)))

    return truth


def _f8(x: Arrays, *names: str) -> list[F8]:
    return [x[name].astype(np.float64) for name in names]


#: term -> (form -> computation, truth in float64)
TERMS: dict[str, tuple[dict[str, Term], Callable[[Arrays], F8]]] = {
    "D GGX": ({"robust": _ggx_cross, "textbook": _ggx_textbook}, _d_truth("ggx")),
    "D Beckmann": ({"robust": _beckmann, "textbook": _beckmann_textbook}, _d_truth("beckmann")),
    "D Blinn-Phong": ({"robust": _blinn, "textbook": _blinn_textbook}, _d_truth("blinn_phong")),
    "F Schlick": (
        {"robust": _schlick, "textbook": _schlick_textbook}, lambda x: ggx.F_Schlick(*_f8(x, "a", "f0")),
    ),
    "F dielectric": ({"robust": _dielectric}, lambda x: microfacet.F_dielectric(*_f8(x, "a", "f0"))),
    "V Smith": ({"robust": _smith}, lambda x: ggx.V_SmithGGXCorrelated(*_f8(x, "a", "b", "alpha"))),
    "V Schlick": (
        {"robust": _v_schlick},
        lambda x: microfacet.V_SmithSchlick(
            x["a"].astype(np.float64), x["b"].astype(np.float64), microfacet.schlick_k(x["alpha"], "beckmann")
        ),
    ),
    "V Walter": ({"robust": _walter}, lambda x: microfacet.V_Walter(*_f8(x, "a", "b", "alpha"))),
}  # fmt: skip


def inputs(ctx: Context, count: int, dtype: type[np.floating[Any]]) -> Arrays:
    """Rounded to `dtype`: half vectors in the GGX lobe of each alpha, cosines, reflectances."""
    rng = ctx.rng("half")
    alpha = np.repeat(np.array(ALPHAS), count)
    n = rng.normal(size=(len(alpha), 3))
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    t = np.cross(n, rng.normal(size=n.shape))
    t /= np.linalg.norm(t, axis=1, keepdims=True)
    h = n + t * (alpha * np.sqrt(-np.log(1.0 - rng.uniform(0.0, 0.95, len(alpha)))))[:, None]
    h /= np.linalg.norm(h, axis=1, keepdims=True)
    a, b = (np.maximum(rng.uniform(size=len(alpha)), 0.02) for _ in range(2))
    f0 = rng.uniform(0.02, 0.9, len(alpha))
    found: Arrays = {name: v.astype(dtype) for name, v in (
        ("alpha", alpha), ("n", n), ("h", h), ("a", a), ("b", b), ("f0", f0),
    )}  # fmt: skip
    found["c"] = np.minimum(_dot(found["n"], found["h"]), dtype(1.0))
    return found


def run(ctx: Context, knobs: Knobs) -> Trial:
    forms, truth_of = TERMS[str(knobs["term"])]
    kind, form = TYPES[str(knobs["arithmetic"])], forms[str(knobs["form"])]
    count = 1 << (11 if ctx.quick else 13)
    given = ctx.once(f"inputs {knobs['arithmetic']}", lambda: inputs(ctx, count, kind))
    truth = truth_of(given)

    def work() -> NDArray[Any]:
        with np.errstate(all="ignore"):
            return np.asarray(form(given))

    def judge(got: NDArray[Any]) -> Outcome:
        assert got.dtype == kind, "all of it in that precision"
        off = np.abs(got.astype(np.float64) - truth) / np.maximum(np.abs(truth), 1e-4)
        off = np.where(np.isfinite(off), off, 1e6)
        return Outcome(
            {"p99_relative": float(np.quantile(off, 0.99)), "median_relative": float(np.median(off)),
             "max_relative": float(off.max())},
            extra={"not finite": count_nonfinite(got)},
        )  # fmt: skip

    return Trial(work, judge)


def extremes(ctx: Context) -> Iterator[Extreme]:
    cosine = np.array([0.0, 1e-7, 6.1e-5, 0.02, 0.5, 1.0], np.float16)
    normal = np.tile(np.array([0, 0, 1], np.float16), (len(cosine), 1))
    sine = np.sqrt(1.0 - cosine.astype(np.float64) ** 2)
    half = np.stack([sine, 0 * sine, cosine], axis=1).astype(np.float16)
    for term, (forms, _) in TERMS.items():
        for alpha in (LEAST_ALPHA, 0.0891, 1.0):
            x = {"alpha": np.full(len(cosine), alpha, np.float16), "n": normal, "h": half, "c": cosine,
                 "a": np.maximum(cosine, np.float16(1e-4)), "b": np.maximum(cosine, np.float16(1e-4)),
                 "f0": np.full(len(cosine), 0.04, np.float16)}  # fmt: skip
            with np.errstate(all="ignore"):
                got = forms["robust"](x)
            ok = bool(np.isfinite(got).all() and (got >= 0.0).all())
            yield Extreme(f"{term} in halves: cosines from 0 to 1, alpha {alpha:g}", f"up to {got.max():.4g}", ok)


EXPERIMENT = Experiment(
    title="Microfacet terms in 16-bit arithmetic",
    method="D, F and V in numpy, rounded after every operation to halves or floats; forms of shaders/lib and textbooks",
    truth="closed forms in float64 of the same rounded inputs",
    metric="p99_relative",
    unit="relative",
    knobs=[
        {"term": term, "form": form, "arithmetic": kind}
        for term, (forms, _) in TERMS.items()
        for form in forms
        for kind in TYPES
    ],
    default={"form": "robust", "arithmetic": "float"},
    curve="form",
    problem="term",
    run=run,
    format_floor=Floor(2.0**-11, "rounding to a half"),
    extremes=extremes,
    advisory=True,  # times of the emulation choose nothing
    note="No order is expected: rounding alone. Times are those of the emulation and say nothing of a GPU, which is up"
    " to twice as fast in halves. That n and h are rounded is in the truth too; what cancels in n x h is not.",
)
