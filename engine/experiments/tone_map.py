"""The shaders' tone maps in float32 against their float64 twins: only rounding may differ."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.experiments.harness.context import Context
from engine.experiments.harness.experiment import Experiment, Knobs, Outcome, Trial
from engine.math import tonemap
from engine.report.records import Extreme, Floor

F8 = NDArray[np.float64]

CURVES = {
    "agx": "tone_map_agx(c)",
    "aces": "tone_map_aces(c)",
    "neutral": "clamp(tone_map_neutral(c), 0.0, 1.0)",
    "none": "clamp(c, 0.0, 1.0)",
}
#: stops about middle grey, 0.18
STOPS = np.arange(-12.0, 13.0, 1.0)


def colors(ctx: Context) -> NDArray[np.float32]:
    """Colours of every saturation at each stop."""
    rng = ctx.rng("colors")
    count = 1 << (13 if ctx.quick else 14)
    rgb = rng.uniform(0.0, 1.0, (len(STOPS), count, 3)) ** rng.uniform(0.2, 3.0, (1, count, 1))
    rgb /= rgb.max(axis=-1, keepdims=True)
    return (rgb * 0.18 * 2.0 ** STOPS[:, None, None]).reshape(-1, 3).astype(np.float32)


def run(ctx: Context, knobs: Knobs) -> Trial:
    rgb = ctx.once("colors", lambda: colors(ctx))
    name = knobs["curve"]
    dispatch = ctx.shaders().kernel(CURVES[name], {"c": "vec3"}, "vec3", include=["lib/tone_map.glsl"]).bind(c=rgb)

    def judge(_: object) -> Outcome:
        want = np.minimum(tonemap.TONE_MAPS[name](rgb), 1.0)
        error = np.abs(dispatch.read() - want).max(axis=1).reshape(len(STOPS), -1)
        rows = np.where(np.isfinite(error), error, np.inf).max(axis=1)
        return Outcome(
            {"max_error": float(rows.max()), "rmse": float(np.sqrt(np.mean(error**2)))},
            profile=list(zip(0.18 * 2.0**STOPS, rows, strict=True)),
            extra={"8-bit steps": float(rows.max() * 255.0)},
        )

    return Trial(dispatch.run, judge, gpu=True, close=dispatch.release)


def extremes(ctx: Context) -> Iterator[Extreme]:
    given = np.array([[0, 0, 0], [1e-30, 0, 0], [32000, 0, 0], [32000, 32000, 32000], [0.0, 1e-4, 1000.0]], np.float32)
    for name in ("agx", "aces", "neutral"):
        got: NDArray[Any] = ctx.shaders().kernel(CURVES[name], {"c": "vec3"}, "vec3", include=["lib/tone_map.glsl"])(
            c=given
        )
        ok = bool(np.isfinite(got).all() and (got >= -1e-6).all() and (got <= 1.0 + 1e-6).all())
        yield Extreme(
            f"{name}: black, nearly black, 32000, one channel alone", f"{got.min():.3g} to {got.max():.3g}", ok
        )


EXPERIMENT = Experiment(
    title="Tone maps in float32",
    method="shaders/lib/tone_map.glsl (AgX, ACES fit, Khronos neutral, none) over 24 stops and all saturations",
    truth="the same published formulas in float64: engine.math.tonemap",
    metric="max_error",
    unit="display-linear",
    knobs=[{"curve": curve} for curve in CURVES],
    default={"curve": "agx"},
    curve="curve",
    run=run,
    problem="curve",
    format_floor=Floor(1.0 / 255.0 / 12.0**0.5, "8-bit display, rms"),
    needs=frozenset({"gpu"}),
    timed="gpu",
    extremes=extremes,
    profile_label="greatest channel, scene-linear",
    note="The curves are looks, not approximations of one another: their times can be compared, their errors only tell"
    " that the float32 form keeps its digits, so each is alone on its front and no order is expected. agx_curve asks"
    " how well AgX's polynomial stands for its sigmoid.",
)
