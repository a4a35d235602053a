"""The tables of an experiment, and the table of contents with every verdict."""

from __future__ import annotations

import math

from engine.report.front import gain
from engine.report.page.text import escape, knobs, milliseconds, plain, scientific
from engine.report.records import OrderResult, Point, Report, Result, Table


def overview(report: Report) -> str:
    """One row per experiment: the default's error and time, whether it is on its front, the orders."""
    rows = []
    for i, r in enumerate(report.experiments, 1):
        default = next((p for p in r.points if is_default(p, r)), None)
        error = scientific(default.error[r.metric]) + f" {escape(r.unit)}" if default else "–"
        ms = milliseconds(default.ms.median) if default and default.ms else "–"
        rows.append(
            f'<tr><td class="r">{i}</td><td><a href="#{escape(r.name)}">{escape(r.title)}</a></td>'
            f"<td>{escape(knobs(r.default))}</td><td>{error}</td>"
            f'<td class="r">{ms}</td><td>{front_text(r)}</td><td class="o">{_orders_text(r.orders)}</td></tr>'
        )
    head = '<tr><th class="r">#</th><th>Experiment</th><th>Default</th><th>Its error</th><th class="r">ms</th>'
    head += "<th>On its front</th><th>Order: observed (expected)</th></tr>"
    return f'<div class="scroll"><table>{head}{"".join(rows)}</table></div>'


def points(result: Result) -> str:
    """Every point: knobs, errors, time, extras."""
    if not result.points:
        return ""
    names = list(dict.fromkeys(k for p in result.points for k in p.knobs))
    errors = list(dict.fromkeys(k for p in result.points for k in p.error))
    extras = list(dict.fromkeys(k for p in result.points for k in p.extra))
    timed = any(p.ms for p in result.points)
    head = "".join(f"<th>{escape(n.replace('_', ' '))}</th>" for n in names)
    head += "".join(f'<th class="r">{escape(n.replace("_", " "))}</th>' for n in errors)
    head += '<th class="r">ms</th><th class="r">IQR</th><th class="r">runs</th>' if timed else ""
    head += "".join(f'<th class="r">{escape(n)}</th>' for n in extras)
    head += '<th>front</th><th class="r">gain per ms</th>' if timed else ""
    gains = _gains(result)
    rows = []
    for p in result.points:
        cells = "".join(f"<td>{escape(plain(p.knobs.get(n, '')))}</td>" for n in names)
        cells += "".join(f'<td class="r">{scientific(p.error.get(n))}</td>' for n in errors)
        if timed:
            cells += _time_cells(p)
        cells += "".join(f'<td class="r">{escape(_value(p.extra.get(n, "")))}</td>' for n in extras)
        if timed:
            cells += f"<td>{'●' if p.front else ''}</td>"
            cells += f'<td class="r">{scientific(gains[id(p)]) if id(p) in gains else ""}</td>'
        rows.append(f'<tr class="default">{cells}</tr>' if is_default(p, result) else f"<tr>{cells}</tr>")
    return f'<div class="scroll"><table><tr>{head}</tr>{"".join(rows)}</table></div>'


def other(table: Table) -> str:
    """A table of the experiment's own."""
    head = "".join(f"<th>{escape(c)}</th>" for c in table.columns)
    body = "".join("<tr>" + "".join(f"<td>{escape(c)}</td>" for c in row) + "</tr>" for row in table.rows)
    note = f'<p class="note soft">{escape(table.note)}</p>' if table.note else ""
    return f'<h3>{escape(table.title)}</h3><div class="scroll"><table><tr>{head}</tr>{body}</table></div>{note}'


def is_default(point: Point, result: Result) -> bool:
    return all(point.knobs.get(k) == v for k, v in result.default.items())


def front_text(result: Result) -> str:
    """The verdict on the default, in words."""
    if result.default_on_front is None:
        return '<span class="soft">not judged</span>'
    if result.default_on_front:
        return '<span class="good">✓ yes</span>'
    if result.advisory:
        return f'<span class="soft">better here: {escape(knobs(result.beaten_by or {}))}</span>'
    return f'<span class="bad">✗ beaten by {escape(knobs(result.beaten_by or {}))}</span>'


def order_text(order: OrderResult) -> str:
    """`0.99 (1)` with a mark."""
    if order.observed is None:
        return f'<span class="soft">too few points ({order.expected:g})</span>'
    mark = '<span class="good">✓</span>' if order.met else '<span class="bad">✗</span>'
    text = f"{order.observed:.2f} ({order.expected:g})".replace("-", "−")
    return f"{mark} {text}"


def _orders_text(orders: list[OrderResult]) -> str:
    return "<br>".join(f"{order_text(o)} <span class='soft'>{escape(o.curve)}</span>" for o in orders) or "–"


def _gains(result: Result) -> dict[int, float]:
    """Of points on the front: the error that another millisecond removed, against the next cheaper one there."""
    front = [p for p in result.points if p.front and p.ms is not None]
    values = gain([p.ms.median for p in front if p.ms], [p.error[result.metric] for p in front])
    return {id(p): float(g) for p, g in zip(front, values, strict=True) if math.isfinite(g)}


def _time_cells(point: Point) -> str:
    if point.ms is None:
        return '<td class="r">–</td><td class="r">–</td><td class="r">–</td>'
    ms = point.ms
    return "".join(f'<td class="r">{v}</td>' for v in (milliseconds(ms.median), milliseconds(ms.iqr), ms.n))


def _value(value: object) -> str:
    if isinstance(value, float):
        return scientific(value)
    return f"{value:,}" if isinstance(value, int) and not isinstance(value, bool) else str(value)
