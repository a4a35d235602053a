"""The three figures: error over time (work-precision), error over step (convergence), error over stress (profile)."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

from engine.report.page.svg import COLORS, Figure, figure, marker
from engine.report.page.text import escape, knobs, milliseconds, plain, scientific
from engine.report.records import Floor, OrderResult, Point, Result

_DASHES = ("", "6 3", "2 3", "9 3 2 3")


def curves(result: Result) -> list[str]:
    """The names of the lines, in order of appearance."""
    return list(dict.fromkeys(p.curve for p in result.points))


def work_precision(result: Result) -> str:
    """Error over median time, log-log: all points, quartile bars, the front, floors, the reference slope."""
    points = [p for p in result.points if p.ms is not None]
    shown = [p for p in points if _drawable(p.error[result.metric])]
    if not shown:
        return ""
    names = curves(result)
    floors = [f for f in (result.noise_floor, result.format_floor) if f is not None and f.value > 0.0]
    entries = _entries(names, result)
    entries.append(('<path class="front" d="M-8 0H8"/>', "Pareto front"))
    entries.append(('<circle class="default" r="7"/>', "default"))
    fig = figure(
        f"{result.title}: error over time", [p.ms.median for p in points if p.ms],
        [*(p.error[result.metric] for p in shown), *_near(floors, shown, result.metric)],
        [name for _, name in entries], nan_row=len(shown) < len(points),
    )  # fmt: skip
    fig.frame(f"{result.time_label} (ms)", f"{result.metric.replace('_', ' ')} ({result.unit})")
    _floors(fig, floors)
    _reference_slope(fig, result, shown)
    for problem in dict.fromkeys(str(p.knobs.get(result.problem, "")) for p in shown):
        same = [p for p in shown if p.front and str(p.knobs.get(result.problem, "")) == problem]
        _front(fig, same, result.metric)
    for name in names:
        mine = sorted((p for p in shown if p.curve == name and p.step is not None), key=lambda p: p.step or 0.0)
        if len(mine) > 1:
            line = [(p.ms.median, p.error[result.metric]) for p in mine if p.ms]
            fig.polyline(line, f"thread c{names.index(name) % COLORS}")
    for point in shown:
        fig.reserve(fig.x(_ms(point)), fig.y(point.error[result.metric]), 5)
    for point in points:
        _point(fig, result, point, names.index(point.curve))
    labels = [(p, _label(p, result)) for p in sorted(shown, key=lambda p: not p.front)]
    for point, text in labels:
        if text:
            fig.note(fig.x(_ms(point)), fig.y(point.error[result.metric]), text)
    fig.legend(entries)
    return fig.render()


def convergence(result: Result) -> str:
    """Error over step with the expected slope of each curve; "" where no order is over a step."""
    orders = [o for o in result.orders if not o.from_profile]
    shown = [p for p in result.points if p.step and _drawable(p.error[result.metric])]
    if not orders or not shown:
        return ""
    names = curves(result)
    used = [n for n in names if any(p.curve == n for p in shown)]
    floors = [f for f in (result.noise_floor, result.format_floor) if f is not None and f.value > 0.0]
    entries = _entries(used, result, names)
    entries.append(('<path class="slope" d="M-8 0H8"/>', "expected slope"))
    ys = [p.error[result.metric] for p in shown]
    fig = figure(
        f"{result.title}: convergence", [p.step or 1.0 for p in shown], [*ys, *_near(floors, shown, result.metric)],
        [name for _, name in entries],
    )  # fmt: skip
    fig.frame(result.step_label or orders[0].over, f"{result.metric.replace('_', ' ')} ({result.unit})")
    _floors(fig, floors)
    for point in shown:
        fig.reserve(fig.x(point.step or 1.0), fig.y(point.error[result.metric]), 5)
    for order in orders:
        mine = [(p.step or 1.0, p.error[result.metric]) for p in shown if p.curve == order.curve]
        _slope_beside(fig, order, mine)
    for name in used:
        mine = sorted((p.step or 1.0, p.error[result.metric]) for p in shown if p.curve == name)
        fig.polyline(mine, f"line c{names.index(name) % COLORS}")
        for x, y in mine:
            fig.add(marker(names.index(name), fig.x(x), fig.y(y), f"dot c{names.index(name) % COLORS}", 4.0))
    fig.legend(entries)
    return fig.render()


def profile(result: Result) -> str:
    """Error over what the method is stressed with, a line per setting; "" where there is none."""
    shown = [p for p in result.points if p.profile is not None and any(map(_drawable, p.profile.y))]
    if not shown:
        return ""
    names = curves(result)
    used = [n for n in names if any(p.curve == n for p in shown)]
    orders = [o for o in result.orders if o.from_profile]
    entries = _entries(used, result, names, line=True)
    if orders:
        entries.append(('<path class="slope" d="M-8 0H8"/>', "expected slope"))
    pairs = [(x, y) for p in shown if p.profile for x, y in zip(p.profile.x, p.profile.y, strict=True)]
    fig = figure(
        f"{result.title}: {result.profile_label}", [x for x, _ in pairs], [y for _, y in pairs if _drawable(y)],
        [name for _, name in entries], nan_row=any(not math.isfinite(y) for _, y in pairs),
    )  # fmt: skip
    fig.frame(result.profile_label, f"error ({result.unit})")
    for name in used:
        css = f"c{names.index(name) % COLORS}"
        for i, point in enumerate(p for p in shown if p.curve == name):
            assert point.profile is not None
            line = list(zip(point.profile.x, point.profile.y, strict=True))
            fig.polyline(line, f"line {css}", _DASHES[i % len(_DASHES)])
            for x, y in line:
                if _drawable(y):
                    fig.reserve(fig.x(x), fig.y(y), 3)
                    fig.add(marker(names.index(name), fig.x(x), fig.y(y), f"dot {css}", 3.0))
                elif not math.isfinite(y):
                    _cross(fig, fig.x(x), css, f"{name}: not finite")
            rest = _label(point, result)
            end = next(((x, y) for x, y in reversed(line) if _drawable(y)), None)
            if rest and end and sum(p.curve == name for p in shown) > 1:
                fig.note(fig.x(end[0]), fig.y(end[1]), rest)
    for order in orders:
        found = next((p for p in shown if p.knobs == order.knobs), None)
        if found is not None and found.profile is not None:
            line = [
                (x, y) for x, y in zip(found.profile.x, found.profile.y, strict=True)
                if order.span[0] <= x <= order.span[1] and _drawable(y)
            ]  # fmt: skip
            _slope_beside(fig, order, line)
    fig.legend(entries)
    return fig.render()


def _entries(
    used: Sequence[str], result: Result, names: Sequence[str] | None = None, *, line: bool = False
) -> list[tuple[str, str]]:
    order = list(names if names is not None else used)
    stroke = '<path class="line {c}" d="M-8 0H8"/>' if line else ""
    found = []
    for name in used:
        i = order.index(name)
        css = f"c{i % COLORS}"
        found.append((stroke.format(c=css) + marker(i, 0, 0, f"dot on {css}", 4.0), name or result.name))
    return found


def _curve_knob(result: Result) -> str:
    """The knob whose value is the name of the curve."""
    for point in result.points:
        for name, value in point.knobs.items():
            if str(value) == point.curve:
                return name
    return ""


def _label(point: Point, result: Result) -> str:
    """The knobs that tell a point from others of its curve; those that are the same everywhere tell nothing."""
    curve = _curve_knob(result)
    differs = [k for k in point.knobs if k != curve and len({str(p.knobs.get(k)) for p in result.points}) > 1]
    values = [point.knobs[k] for k in differs]
    return plain(values[0]) if len(values) == 1 else knobs({k: point.knobs[k] for k in differs})


def _point(fig: Figure, result: Result, point: Point, curve: int) -> None:
    assert point.ms is not None
    ms, error = point.ms, point.error[result.metric]
    x, css = fig.x(ms.median), f"c{curve % COLORS}"
    tip = f"{knobs(point.knobs)}: {scientific(error, 3)} in {milliseconds(ms.median)} ms (IQR {milliseconds(ms.iqr)})"
    if not math.isfinite(error):
        _cross(fig, x, css, tip)
        return
    if error <= 0.0:
        y = fig.y.start - 3
        tip += ", exact"
    else:
        y = fig.y(error)
    low, high = max(ms.low, fig.x.low), min(ms.high, fig.x.high)
    fig.add(f'<path class="bar {css}" d="M{fig.x(low):.1f} {y:.1f}H{fig.x(high):.1f}"/>')
    if all(point.knobs.get(k) == v for k, v in result.default.items()):
        fig.add(f'<circle class="default" cx="{x:.1f}" cy="{y:.1f}" r="10"/>')
    fig.add(marker(curve, x, y, f"dot {'on ' if point.front else ''}{css}", 5.0, tip))


def _cross(fig: Figure, x: float, css: str, tip: str) -> None:
    y = fig.y.stop - 7
    fig.add(f'<path class="nan {css}" d="M{x - 4:.1f} {y - 4:.1f}l8 8m0 -8l-8 8"><title>{escape(tip)}</title></path>')


def _front(fig: Figure, points: Sequence[Point], metric: str) -> None:
    """The staircase: what is reachable at each time."""
    ordered = sorted(points, key=_ms)
    if not ordered:
        return
    first = ordered[0]
    path = f"M{fig.x(_ms(first)):.1f} {fig.y.stop}V{fig.y(first.error[metric]):.1f}"
    for point in ordered[1:]:
        path += f"H{fig.x(_ms(point)):.1f}V{fig.y(point.error[metric]):.1f}"
    fig.add(f'<path class="reach" d="{path}H{fig.x.stop}V{fig.y.stop}Z"/>')
    fig.add(f'<path class="front" d="{path}H{fig.x.stop}"/>')


def _floors(fig: Figure, floors: Sequence[Floor]) -> None:
    for floor in floors:
        if not fig.y.low <= floor.value <= fig.y.high:
            continue
        y = fig.y(floor.value)
        fig.add(f'<path class="floor" d="M{fig.x.start} {y:.1f}H{fig.x.stop}"/>')
        text = f"{floor.what}: {scientific(floor.value)}"
        width = 5.4 * len(text)
        below = y + 12 < fig.y.start
        fig.boxes.append((fig.x.stop - width - 4, y + 1 if below else y - 12, width + 4, 11))
        at = f'x="{fig.x.stop - 4}" y="{y + (11 if below else -4):.1f}"'
        fig.add(f'<text class="note" {at} text-anchor="end">{escape(text)}</text>')


def _near(floors: Sequence[Floor], points: Sequence[Point], metric: str) -> list[float]:
    """Floors worth drawing: within three decades of the lowest point."""
    low = min(p.error[metric] for p in points)
    return [f.value for f in floors if f.value > low * 1e-3]


def _reference_slope(fig: Figure, result: Result, shown: Sequence[Point]) -> None:
    """How the error falls with time where the order holds: error ~ time^(-order / cost)."""
    for order in result.orders:
        if order.from_profile or order.cost <= 0.0:
            continue
        mine = [(_ms(p), p.error[result.metric]) for p in shown if p.curve == order.curve]
        if len(mine) > 1:
            _beside(fig, mine, -order.expected / order.cost, f"slope {-order.expected / order.cost:.2g}")


def _slope_beside(fig: Figure, order: OrderResult, points: Sequence[tuple[float, float]]) -> None:
    if len(points) > 1:
        _beside(fig, points, order.expected, f"slope {order.expected:g}")


def _beside(fig: Figure, points: Sequence[tuple[float, float]], slope: float, text: str) -> None:
    """A line of this slope along the points, a little above them, clipped to the plot."""
    logs = [(math.log10(x), math.log10(y)) for x, y in points]
    mid_x = sum(x for x, _ in logs) / len(logs)
    mid_y = sum(y for _, y in logs) / len(logs) + 0.045 * fig.y.decades
    reach = (max(x for x, _ in logs) - min(x for x, _ in logs)) / 2 + 0.02 * fig.x.decades
    line = []
    for i in range(41):
        x = mid_x + reach * (i / 20 - 1)
        y = mid_y + slope * (x - mid_x)
        if math.log10(fig.y.low) <= y <= math.log10(fig.y.high) and fig.x.low <= 10**x <= fig.x.high:
            line.append((10**x, 10**y))
    fig.polyline(line, "slope")
    for x, y in itertools.islice(line, len(line) // 3, None, 4):
        # above the line, whichever way it goes
        if fig.note(fig.x(x), fig.y(y) - 2, text, left=slope > 0.0):
            break


def _ms(point: Point) -> float:
    assert point.ms is not None
    return point.ms.median


def _drawable(value: float) -> bool:
    return math.isfinite(value) and value > 0.0
