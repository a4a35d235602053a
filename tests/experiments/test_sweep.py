"""The framework on made-up methods whose errors, orders and costs are known."""

from __future__ import annotations

import math
from typing import Any

import pytest

from engine.core.errors import InputError, UsageError
from engine.experiments.harness import registry, sweep, verdict
from engine.experiments.harness.context import Context
from engine.experiments.harness.experiment import Experiment, Knobs, Order, Outcome, Trial, grid
from engine.experiments.harness.references import ReferenceCache
from engine.report.records import Extreme, Floor, Omission, Point, Timing


def toy(**changes: Any) -> Experiment:
    def run(ctx: Context, knobs: Knobs) -> Trial:
        n = knobs["n"]
        if n == 13:
            raise InputError("thirteen is not for us")
        error = {"good": 1.0 / n**2, "bad": 1.0 / n, "broken": math.nan}[knobs["form"]]
        return Trial(
            lambda: sum(range(200)),
            lambda _: Outcome({"rmse": error}, profile=[(x, error * x) for x in (1.0, 2.0, 4.0)]),
        )

    values: dict[str, Any] = {
        "title": "Toy", "method": "m", "truth": "t", "metric": "rmse", "unit": "u",
        "knobs": grid(form=("good", "bad"), n=(2, 4, 8)), "default": {"form": "good", "n": 8}, "run": run,
        "curve": "form",
        "orders": [Order(2.0, "h²", "1 / n", step=lambda k: 1.0 / k["n"]), Order(1.0, "linear", "x")],
    }  # fmt: skip
    return Experiment(**{**values, **changes})


@pytest.fixture
def ctx(tmp_path: Any) -> Context:
    return Context(quick=True, references=ReferenceCache(tmp_path))


def test_points_orders_and_times(ctx: Context) -> None:
    result = sweep.run_experiment("toy", toy(), ctx)
    assert [(p.curve, p.knobs["n"]) for p in result.points] == [(f, n) for f in ("good", "bad") for n in (2, 4, 8)]
    assert all(p.ms is not None and p.ms.n >= 5 and p.ms.kind == "cpu" for p in result.points)
    assert result.orders[0].observed == pytest.approx(2.0)
    assert result.orders[1].observed == pytest.approx(1.0)
    assert all(o.met for o in result.orders)
    assert result.order is result.orders[0]
    assert result.timed_on
    assert result.omitted == []


def test_a_wrong_order_is_not_met(ctx: Context) -> None:
    wrong = [Order(2.0, "hoped for", "1 / n", step=lambda k: 1.0 / k["n"], curve="bad")]
    order = sweep.run_experiment("toy", toy(orders=wrong), ctx).order
    assert order is not None
    assert order.observed == pytest.approx(1.0)
    assert not order.met


def test_errors_near_the_noise_floor_are_left_out_of_the_fit(ctx: Context) -> None:
    floor = Floor(0.03, "noise")
    order = sweep.run_experiment("toy", toy(noise_floor=floor), ctx).order
    assert order is not None
    assert order.observed == pytest.approx(2.0), "the two points above it"
    all_hidden = sweep.run_experiment("toy", toy(noise_floor=Floor(1.0, "noise")), ctx).order
    assert all_hidden is not None
    assert all_hidden.observed is None


def test_nothing_is_dropped_silently(ctx: Context) -> None:
    knobs = [*grid(form=("good",), n=(2, 8, 13)), {"form": "broken", "n": 2}, {"form": "good", "n": 4}]
    result = sweep.run_experiment("toy", toy(knobs=knobs, quick=lambda k: k["n"] != 4), ctx)
    assert {o.what for o in result.omitted} == {"form good, n 13", "1 of 5 settings"}
    assert any("thirteen" in o.why for o in result.omitted)
    broken = result.points[-1]
    assert (broken.status, broken.front) == ("nan", False)
    assert broken.ms is not None


def test_what_cannot_run_says_why(ctx: Context) -> None:
    result = sweep.run_experiment("toy", toy(needs=frozenset({"gpu"})), ctx)
    assert result.points == []
    assert result.default_on_front is None
    assert "graphics device" in result.omitted[0].why


def test_failing_extremes_and_tables_are_omissions(ctx: Context) -> None:
    def broken(*_: object) -> list[Any]:
        raise UsageError("no luck")

    result = sweep.run_experiment("toy", toy(extremes=broken, tables=broken), ctx)
    assert {o.what for o in result.omitted} == {"extreme cases", "tables and charts"}
    fine = sweep.run_experiment("toy", toy(extremes=lambda _: [Extreme("x", "y", True)]), Context(quick=True))
    assert fine.extremes == [Extreme("x", "y", True)]


def point(form: str, error: float, ms: float, spread: float = 0.01, **extra: Any) -> Point:
    samples = [ms * (1.0 + spread * (i % 3 - 1)) for i in range(11)]
    return Point({"form": form}, form, {"rmse": error}, Timing(ms, spread, 11), extra=extra, samples=samples)


def judged(points: list[Point], also: tuple[str, ...] = (), problem: str = "") -> Any:
    result = sweep.run_experiment("toy", toy(knobs=[], default={"form": "mine"}), Context(quick=True))
    result.points = points
    verdict.mark_front(result, problem, also)
    return result


def test_a_default_is_beaten_by_the_faster_and_less_wrong() -> None:
    result = judged([point("mine", 1.0, 2.0), point("other", 0.5, 1.0)])
    assert result.default_on_front is False
    assert result.beaten_by == {"form": "other"}
    assert [p.front for p in result.points] == [False, True]


@pytest.mark.parametrize(
    ("other", "beaten"),
    [
        (("other", 2.0, 1.0), False),  # faster, more wrong: another place on the front
        (("other", 0.5, 3.0), False),  # less wrong, slower
        (("other", 1.0, 1.0), True),  # as wrong, faster
        (("other", 1.0, 1.99), False),  # as wrong, faster by less than is sure
        (("other", 0.5, 2.0), True),  # less wrong, surely as fast
        (("other", math.nan, 0.1), False),
    ],
)
def test_beaten_or_not(other: tuple[str, float, float], beaten: bool) -> None:
    rival = point(*other)
    rival.status = "ok" if math.isfinite(rival.error["rmse"]) else "nan"
    assert judged([point("mine", 1.0, 2.0), rival]).default_on_front is not beaten


def test_noise_beats_nobody() -> None:
    mine, rival = point("mine", 1.0, 2.0), point("other", 0.5, 1.9)
    rival.samples = [0.5, 4.0, 1.9, 3.5, 0.6, 1.9, 3.9, 1.0, 1.9, 3.0, 0.4]
    assert judged([mine, rival]).default_on_front is True


def test_other_costs_and_other_problems_save_a_default() -> None:
    points = [point("mine", 1.0, 2.0, bytes=4), point("other", 0.5, 1.0, bytes=8)]
    assert judged(points, also=("bytes",)).default_on_front is True
    assert judged(points, problem="form").default_on_front is True


def test_trials_are_closed_whatever_happens(ctx: Context) -> None:
    closed = []

    def run(_: Context, knobs: Knobs) -> Trial:
        return Trial(lambda: None, lambda _: Outcome({"rmse": 1.0}), close=lambda: closed.append(knobs["n"]))

    sweep.run_experiment("toy", toy(run=run, orders=[]), ctx)
    assert sorted(closed) == [2, 2, 4, 4, 8, 8]


def test_each_purpose_has_its_own_numbers() -> None:
    a, b = Context(seed=1), Context(seed=1)
    assert a.rng("x").random() == b.rng("x").random()
    assert a.rng("x").random() != a.rng("y").random()
    assert a.rng("x").random() != Context(seed=2).rng("x").random()


def test_registry_finds_by_name_and_says_what_was_meant() -> None:
    names = registry.names()
    assert {"brdf_d", "dfg_table", "pruning", "quaternion"} <= set(names)
    assert names == sorted(names)
    assert registry.get("brdf-d") is registry.get("brdf_d")
    assert list(registry.select(["quaternion", "brdf_d", "quaternion"])) == ["quaternion", "brdf_d"]
    assert list(registry.select([])) == names
    with pytest.raises(UsageError, match="did you mean 'quaternion'"):
        registry.get("quaternoin")


def test_omissions_are_told_once() -> None:
    ctx = Context()
    for _ in range(3):
        ctx.omit("a", "b")
    assert ctx.omitted == [Omission("a", "b")]


def test_grid() -> None:
    assert grid(a=(1, 2), b=("x",)) == [{"a": 1, "b": "x"}, {"a": 2, "b": "x"}]


def test_once_makes_once(ctx: Context) -> None:
    calls: list[int] = []

    def make() -> int:
        calls.append(1)
        return 7

    assert [ctx.once("x", make), ctx.once("x", make)] == [7, 7]
    assert len(calls) == 1
