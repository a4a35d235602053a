"""Runs an experiment: every setting prepared, judged against the truth, then all timed in turns."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Generator, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from engine.core.errors import LucarnaError
from engine.experiments.harness.clock import GpuClock
from engine.experiments.harness.context import Context
from engine.experiments.harness.experiment import Experiment, Knobs, Outcome, Trial
from engine.experiments.harness.provenance import machine_name
from engine.experiments.harness.verdict import find, mark_front, of_order, order_result
from engine.report.interleave import one_by_one, wall_clock
from engine.report.records import Extreme, Floor, Omission, Picture, Point, Profile, Result, Timing
from engine.report.summary import summarise

#: rounds and seconds of timing: (quick, full)
REPEATS, BUDGET_S = (11, 31), (2.5, 20.0)
__all__ = ["Progress", "Step", "find", "knob_text", "run_experiment", "steps"]

Progress = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class Step:
    """Where a run stands: `done` of 1, what comes next, and the points that are judged so far."""

    done: float
    text: str
    points: Sequence[Point] = ()


#: pictures side by side: one, its truth, where they differ
ROW = 3

#: parts of the progress bar: making truths, judging, timing
PREPARED, JUDGED, TIMED = 0.3, 0.65, 0.95


def run_experiment(name: str, experiment: Experiment, ctx: Context, progress: Progress | None = None) -> Result:
    """Run one experiment. What cannot run is an omission with its reason; nothing is dropped silently."""
    run = steps(name, experiment, ctx)
    while True:
        try:
            step = next(run)
        except StopIteration as stop:
            result: Result = stop.value
            return result
        if progress is not None:
            progress(step.text)


def steps(name: str, experiment: Experiment, ctx: Context) -> Generator[Step, None, Result]:
    """The run of one experiment with a pause after each of its parts (a slice of a truth, a setting judged, a run
    timed), for who draws pictures in between. Closing the generator gives up and frees what the trials hold."""
    started = time.perf_counter()
    result = _empty(name, experiment, ctx)
    reason = _missing(experiment, ctx)
    if reason:
        result.omitted.append(Omission("the whole experiment", reason))
        return result
    trials: list[Trial] = []
    try:
        yield from _measure(experiment, ctx, result, trials)
    except LucarnaError as error:  # what made all of it impossible: a truth, the scene
        ctx.omit("the whole experiment", str(error))
        result.points.clear()
    finally:
        for close in (*(t.close for t in trials if t.close is not None), *ctx.closing):
            close()
    result.omitted += ctx.omitted
    result.references = dict(sorted(ctx.references.used.items()))
    result.note = " ".join([experiment.note, *ctx.notes]).strip()
    result.seconds = time.perf_counter() - started
    return result


def _measure(experiment: Experiment, ctx: Context, result: Result, trials: list[Trial]) -> Iterator[Step]:
    points = result.points
    for part, text in experiment.prepare(ctx) if experiment.prepare is not None else ():
        yield Step(PREPARED * part, text)
    for part, text in _judge_all(experiment, ctx, result, points, trials):
        yield Step(PREPARED + (JUDGED - PREPARED) * part, text, points)
    for part in _time_all(points, trials, experiment, ctx):
        yield Step(JUDGED + (TIMED - JUDGED) * part, "timing", points)
    mark_front(result, experiment.problem, experiment.also, experiment.held_within)
    result.noise_floor = _floor(experiment.noise_floor, ctx)
    floor = result.noise_floor.value if result.noise_floor else 0.0
    result.orders = [order_result(experiment, order, points, floor) for order in experiment.orders]
    yield Step(TIMED, "extreme cases", points)
    result.extremes = _extremes(experiment, ctx)
    try:
        result.tables = list(experiment.tables(ctx, points)) if experiment.tables else []
        result.charts = list(experiment.charts(ctx, points)) if experiment.charts else []
    except LucarnaError as error:
        ctx.omit("tables and charts", str(error))


def _empty(name: str, experiment: Experiment, ctx: Context) -> Result:
    on_gpu = experiment.timed == "gpu" and ctx.device is not None
    return Result(
        name=name, title=experiment.title, method=experiment.method, truth=experiment.truth,
        metric=experiment.metric, unit=experiment.unit, default=dict(experiment.default), default_on_front=None,
        points=[], seed=ctx.seed,
        timed_on=ctx.device.caps.device if on_gpu and ctx.device is not None else machine_name(),
        format_floor=experiment.format_floor, step_label=experiment.step_label,
        profile_label=experiment.profile_label, time_label=experiment.time_label, advisory=experiment.advisory,
        problem=experiment.problem,
    )  # fmt: skip


def _missing(experiment: Experiment, ctx: Context) -> str:
    if "gpu" in experiment.needs and ctx.device is None:
        return "it needs a graphics device, and there is none (see `lucarna doctor`)"
    if "tools" in experiment.needs and ctx.tools is None:
        return "it needs the importers: run it by `lucarna report`"
    if "rays" in experiment.needs:
        from engine.experiments.truth.rays import missing

        return missing()
    return ""


def _judge_all(
    experiment: Experiment, ctx: Context, result: Result, points: list[Point], trials: list[Trial]
) -> Iterator[tuple[float, str]]:
    settings = list(experiment.knobs(ctx) if callable(experiment.knobs) else experiment.knobs)
    if ctx.quick and experiment.quick is not None:
        left = [k for k in settings if not experiment.quick(k)]
        settings = [k for k in settings if experiment.quick(k)]
        if left:
            ctx.omit(f"{len(left)} of {len(left) + len(settings)} settings", "quick mode: " + _list(left))
    for i, knobs in enumerate(settings):
        yield i / len(settings), f"{i + 1}/{len(settings)} {knob_text(knobs)}"
        try:
            trial = experiment.run(ctx, knobs)
        except LucarnaError as error:
            ctx.omit(knob_text(knobs), str(error))
            continue
        try:
            outcome = trial.judge(trial.work() if trial.work is not None else None)
        except LucarnaError as error:
            ctx.omit(knob_text(knobs), str(error))
            if trial.close is not None:
                trial.close()
            continue
        trials.append(trial)
        points.append(_point(experiment, knobs, outcome))
        if outcome.pictures:
            row = [Picture(p.caption, p.pixels) for p in outcome.pictures]
            result.pictures += [row[i : i + ROW] for i in range(0, len(row), ROW)]


def _point(experiment: Experiment, knobs: Knobs, outcome: Outcome) -> Point:
    error = {name: float(value) for name, value in outcome.error.items()}
    x, y = zip(*outcome.profile, strict=True) if outcome.profile else ((), ())
    step = next(
        (o.step(knobs) for o in experiment.orders if o.step is not None and of_order(o, experiment, knobs)), None
    )
    return Point(
        knobs=dict(knobs), curve=str(knobs.get(experiment.curve, "")), error=error,
        status="ok" if math.isfinite(error[experiment.metric]) else "nan", step=step,
        extra=dict(outcome.extra),
        profile=Profile(tuple(map(float, x)), tuple(map(float, y))) if outcome.profile else None,
    )  # fmt: skip


def _time_all(points: list[Point], trials: list[Trial], experiment: Experiment, ctx: Context) -> Iterator[float]:
    at = [i for i, trial in enumerate(trials) if trial.work is not None]
    if not at:
        return
    gpu = GpuClock(ctx.device) if ctx.device is not None else None
    clocks = [gpu if trials[i].gpu and gpu is not None else wall_clock for i in at]
    works = [work for i in at if (work := trials[i].work) is not None]
    which = 0 if ctx.quick else 1
    samples: list[list[float]] = [[] for _ in works]
    yield from one_by_one(
        works, samples, repeats=REPEATS[which], budget_s=BUDGET_S[which] * experiment.patience, clocks=clocks
    )
    for i, times in zip(at, samples, strict=True):
        summary = summarise(times)
        kind = gpu.kind if trials[i].gpu and gpu is not None else "wall" if trials[i].whole else "cpu"
        points[i].samples = times
        low, high = (float(v) for v in np.percentile(times, (25.0, 75.0)))
        points[i].ms = Timing(summary.median, summary.iqr, summary.n, kind, low, high)


def _floor(floor: Callable[[Context], Floor | None] | Floor | None, ctx: Context) -> Floor | None:
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
