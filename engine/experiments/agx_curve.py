"""AgX's contrast curve: the sigmoid itself, polynomials fitted to it, and tables."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.experiments.harness.context import Context
from engine.experiments.harness.experiment import Experiment, Knobs, Order, Outcome, Trial
from engine.math.tonemap import AGX_CURVE
from engine.report.records import Floor

F8 = NDArray[np.float64]

#: middle grey's place among AgX's 16.5 stops, what it becomes, the slope there, the powers of toe and shoulder
PIVOT_X, PIVOT_Y, SLOPE, TOE, SHOULDER = 10.0 / 16.5, 0.5, 2.0, 3.0, 3.25

SIGMOID = """
float side(float d, float room, float reach, float power) {
    float scale = pow(pow(SLOPE * reach, -power) * (pow(SLOPE * reach / room, power) - 1.0), -1.0 / power);
    float t = SLOPE * d / scale;
    return scale * t / pow(1.0 + pow(t, power), 1.0 / power);
}
float sigmoid(float x) {
    return x < PX ? PY - side(PX - x, PY, PX, TOE) : PY + side(x - PX, 1.0 - PY, 1.0 - PX, SHOULDER);
}
"""


def sigmoid(x: F8) -> F8:
    """AgX's curve on encoded values (Sobotka 2022): on each side of the pivot a hyperbolic sigmoid of its own power
    that leaves the pivot with the slope and reaches the corner exactly."""

    def side(d: F8, room: float, reach: float, power: float) -> F8:
        scale = ((SLOPE * reach) ** -power * ((SLOPE * reach / room) ** power - 1.0)) ** (-1.0 / power)
        t = SLOPE * d / scale
        result: F8 = scale * t / (1.0 + t**power) ** (1.0 / power)
        return result

    toe = PIVOT_Y - side(np.maximum(PIVOT_X - x, 0.0), PIVOT_Y, PIVOT_X, TOE)
    shoulder = PIVOT_Y + side(np.maximum(x - PIVOT_X, 0.0), 1.0 - PIVOT_Y, 1.0 - PIVOT_X, SHOULDER)
    return np.where(x < PIVOT_X, toe, shoulder)


def fitted(degree: int) -> F8:
    """Least-squares polynomial at Chebyshev points, highest power first; degree 6 is the renderer's, as published."""
    if degree == len(AGX_CURVE) - 1:
        return AGX_CURVE
    x = 0.5 - 0.5 * np.cos((np.arange(2000) + 0.5) / 2000 * np.pi)
    return np.asarray(np.polynomial.Polynomial.fit(x, sigmoid(x), degree).convert().coef[::-1], np.float64)


#: Evaluations to one value that is read and written: of fewer, memory is what is timed, and all curves cost the same.
EVALUATIONS = 32
REPEATED = """
float many(float x, float times) {  // not a constant: some curves would be unrolled, others not
    for (int i = 0; i < int(times); ++i) x = curve(x) * 0.98 + 0.01;
    return x;
}
"""


def curve_text(kind: str, n: int) -> str:
    """GLSL of `float curve(float x)`."""
    if kind == "polynomial":
        text = ""
        for c in fitted(n):
            text = f"(({text}) * x + ({c:.9g}))" if text else f"({c:.9g})"
        return f"float curve(float x) {{ return {text}; }}\n"
    if kind == "table":
        values = ", ".join(f"{v:.9g}" for v in sigmoid(np.linspace(0.0, 1.0, n + 1)))
        return (
            f"const float TABLE[{n + 1}] = float[]({values});\n"
            f"float curve(float x) {{ float p = x * {n}.0; int i = min(int(p), {n - 1});"
            " return mix(TABLE[i], TABLE[i + 1], p - float(i)); }\n"
        )
    return SIGMOID + "float curve(float x) { return sigmoid(x); }\n"


def run(ctx: Context, knobs: Knobs) -> Trial:
    count = 1 << (14 if ctx.quick else 15)
    x = ctx.once("x", lambda: ctx.rng("x").uniform(0.0, 1.0, count).astype(np.float32))
    functions = curve_text(str(knobs["kind"]), int(knobs["n"]))
    constants: dict[str, str | int] = {
        "PX": f"{PIVOT_X:.9g}", "PY": f"{PIVOT_Y:.9g}", "SLOPE": f"{SLOPE:.9g}", "TOE": f"{TOE:.9g}",
        "SHOULDER": f"{SHOULDER:.9g}",
    }  # fmt: skip
    inputs = {"x": "float"}
    one = ctx.shaders().kernel("curve(x)", inputs, "float", functions=functions, defines=constants)
    timed = ctx.shaders().kernel(
        "many(x, times)", inputs | {"times": "float"}, "float", functions=functions + REPEATED, defines=constants
    )
    dispatch = timed.bind(x=x, times=np.full(count, EVALUATIONS, np.float32))

    def judge(_: Any) -> Outcome:
        error = np.abs(one(x=x) - sigmoid(x.astype(np.float64)))
        return Outcome({"max_error": float(error.max()), "rmse": float(np.sqrt(np.mean(error**2)))})

    return Trial(dispatch.run, judge, gpu=True, close=dispatch.release)


EXPERIMENT = Experiment(
    title="AgX's contrast curve",
    method="polynomials by degree (the renderer's published one is of degree 6), linear tables by size, the sigmoid",
    truth="AgX's sigmoid (Sobotka 2022: pivot 0.18, slope 2, powers 3 and 3.25) in float64",
    metric="rmse",
    unit="display-encoded",
    knobs=[{"kind": "polynomial", "n": n} for n in (3, 4, 5, 6, 7, 9, 11)]
    + [{"kind": "table", "n": n} for n in (8, 16, 32, 64, 128)]
    + [{"kind": "sigmoid", "n": 0}],
    default={"kind": "polynomial", "n": 6},
    curve="kind",
    run=run,
    orders=[
        Order(
            2.0,
            "linear interpolation: h²",
            "1 / size",
            curve="table",
            step=lambda k: 1.0 / k["n"] if k["n"] else 1.0,
            tolerance=0.3,
        ),
        Order(
            3.5,
            "least squares of a curve with a kink in its third derivative",
            "1 / degree",
            curve="polynomial",
            step=lambda k: 1.0 / k["n"] if k["n"] else 1.0,
            tolerance=1.5,
        ),
    ],
    format_floor=Floor(1.0 / 255.0 / 12.0**0.5, "8-bit display, rms"),
    needs=frozenset({"gpu"}),
    timed="gpu",
    step_label="1 / n (degree, or size of the table)",
    note="The published polynomial is off by more than an 8-bit display rounds. A table is not, and"
    " costs more where arithmetic is what takes the time; in a shader that waits for memory all of them cost the same.",
    time_label=f"median time of {EVALUATIONS} evaluations for each value that is read",
)
