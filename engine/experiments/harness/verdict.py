"""What the points of an experiment say: which lie on the front, whether the default is beaten, which order is seen."""

from __future__ import annotations

from collections.abc import Sequence

from engine.core.errors import UsageError
from engine.experiments.harness.experiment import Experiment, Knobs, Order
from engine.report.front import CLEARLY_LESS, clearly_less, pareto_front
from engine.report.interval import ratio_interval
from engine.report.order import fit_order
from engine.report.records import OrderResult, Point, Result


def mark_front(result: Result, problem: str, also: Sequence[str], held_within: float = 0.0) -> None:
    """Fronts are among points that solve the same problem. `held_within`: as in Experiment."""
    by_problem: dict[str, list[Point]] = {}
    for point in result.points:
        if point.ms is not None:
            by_problem.setdefault(str(point.knobs.get(problem, "")), []).append(point)
    for same in by_problem.values():
        error = [p.error[result.metric] for p in same]
        for point, on in zip(same, pareto_front([p.ms.median for p in same if p.ms], error), strict=True):
            point.front = bool(on)
    for default in result.points:  # one for each problem
        if default.ms is None or default.status != "ok" or not _has(default, result.default):
            continue
        timed = by_problem[str(default.knobs.get(problem, ""))]
        others = (p for p in timed if p is not default)
        beaten = next((p for p in others if beats(p, default, result.metric, also, held_within)), None)
        if result.default_on_front is not False:
            result.default_on_front = beaten is None
            result.beaten_by = dict(beaten.knobs) if beaten is not None else None


def beats(
    point: Point, default: Point, metric: str, also: Sequence[str] = (), held_within: float = 0.0
) -> bool:  # fmt: skip
    """Whether with 95 % confidence `point` is faster with no more error, or less wrong and no slower; in either case
    at no more of the other costs. Faster: by more than `held_within`."""
    if point.status != "ok" or any(point.extra[name] > default.extra[name] for name in also):
        return False
    mine, theirs = default.error[metric], point.error[metric]
    if theirs > mine:
        return False
    ratio = ratio_interval(point.samples, default.samples)
    if clearly_less(theirs, mine):
        return ratio.high <= 1.0
    return ratio.high < min(CLEARLY_LESS, 1.0 / (1.0 + held_within))


def find(points: Sequence[Point], knobs: Knobs) -> Point | None:
    """The point with these knobs (all of the given ones equal)."""
    return next((p for p in points if _has(p, knobs)), None)


def _has(point: Point, knobs: Knobs) -> bool:
    return all(point.knobs.get(k) == v for k, v in knobs.items())


def of_order(order: Order, experiment: Experiment, knobs: Knobs) -> bool:
    """Whether a point with these knobs lies on the curve that the order is about."""
    curve = order.curve or str(experiment.default.get(experiment.curve, ""))
    return str(knobs.get(experiment.curve, "")) == curve


def order_result(experiment: Experiment, order: Order, points: Sequence[Point], floor: float) -> OrderResult:
    """The order that the points show; `floor`: the truth's noise."""
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
