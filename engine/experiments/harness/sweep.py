"""Runs an experiment: every setting prepared, judged against the truth, then all timed in turns."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from engine.core.errors import LucarnaError, UsageError
from engine.experiments.harness.clock import GpuClock
from engine.experiments.harness.context import Context
from engine.experiments.harness.experiment import Experiment, Knobs, Order, Outcome, Trial
from engine.experiments.harness.provenance import machine_name
from engine.report.front import pareto_front
from engine.report.interleave import interleaved, wall_clock
from engine.report.interval import ratio_interval
from engine.report.order import fit_order
from engine.report.records import Extreme, Floor, Omission, OrderResult, Picture, Point, Profile, Result, Timing
from engine.report.summary import summarise

#: rounds and seconds of timing: (quick, full)
REPEATS, BUDGET_S = (11, 31), (2.5, 20.0)
#: a point this much less wrong, and surely no slower, beats the default
CLEARLY_LESS = 0.98

Progress = Callable[[str], None]


def run_experiment(name: str, experiment: Experiment, ctx: Context, progress: Progress | None = None) -> Result:
    """Run one experiment. What cannot run is an omission with its reason; nothing is dropped silently."""
    started = time.perf_counter()
    say = progress or (lambda text: None)
    result = _empty(name, experiment, ctx)
    reason = _missing(experiment, ctx)
    if reason:
        result.omitted.append(Omission("the whole experiment", reason))
        return result
    points, trials = _judge_all(experiment, ctx, say, result)
    try:
        say("timing")
        _time_all(points, trials, experiment, ctx)
    finally:
        for trial in trials:
            if trial.close is not None:
                trial.close()
    result.points = points
    _mark_front(result, experiment.problem, experiment.also)
    result.noise_floor = _floor(experiment.noise_floor, ctx)
    floor = result.noise_floor.value if result.noise_floor else 0.0
    result.orders = [_order(experiment, order, points, floor) for order in experiment.orders]
    say("extreme cases")
    result.extremes = _extremes(experiment, ctx)
    try:
        result.tables = list(experiment.tables(ctx, points)) if experiment.tables else []
    except LucarnaError as error:
        ctx.omit("tables", str(error))
    result.omitted += ctx.omitted
    result.note = " ".join([experiment.note, *ctx.notes]).strip()
    result.seconds = time.perf_counter() - started
    return result


def _empty(name: str, experiment: Experiment, ctx: Context) -> Result:
    on_gpu = experiment.timed == "gpu" and ctx.device is not None
    return Result(
        name=name, title=experiment.title, method=experiment.method, truth=experiment.truth,
        metric=experiment.metric, unit=experiment.unit, default=dict(experiment.default), default_on_front=None,
        points=[], seed=ctx.seed,
        timed_on=ctx.device.caps.device if on_gpu and ctx.device is not None else machine_name(),
        format_floor=experiment.format_floor, step_label=experiment.step_label,
        profile_label=experiment.profile_label, time_label=experiment.time_label,
    )  # fmt: skip


def _missing(experiment: Experiment, ctx: Context) -> str:
    if "gpu" in experiment.needs and ctx.device is None:
        return "it needs a graphics device, and there is none (see `lucarna doctor`)"
    if "tools" in experiment.needs and ctx.tools is None:
        return "it needs the importers: run it by `lucarna report`"
    return ""


def _judge_all(experiment: Experiment, ctx: Context, say: Progress, result: Result) -> tuple[list[Point], list[Trial]]:
    settings = list(experiment.knobs(ctx) if callable(experiment.knobs) else experiment.knobs)
    if ctx.quick and experiment.quick is not None:
        left = [k for k in settings if not experiment.quick(k)]
        settings = [k for k in settings if experiment.quick(k)]
        if left:
            ctx.omit(f"{len(left)} of {len(left) + len(settings)} settings", "quick mode: " + _list(left))
    points: list[Point] = []
    trials: list[Trial] = []
    for i, knobs in enumerate(settings):
        say(f"{i + 1}/{len(settings)} {knob_text(knobs)}")
        try:
            trial = experiment.run(ctx, knobs)
            outcome = trial.judge(trial.work() if trial.work is not None else None)
        except LucarnaError as error:
            ctx.omit(knob_text(knobs), str(error))
            continue
        trials.append(trial)
        points.append(_point(experiment, knobs, outcome))
        if outcome.pictures:
            result.pictures.append([Picture(p.caption, p.pixels) for p in outcome.pictures])
    return points, trials


def _point(experiment: Experiment, knobs: Knobs, outcome: Outcome) -> Point:
    error = {name: float(value) for name, value in outcome.error.items()}
    x, y = zip(*outcome.profile, strict=True) if outcome.profile else ((), ())
    step = next((o.step(knobs) for o in experiment.orders if o.step is not None and _of(o, experiment, knobs)), None)
    return Point(
        knobs=dict(knobs), curve=str(knobs.get(experiment.curve, "")), error=error,
        status="ok" if math.isfinite(error[experiment.metric]) else "nan", step=step,
        extra=dict(outcome.extra),
        profile=Profile(tuple(map(float, x)), tuple(map(float, y))) if outcome.profile else None,
    )  # fmt: skip


def _time_all(points: list[Point], trials: list[Trial], experiment: Experiment, ctx: Context) -> None:
    at = [i for i, trial in enumerate(trials) if trial.work is not None]
    if not at:
        return
    gpu = GpuClock(ctx.device) if ctx.device is not None else None
    clocks = [gpu if trials[i].gpu and gpu is not None else wall_clock for i in at]
    works = [work for i in at if (work := trials[i].work) is not None]
    which = 0 if ctx.quick else 1
    samples = interleaved(works, repeats=REPEATS[which], budget_s=BUDGET_S[which], clocks=clocks)
    for i, times in zip(at, samples, strict=True):
        summary = summarise(times)
        kind = gpu.kind if trials[i].gpu and gpu is not None else "cpu"
        points[i].samples = times
        low, high = (float(v) for v in np.percentile(times, (25.0, 75.0)))
        points[i].ms = Timing(summary.median, summary.iqr, summary.n, kind, low, high)


def _mark_front(result: Result, problem: str, also: Sequence[str]) -> None:
    """Fronts are among points that solve the same problem."""
    by_problem: dict[str, list[Point]] = {}
    for point in result.points:
        if point.ms is not None:
            by_problem.setdefault(str(point.knobs.get(problem, "")), []).append(point)
    for same in by_problem.values():
        error = [p.error[result.metric] for p in same]
        for point, on in zip(same, pareto_front([p.ms.median for p in same if p.ms], error), strict=True):
            point.front = bool(on)
    default = find(result.points, result.default)
    if default is None or default.ms is None or default.status != "ok":
        return
    timed = by_problem[str(default.knobs.get(problem, ""))]
    beaten = next((p for p in timed if p is not default and _beats(p, default, result.metric, also)), None)
    result.default_on_front = beaten is None
    result.beaten_by = dict(beaten.knobs) if beaten is not None else None


def _beats(point: Point, default: Point, metric: str, also: Sequence[str]) -> bool:
    """Whether with 95 % confidence `point` is faster with no more error, or less wrong and no slower; in either case
    at no more of the other costs."""
    if point.status != "ok" or any(point.extra[name] > default.extra[name] for name in also):
        return False
    mine, theirs = default.error[metric], point.error[metric]
    if theirs > mine:
        return False
    ratio = ratio_interval(point.samples, default.samples)
    if theirs < CLEARLY_LESS * mine:
        return ratio.high <= 1.0
    return ratio.high < CLEARLY_LESS


def find(points: Sequence[Point], knobs: Knobs) -> Point | None:
    """The point with these knobs (all of the given ones equal)."""
    return next((p for p in points if all(p.knobs.get(k) == v for k, v in knobs.items())), None)


def _of(order: Order, experiment: Experiment, knobs: Knobs) -> bool:
    curve = order.curve or str(experiment.default.get(experiment.curve, ""))
    return str(knobs.get(experiment.curve, "")) == curve


def _order(experiment: Experiment, order: Order, points: Sequence[Point], floor: float) -> OrderResult:
    curve = order.curve or str(experiment.default.get(experiment.curve, ""))
    source = None
    if order.step is not None:
        mine = [p for p in points if p.curve == curve and p.status == "ok"]
        x = [order.step(p.knobs) for p in mine]
        y = [p.error[experiment.metric] for p in mine]
    else:
        source = find(points, order.point if order.point is not None else experiment.default)
        profile = source.profile if source is not None else None
        x, y = (list(profile.x), list(profile.y)) if profile else ([], [])
        curve = source.curve if source is not None else curve
    kept = [(a, b) for a, b in zip(x, y, strict=True) if order.between[0] <= a <= order.between[1]]
    # twice the floor: nearer than that the floor bends the line
    above = max(order.above, 2.0 * floor if order.step is not None else 0.0)
    observed, constant = None, 0.0
    try:
        fit = fit_order([a for a, _ in kept], [b for _, b in kept], floor=above)
        observed, constant = fit.slope, fit.constant
    except UsageError:
        pass  # too few points above the floors: the record says None
    span = (min(a for a, _ in kept), max(a for a, _ in kept)) if kept else (0.0, 0.0)
    return OrderResult(
        curve=curve, expected=order.expected, observed=observed, tolerance=order.tolerance, label=order.label,
        over=order.over, constant=constant, from_profile=order.step is None, cost=order.cost, span=span,
        knobs=dict(source.knobs) if source is not None else {},
    )  # fmt: skip


def _floor(floor: Callable[[Context], Floor] | Floor | None, ctx: Context) -> Floor | None:
    if floor is None or isinstance(floor, Floor):
        return floor
    return floor(ctx)


def _extremes(experiment: Experiment, ctx: Context) -> list[Extreme]:
    if experiment.extremes is None:
        return []
    found: list[Extreme] = []
    try:
        with np.errstate(all="ignore"):
            found.extend(experiment.extremes(ctx))
    except LucarnaError as error:
        ctx.omit("extreme cases", str(error))
    return found


def knob_text(knobs: Knobs) -> str:
    """`form cross, size 64`."""
    return ", ".join(f"{name} {_short(value)}" for name, value in knobs.items()) or "as it is"


def _short(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def _list(settings: Sequence[Knobs]) -> str:
    shown = "; ".join(knob_text(k) for k in settings[:6])
    return shown + (" …" if len(settings) > 6 else "")
