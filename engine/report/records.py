"""What a report holds: experiments, their points, floors, orders, omissions. The page and its JSON twin are made of it.

JSON has no NaN and no infinity: such a value is written as null, and the point's `status` says why.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: ok: measured; nan: the error is not finite, the point stays and is drawn at the top edge
STATUSES = ("ok", "nan")


@dataclass(frozen=True, slots=True)
class Timing:
    """Milliseconds: median, interquartile range, number of runs; `kind` as in engine.report.stats.KINDS.

    `low`, `high`: the quartiles, for bars."""

    median: float
    iqr: float
    n: int
    kind: str = "wall"
    low: float = 0.0
    high: float = 0.0


@dataclass(frozen=True, slots=True)
class Profile:
    """Error over what a method is stressed with: angle, distance, roughness. Equal lengths."""

    x: tuple[float, ...]
    y: tuple[float, ...]


@dataclass(slots=True)
class Point:
    """One setting of the knobs. `curve`: the line of the diagram it belongs to. `step`: what an order is fitted over.

    `ms` is None where time says nothing about the method. `extra`: further columns (bytes, counts)."""

    knobs: dict[str, Any]
    curve: str
    error: dict[str, float]
    ms: Timing | None = None
    status: str = "ok"
    step: float | None = None
    front: bool = False
    extra: dict[str, Any] = field(default_factory=dict)
    profile: Profile | None = None
    samples: list[float] = field(default_factory=list)  # ms of each run; not written


@dataclass(frozen=True, slots=True)
class Floor:
    """An error that nothing here gets below, and what makes it."""

    value: float
    what: str


@dataclass(frozen=True, slots=True)
class OrderResult:
    """error ~ step^expected was expected of `curve`; `observed` None: too few points above the floors."""

    curve: str
    expected: float
    observed: float | None
    tolerance: float
    label: str
    over: str
    constant: float = 0.0
    from_profile: bool = False
    cost: float = 0.0
    span: tuple[float, float] = (0.0, 0.0)
    knobs: dict[str, Any] = field(default_factory=dict)  # of the point whose profile was fitted

    @property
    def met(self) -> bool:
        return self.observed is not None and abs(self.observed - self.expected) <= self.tolerance


@dataclass(frozen=True, slots=True)
class Omission:
    """What was not measured, and why. Never silent."""

    what: str
    why: str


@dataclass(frozen=True, slots=True)
class Extreme:
    """A stiff or degenerate case: what was given, what came out, whether that is as it should be."""

    what: str
    found: str
    ok: bool


@dataclass(slots=True)
class Table:
    """Further numbers: rows of texts under column heads."""

    title: str
    columns: list[str]
    rows: list[list[str]]
    note: str = ""


@dataclass(frozen=True, slots=True)
class ChartPoint:
    """A median `y` at a size `x`, with its quartiles. All above 0."""

    x: float
    y: float
    low: float
    high: float


@dataclass(frozen=True, slots=True)
class ChartLine:
    """A method: its cost by size, ascending."""

    name: str
    points: list[ChartPoint]


@dataclass(frozen=True, slots=True)
class ChartMark:
    """A size worth a word: where two lines cross."""

    x: float
    y: float
    text: str


@dataclass(slots=True)
class Chart:
    """What methods cost as a problem grows. On the page only: its numbers are those of the points."""

    title: str
    x_label: str
    y_label: str
    lines: list[ChartLine]
    marks: list[ChartMark] = field(default_factory=list)
    note: str = ""


@dataclass(slots=True)
class Picture:
    """u1[h,w,3], sRGB, with what it shows. On the page only."""

    caption: str
    pixels: NDArray[np.uint8]


@dataclass(slots=True)
class Result:
    """One experiment, run."""

    name: str
    title: str
    method: str
    truth: str
    metric: str
    unit: str
    default: dict[str, Any]
    default_on_front: bool | None
    points: list[Point]
    seed: int
    timed_on: str
    beaten_by: dict[str, Any] | None = None
    orders: list[OrderResult] = field(default_factory=list)
    noise_floor: Floor | None = None
    format_floor: Floor | None = None
    omitted: list[Omission] = field(default_factory=list)
    extremes: list[Extreme] = field(default_factory=list)
    tables: list[Table] = field(default_factory=list)
    charts: list[Chart] = field(default_factory=list)
    pictures: list[list[Picture]] = field(default_factory=list)
    step_label: str = ""
    profile_label: str = ""
    time_label: str = ""
    note: str = ""
    seconds: float = 0.0
    #: the knob that says what is solved: only points alike in it compete
    problem: str = ""
    #: a default that is beaten is advice about one scene, no defect
    advisory: bool = False
    #: truths out of the cache, by name: file stems of name, hash of all that went in, and seed
    references: dict[str, str] = field(default_factory=dict)

    @property
    def order(self) -> OrderResult | None:
        """The order that the experiment is named for: its first."""
        return self.orders[0] if self.orders else None

    def to_json(self) -> dict[str, Any]:
        order = self.order
        return {
            "name": self.name, "title": self.title, "method": self.method, "truth": self.truth,
            "metric": self.metric, "unit": self.unit,
            "expected_order": order.expected if order else None,
            "observed_order": number(order.observed) if order else None,
            "orders": [
                {"curve": o.curve, "over": o.over, "expected": o.expected, "observed": number(o.observed),
                 "tolerance": o.tolerance, "met": o.met, "why": o.label}
                for o in self.orders
            ],
            "default": self.default, "default_on_front": self.default_on_front, "beaten_by": self.beaten_by,
            "points": [point_json(p) for p in self.points],
            "noise_floor": number(self.noise_floor.value) if self.noise_floor else None,
            "format_floor": number(self.format_floor.value) if self.format_floor else None,
            "extremes": [{"what": e.what, "found": e.found, "ok": e.ok} for e in self.extremes],
            "omitted": [{"what": o.what, "why": o.why} for o in self.omitted],
            "tables": [{"title": t.title, "columns": t.columns, "rows": t.rows} for t in self.tables],
            "advisory": self.advisory, "problem": self.problem, "references": self.references,
            "timed_on": self.timed_on, "seed": self.seed, "note": self.note, "seconds": round(self.seconds, 3),
        }  # fmt: skip


@dataclass(slots=True)
class Report:
    """Everything of one run on one machine."""

    device: str
    driver: str
    versions: dict[str, str]
    experiments: list[Result]
    quick: bool = False
    seed: int = 0
    machine: str = ""

    def to_json(self) -> dict[str, Any]:
        return {
            "device": self.device, "driver": self.driver, "versions": dict(sorted(self.versions.items())),
            "machine": self.machine, "quick": self.quick, "seed": self.seed,
            "experiments": [e.to_json() for e in self.experiments],
        }  # fmt: skip


def point_json(point: Point) -> dict[str, Any]:
    """A point as in the JSON twin."""
    ms = point.ms
    return {
        "knobs": dict(point.knobs), "curve": point.curve, "status": point.status, "front": point.front,
        "error": {name: number(value) for name, value in point.error.items()},
        "ms": None if ms is None else {
            "median": number(ms.median), "iqr": number(ms.iqr), "n": ms.n, "kind": ms.kind,
        },
        "extra": {k: number(v) if isinstance(v, float) else v for k, v in point.extra.items()},
        "profile": None if point.profile is None else {
            "x": [number(v) for v in point.profile.x], "y": [number(v) for v in point.profile.y],
        },
    }  # fmt: skip


def number(value: float | None) -> float | None:
    """A JSON number of 6 significant digits, or None for NaN and infinities."""
    if value is None or not math.isfinite(value):
        return None
    return float(f"{value:.6g}")
