"""The page: head, overview, one section per experiment, and what the numbers are made of."""

from __future__ import annotations

import base64
import io
import string

from engine.report.page import diagram, tables
from engine.report.page.scaling import scaling
from engine.report.page.style import STYLE
from engine.report.page.text import escape, knobs
from engine.report.records import Picture, Report, Result


def page(report: Report) -> str:
    """One HTML document that needs nothing besides itself."""
    title = "Error against run time"
    parts = [
        "<!DOCTYPE html>", '<html lang="en">', "<head>", '<meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">', f"<title>{title}</title>",
        f"<style>{STYLE}</style>", "</head>", "<body>", "<header>", f"<h1>{title}</h1>",
        '<p class="lead">Each experiment compares ways to compute one thing with a ground truth, and times them in'
        " turns on one device. A method is worth choosing if no other is both faster and less wrong: if it lies on"
        f" the front.{' Measured in quick mode: fewer settings and runs.' if report.quick else ''}</p>",
        _meta(report), "</header>",
        "<nav>", tables.overview(report), "</nav>",
    ]  # fmt: skip
    parts += [_section(i, result) for i, result in enumerate(report.experiments, 1)]
    parts += [_footer(), "</body>", "</html>", ""]
    return "\n".join(parts)


def _meta(report: Report) -> str:
    rows = {
        "Graphics device": f"{report.device} (driver {report.driver})",
        "Processor": report.machine,
        "Versions": ", ".join(f"{name} {value}" for name, value in sorted(report.versions.items())),
        "Seed": str(report.seed),
    }
    cells = "".join(f"<dt>{escape(k)}</dt><dd>{escape(v)}</dd>" for k, v in rows.items() if v)
    return f'<dl class="meta">{cells}</dl>'


def _section(index: int, result: Result) -> str:
    about = {"Method": result.method, "Truth": result.truth, "Timed on": result.timed_on}
    if result.references:
        about["References"] = ", ".join(result.references.values())
    rows = "".join(f"<dt>{k}</dt><dd>{escape(v)}</dd>" for k, v in about.items())
    parts = [
        f'<section id="{escape(result.name)}">',
        f'<h2><span class="n">{index}</span>{escape(result.title)}<code>{escape(result.name)}</code></h2>',
        f'<dl class="about">{rows}<dt>Default</dt><dd>{escape(knobs(result.default))}: on its front?'
        f" {tables.front_text(result)}</dd></dl>",
    ]
    if result.note:
        parts.append(f'<p class="note">{escape(result.note)}</p>')
    parts += [_figures(index, result), _pictures(result)]
    if result.points:
        parts += ["<h3>All points</h3>", tables.points(result)]
    parts += [tables.other(table) for table in result.tables]
    if result.extremes:
        items = "".join(
            f'<li><span class="{"good" if e.ok else "bad"}">{"✓" if e.ok else "✗"}</span> {escape(e.what)}:'
            f' <span class="soft">{escape(e.found)}</span></li>'
            for e in result.extremes
        )
        parts.append(f'<h3>Extreme cases</h3><ul class="plain">{items}</ul>')
    if result.omitted:
        items = "".join(f'<li>{escape(o.what)}: <span class="soft">{escape(o.why)}</span></li>' for o in result.omitted)
        parts.append(f'<h3>Omissions</h3><ul class="plain">{items}</ul>')
    parts.append("</section>")
    return "\n".join(part for part in parts if part)


def _figures(index: int, result: Result) -> str:
    found: list[str] = []
    for draw, words in (
        (diagram.work_precision, _work_words(result)),
        (diagram.convergence, _order_words(result, from_profile=False)),
        (diagram.profile, _order_words(result, from_profile=True)),
    ):
        drawing = "" if draw is diagram.work_precision and _only_time_differs(result) else draw(result)
        if drawing:
            name = f"Figure {index}{'abc'[len(found)]}."
            found.append(f"<figure>{drawing}<figcaption><b>{name}</b> {words}</figcaption></figure>")
    for chart in result.charts:
        drawing = scaling(chart)
        if drawing:
            name = f"Figure {index}{string.ascii_lowercase[len(found)]}."
            words = f"{escape(chart.title)}: medians, bars from quartile to quartile. {escape(chart.note)}"
            found.append(f"<figure>{drawing}<figcaption><b>{name}</b> {words}</figcaption></figure>")
    return f'<div class="figures">{"".join(found)}</div>' if found else ""


def _only_time_differs(result: Result) -> bool:
    """Whether most settings are exact, and their times have figures of their own: one of errors is a row of rings."""
    exact = sum(p.error[result.metric] == 0.0 for p in result.points)
    return bool(result.charts) and 2 * exact > len(result.points)


def _work_words(result: Result) -> str:
    kinds = {p.ms.kind for p in result.points if p.ms}
    how = {
        frozenset({"gpu"}): "GPU timestamps",
        frozenset({"wall"}): "wall time round a finish",
        frozenset({"cpu"}): "CPU time",
    }.get(frozenset(kinds), "time")
    return (
        f"Work and precision: {how}, median of interleaved runs, bars from quartile to quartile. Filled: on the front."
        " Down and to the left is better."
    )


def _order_words(result: Result, *, from_profile: bool) -> str:
    orders = [o for o in result.orders if o.from_profile is from_profile]
    words = "Error as the method is stressed." if from_profile else "Convergence."
    told = [f"{escape(o.curve or 'default')}: {tables.order_text(o)}, {escape(o.label)}" for o in orders]
    return words + (" Order observed (expected): " + "; ".join(told) + "." if told else "")


def _pictures(result: Result) -> str:
    rows = []
    for row in result.pictures:
        cells = "".join(
            f'<figure><img src="{data_uri(p)}" width="{p.pixels.shape[1]}" height="{p.pixels.shape[0]}"'
            f' alt="{escape(p.caption)}"><figcaption>{escape(p.caption)}</figcaption></figure>'
            for p in row
        )
        rows.append(f'<div class="pictures">{cells}</div>')
    return "<h3>Pictures</h3>" + "".join(rows) if rows else ""


def data_uri(picture: Picture) -> str:
    """The picture as a PNG inside the page."""
    from PIL import Image

    buffer = io.BytesIO()
    Image.fromarray(picture.pixels, "RGB").save(buffer, "PNG", optimize=True)
    return "data:image/png;base64," + base64.b64encode(buffer.getvalue()).decode("ascii")


def _footer() -> str:
    return (
        '<p class="foot">Times of one figure are from one device. A default counts as beaten only where another setting'
        " is no slower and less wrong, or faster and no more wrong, with 95 % confidence (bootstrap over paired runs)."
        " Gain per ms: the error that a point removes against the next cheaper one of the front, over the time it takes"
        " more. Crosses at a figure’s top edge: the result was not finite. Errors and times of all points also stand in"
        " report.json.</p>"
    )
