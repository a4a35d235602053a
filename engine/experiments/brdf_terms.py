"""The further microfacet terms in GLSL: the forms of shaders/lib against textbook ones, in float32 and halves."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.experiments.harness.context import Context
from engine.experiments.harness.experiment import Experiment, Knobs, Outcome, Trial
from engine.math import microfacet, sheen
from engine.report.metrics import count_nonfinite
from engine.report.records import Extreme, Floor

F8 = NDArray[np.float64]
Arrays = dict[str, NDArray[Any]]

FUNCTIONS = """
float half_of(float x) { return unpackHalf2x16(packHalf2x16(vec2(x, 0.0))).x; }
vec3 half_of(vec3 v) { return vec3(half_of(v.x), half_of(v.y), half_of(v.z)); }
// as usually typed, by the cosine alone
float beckmann_textbook(float alpha, float c) {
    float a2 = alpha * alpha; float c2 = c * c; return exp((c2 - 1.0) / (a2 * c2)) / (PI * a2 * c2 * c2);
}
float blinn_textbook(float alpha, float c) {
    float p = 2.0 / (alpha * alpha) - 2.0; return (p + 2.0) / (2.0 * PI) * pow(c, p);
}
float conductor_textbook(float f0, float tint, float c) {
    float root = sqrt(f0); float n = mix((1.0 + root) / (1.0 - root), (1.0 - f0) / (1.0 + f0), tint);
    float k2 = (f0 * (n + 1.0) * (n + 1.0) - (n - 1.0) * (n - 1.0)) / (1.0 - f0);
    float s = n * n + k2; float a = 2.0 * n * c;
    float across = (s - a + c * c) / (s + a + c * c); float along = (s * c * c - a + 1.0) / (s * c * c + a + 1.0);
    return 0.5 * (across + along);  // Lazarov 2013's short form, for metals of large index
}
"""
LOBE = {"alpha": "float", "c": "float", "n": "vec3", "h": "vec3"}
ANGLES = {"alpha": "float", "a": "float", "b": "float"}

#: term -> (inputs, form -> GLSL); “robust” is that of shaders/lib
TERMS: dict[str, tuple[dict[str, str], dict[str, str]]] = {
    "D Beckmann": (LOBE, {"robust": "D_Beckmann(alpha, c, n, h)", "textbook": "beckmann_textbook(alpha, c)"}),
    "D Blinn-Phong": (LOBE, {"robust": "D_BlinnPhong(alpha, c, n, h)", "textbook": "blinn_textbook(alpha, c)"}),
    "V Walter": (ANGLES, {"robust": "V_Walter(alpha, a, b)"}),
    "V Schlick": (ANGLES, {"robust": "V_SmithSchlick(0.797884561 * alpha, a, b)"}),
    "V Charlie": (ANGLES, {"robust": "V_Charlie(alpha, a, b)"}),
    "F dielectric": (ANGLES, {"robust": "F_Dielectric(alpha, a)"}),
    "F conductor": (ANGLES, {"robust": "F_Conductor(alpha, b, a)", "textbook": "conductor_textbook(alpha, b, a)"}),
}
ALPHAS = (2.025e-3, 0.01, 0.05, 0.2, 0.5, 1.0)


def _lobe(ctx: Context, count: int) -> tuple[Arrays, F8, F8]:
    """Vectors in the lobe of each alpha; sin^2 and cos^2 of the rounded ones in float64."""
    rng = ctx.rng("terms")
    alpha = np.repeat(np.array(ALPHAS, np.float32), count)
    n = rng.normal(size=(len(alpha), 3))
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    t = np.cross(n, rng.normal(size=n.shape))
    t /= np.linalg.norm(t, axis=1, keepdims=True)
    h = n + t * (alpha * np.sqrt(-np.log(1.0 - rng.uniform(0.0, 0.99, len(alpha)))))[:, None]
    h /= np.linalg.norm(h, axis=1, keepdims=True)
    n32, h32 = n.astype(np.float32), h.astype(np.float32)
    m, w = n32.astype(np.float64), h32.astype(np.float64)
    m /= np.linalg.norm(m, axis=1, keepdims=True)
    w /= np.linalg.norm(w, axis=1, keepdims=True)
    c = np.minimum(np.einsum("ij,ij->i", n32, h32, dtype=np.float32), np.float32(1.0))
    s2 = np.sum(np.cross(m, w) ** 2, axis=1)
    return {"alpha": alpha, "c": c, "n": n32, "h": h32}, s2, 1.0 - s2


def inputs(ctx: Context, term: str, count: int) -> tuple[Arrays, F8]:
    """float32 inputs of a term, and its value in float64 of the same rounded ones."""
    if term.startswith("D "):
        arrays, s2, c2 = ctx.once("lobe", lambda: _lobe(ctx, count))
        a2 = arrays["alpha"].astype(np.float64) ** 2
        if term == "D Beckmann":
            return arrays, np.exp(-s2 / (c2 * a2)) / (math.pi * a2 * c2 * c2)
        p = 2.0 / a2 - 2.0
        return arrays, (p + 2.0) / (2.0 * math.pi) * np.exp(0.5 * p * np.log1p(-s2))
    rng = ctx.rng(term)
    alpha = np.repeat(np.array(ALPHAS, np.float32), count)
    a, b = (np.maximum(rng.uniform(size=len(alpha)) ** 2, 1e-4).astype(np.float32) for _ in range(2))
    if term.startswith("F "):
        alpha = rng.uniform(0.02, 0.97, len(alpha)).astype(np.float32)  # f0
    truths: dict[str, Callable[[], F8]] = {
        "V Walter": lambda: microfacet.V_Walter(a, b, alpha),
        "V Schlick": lambda: microfacet.V_SmithSchlick(a, b, microfacet.schlick_k(alpha, "beckmann")),
        "V Charlie": lambda: sheen.V_Charlie(a, b, alpha),
        "F dielectric": lambda: microfacet.F_dielectric(a, alpha),
        "F conductor": lambda: microfacet.F_conductor(a, *microfacet.conductor_of(alpha, b)),
    }
    return {"alpha": alpha, "a": a, "b": b}, truths[term]()


def run(ctx: Context, knobs: Knobs) -> Trial:
    term, form = str(knobs["term"]), str(knobs["form"])
    count = 1 << (12 if ctx.quick else 14)
    arrays, truth = ctx.once(f"inputs {term}", lambda: inputs(ctx, term, count))
    kinds, forms = TERMS[term]
    name, _, through = form.partition(", ")
    text = forms[name]
    if through:  # what a half precision G-buffer or varying does to it
        for given in kinds:
            text = _through_half(text, given)
        text = f"half_of(min({text}, 65504.0))"  # the greatest half: beyond is an infinity
    include = ["lib/microfacet.glsl", "lib/sheen.glsl"]
    dispatch = ctx.shaders().kernel(text, kinds, "float", include=include, functions=FUNCTIONS).bind(**arrays)

    def judge(_: object) -> Outcome:
        got = dispatch.read()
        off = np.abs(got - truth) / np.maximum(np.abs(truth), 1e-6)
        off = np.where(np.isfinite(off), off, 1e6)
        return Outcome(
            {"p99_relative": float(np.quantile(off, 0.99)), "max_relative": float(off.max())},
            extra={"not finite": count_nonfinite(got)},
        )

    return Trial(dispatch.run, judge, gpu=True, close=dispatch.release)


def _through_half(text: str, name: str) -> str:
    """The expression with an input rounded to a half."""
    inner = text[text.index("(") :]
    parts = [f"half_of({p})" if p == name else p for p in inner[1:-1].split(", ")]
    parts = [p.replace(f"* {name}", f"* half_of({name})") for p in parts]
    return f"{text[: text.index('(')]}({', '.join(parts)})"


def extremes(ctx: Context) -> Iterator[Extreme]:
    c = np.array([-1.0, -1e-7, 0.0, 1e-12, 1e-6, 0.1, 1.0, 1.0 + 1e-6], np.float32)
    n = np.tile(np.array([0, 0, 1], np.float32), (len(c), 1))
    h = np.stack([np.sqrt(np.maximum(1 - c.astype(np.float64) ** 2, 0)), 0 * c, c], -1).astype(np.float32)
    include = ["lib/microfacet.glsl", "lib/sheen.glsl"]
    for term in ("D Beckmann", "D Blinn-Phong"):
        kernel = ctx.shaders().kernel(TERMS[term][1]["robust"], LOBE, "float", include=include)
        got = np.concatenate(
            [kernel(alpha=np.full(len(c), a, np.float32), c=c, n=n, h=h) for a in (0.0, 1e-8, 0.01, 1.0)]
        )
        ok = bool(np.isfinite(got).all() and (got >= 0).all())
        yield Extreme(f"{term}: n·h from -1 to 1, alpha 0, 1e-8, 0.01, 1", f"{got.min():.3g} to {got.max():.3g}", ok)
    zero = np.zeros(3, np.float32)
    for term in ("V Walter", "V Schlick", "V Charlie"):
        kernel = ctx.shaders().kernel(TERMS[term][1]["robust"], ANGLES, "float", include=include)
        got = kernel(alpha=np.array([0.0, 1e-8, 1.0], np.float32), a=zero, b=zero)
        yield Extreme(f"{term}: n·v = n·l = 0", ", ".join(f"{v:.3g}" for v in got), bool(np.isfinite(got).all()))
    for term in ("F dielectric", "F conductor"):
        kernel = ctx.shaders().kernel(TERMS[term][1]["robust"], ANGLES, "float", include=include)
        got = np.concatenate(
            [kernel(alpha=np.full(len(c), f0, np.float32), a=c, b=c * 0 + 1) for f0 in (0.0, 0.04, 1.0)]
        )
        ok = bool(((got >= 0) & (got <= 1)).all())
        yield Extreme(f"{term}: v·h from -1 to 1, f0 of 0, 0.04, 1", f"{got.min():.3g} to {got.max():.3g}", ok)


EXPERIMENT = Experiment(
    title="Further microfacet terms in float32 and through halves",
    method="Beckmann and Blinn-Phong D, Walter's, Schlick's and cloth's V, exact F in GLSL: robust and textbook forms",
    truth="closed forms in float64 of the same rounded inputs",
    metric="p99_relative",
    unit="relative",
    knobs=[
        {"term": term, "form": form}
        for term, (_, forms) in TERMS.items()
        for form in (*forms, "robust, half inputs and result")
    ],
    default={"form": "robust"},
    curve="form",
    problem="term",
    run=run,
    format_floor=Floor(2.0**-24, "float32 rounding"),
    needs=frozenset({"gpu"}),
    timed="gpu",
    extremes=extremes,
    note="No order is expected: rounding alone. Each term is a problem of its own: points compete within it."
    " “Half inputs and result” rounds what goes in and what comes out to 16 bits, as a half precision G-buffer"
    " or interpolant does; a lobe narrower than a half resolves is lost by it, whatever the form.",
)
