"""What an experiment declares: method, truth, metric, knobs, orders, extremes, and how one setting is run."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from engine.report.records import Chart, Extreme, Floor, Picture, Point, Table

if TYPE_CHECKING:
    from engine.experiments.harness.context import Context

Knobs = Mapping[str, Any]


@dataclass(slots=True)
class Outcome:
    """What judging gave. `error`: by metric name. `profile`: (x, error) pairs over what the method is stressed with."""

    error: dict[str, float]
    profile: Sequence[tuple[float, float]] = ()
    extra: dict[str, Any] = field(default_factory=dict)
    pictures: list[Picture] = field(default_factory=list)


@dataclass(slots=True)
class Trial:
    """One setting, ready. `work` is what is timed (None: time says nothing here); `judge` gets what `work` returned.

    `gpu`: `work` submits to the device; the clock waits for it. `whole`: `work` waits itself, so that its wall time is
    that of processor and device together. `close` frees what the trial holds.
    """

    work: Callable[[], Any] | None
    judge: Callable[[Any], Outcome]
    gpu: bool = False
    whole: bool = False
    close: Callable[[], None] | None = None


@dataclass(frozen=True, slots=True)
class Order:
    """error ~ step^expected, for one curve (the default's when empty).

    `step(knobs)` gives the step of a point, e.g. 1 / samples; without it the order is fitted over the x of the
    profile of `point` (the knobs; the default's when None). `between` limits the steps that count. `cost`: time grows
    as step^-cost, which puts the reference slope into the work-precision diagram.
    """

    expected: float
    label: str
    over: str
    step: Callable[[Knobs], float] | None = None
    curve: str = ""
    point: Knobs | None = None
    between: tuple[float, float] = (0.0, math.inf)
    tolerance: float = 0.25
    cost: float = 0.0
    above: float = 0.0  # errors up to this are rounding and left out


@dataclass(frozen=True, slots=True)
class Experiment:
    """One file's declaration; its name is the file's.

    `metric`: the error on the vertical axis, a key of Outcome.error. `curve`: the knob that names the lines.
    `problem`: the knob that says what is solved; only points of one problem compete. `also`: further costs, names of
    Outcome.extra, in which a point must be no worse to beat the default. `quick` says which knobs remain in quick mode.
    `needs`: of "gpu", "tools", "rays", what it cannot do without. `prepare`: makes truths that take long, piece by
    piece, and tells how much of 1 is done and what comes next.
    `own_scene`: it measures on the scenes that the caller names, or on the one that is open in an editor.
    `patience`: so many times the usual budget for timing, where points are many and slow.
    `held_within`: a default that costs up to this part more than the best is as good, where a model chooses it.
    `advisory`: the default is what one scene is set to, so that a better setting is advice and no defect of ours.
    """

    title: str
    method: str
    truth: str
    metric: str
    unit: str
    knobs: Sequence[Knobs] | Callable[[Context], Sequence[Knobs]]
    default: Knobs
    run: Callable[[Context, Knobs], Trial]
    curve: str = ""
    problem: str = ""
    also: tuple[str, ...] = ()
    orders: Sequence[Order] = ()
    quick: Callable[[Knobs], bool] | None = None
    needs: frozenset[str] = frozenset()
    own_scene: bool = False
    patience: float = 1.0
    held_within: float = 0.0
    advisory: bool = False
    timed: str = "cpu"  # cpu | gpu: all points of one experiment on one device
    noise_floor: Callable[[Context], Floor | None] | Floor | None = None
    format_floor: Floor | None = None
    prepare: Callable[[Context], Iterable[tuple[float, str]]] | None = None
    extremes: Callable[[Context], Iterable[Extreme]] | None = None
    tables: Callable[[Context, Sequence[Point]], Iterable[Table]] | None = None
    charts: Callable[[Context, Sequence[Point]], Iterable[Chart]] | None = None
    step_label: str = ""
    profile_label: str = ""
    time_label: str = "median time"
    note: str = ""


def grid(**axes: Iterable[Any]) -> list[dict[str, Any]]:
    """Every combination of the given values, as knobs: grid(form=("a", "b"), size=(8, 16)) gives four."""
    names = list(axes)
    return [dict(zip(names, values, strict=True)) for values in itertools.product(*axes.values())]
