"""The page: well-formed, on its own, complete; the figures' arithmetic."""

from __future__ import annotations

import math
import re
from html.parser import HTMLParser
from xml.etree import ElementTree

import pytest

from engine.report.page import diagram
from engine.report.page.axes import LogAxis
from engine.report.page.html import page
from engine.report.page.svg import figure
from engine.report.page.text import knobs, power, scientific
from engine.report.records import Report

VOID = {"meta", "img", "br", "link", "hr", "input"}


class Checker(HTMLParser):
    """Tags nest, ids are unique, nothing is fetched."""

    def __init__(self) -> None:
        super().__init__(convert_charrefs=True)
        self.open: list[str] = []
        self.ids: list[str] = []
        self.links: list[str] = []
        self.sources: list[str] = []
        self.tags: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        if tag not in VOID:
            self.open.append(tag)
        for name, value in attrs:
            assert value is not None, f"<{tag} {name}> has no value"
            if name == "id":
                self.ids.append(value)
            if name == "href":
                self.links.append(value)
            if name == "src":
                self.sources.append(value)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag: str) -> None:
        assert self.open, f"</{tag}> closes nothing"
        assert self.open.pop() == tag


def parse(text: str) -> Checker:
    checker = Checker()
    checker.feed(text)
    checker.close()
    return checker


def test_well_formed_and_self_contained(report: Report) -> None:
    text = page(report)
    found = parse(text)
    assert found.open == []
    assert len(found.ids) == len(set(found.ids))
    assert not {"script", "link", "iframe", "object"} & set(found.tags)
    assert all(link.startswith("#") and link[1:] in found.ids for link in found.links)
    assert found.sources
    assert all(source.startswith("data:image/png;base64,") for source in found.sources)
    assert not re.search(r"https?://|url\(|@import", text), "nothing is fetched from anywhere"


def test_everything_is_told(report: Report) -> None:
    text = page(report)
    for word in (
        "llvmpipe", "Mesa 1", "numpy 2", "a processor", "Toys &amp; &lt;games&gt;", "the truth", "this machine",
        "too &lt;slow&gt;", "truth&#x27;s noise", "8 bit", "expected slope", "Pareto front", "&lt;1&gt;", "a note",
        "too few points", "quick mode",
    ):  # fmt: skip
        assert word in text, word


def test_light_dark_and_print(report: Report) -> None:
    text = page(report)
    for rule in ("prefers-color-scheme:dark", "@media print", "color-scheme:light dark"):
        assert rule in text


def test_the_same_report_gives_the_same_bytes(report: Report) -> None:
    assert page(report) == page(report)


@pytest.mark.parametrize("draw", [diagram.work_precision, diagram.convergence, diagram.profile])
def test_figures_are_xml_with_a_name(report: Report, draw: object) -> None:
    assert callable(draw)
    root = ElementTree.fromstring(draw(report.experiments[0]))
    assert root.tag == "svg"
    assert "Toys" in root.attrib["aria-label"]
    assert root.find("title") is not None


def test_every_point_is_drawn_and_what_is_no_number_as_a_cross(report: Report) -> None:
    result = report.experiments[0]
    drawing = diagram.work_precision(result)
    tips = re.findall(r"<title>([^<]*) in ", drawing)
    assert len(tips) == len(result.points)
    assert drawing.count('class="nan') == 1
    assert 'class="floor"' in drawing
    assert 'class="slope"' in drawing
    assert drawing.count('class="default"') == 2, "one in the legend, one on the point"


def test_points_lie_where_they_belong(report: Report) -> None:
    """Twice the time is as far as the axis says: logarithms turn ratios into distances."""
    axis = LogAxis(1.0, 100.0, 0.0, 200.0)
    assert [axis(v) for v in (1.0, 10.0, 100.0)] == pytest.approx([0.0, 100.0, 200.0])
    upward = LogAxis(1e-4, 1.0, 300.0, 100.0)
    assert upward(1e-2) == pytest.approx(200.0)


def test_axes_have_a_few_ticks_whatever_they_span() -> None:
    for low, high in ((1.0, 1.0), (0.37, 0.41), (1.0, 5.0), (0.1, 20.0), (1e-6, 1.0), (1e-16, 1e9)):
        axis = LogAxis.around([low, high], 0.0, 500.0)
        ticks = axis.ticks()
        assert 1 <= len(ticks) <= 12, (low, high, ticks)
        assert all(axis.low <= v <= axis.high for v, _ in ticks)
        assert axis.low < low <= high < axis.high
    assert LogAxis.around([math.nan, 0.0, -1.0], 0.0, 1.0).low > 0.0


def test_texts_do_not_overlap() -> None:
    fig = figure("t", [1.0, 10.0], [1.0, 10.0], [])
    placed = [fig.note(200.0, 200.0, "label") for _ in range(9)]
    assert any(placed)
    assert not all(placed)
    for i, (ax, ay, aw, ah) in enumerate(fig.boxes):
        for bx, by, bw, bh in fig.boxes[:i]:
            assert ax + aw < bx or bx + bw < ax or ay + ah < by or by + bh < ay


@pytest.mark.parametrize(
    ("value", "text"),
    [(None, "–"), (0.0, "0"), (1.0, "1.0"), (0.05, "0.050"), (1234.5, "1234"), (1.5e-7, "1.5 × 10⁻⁷"),
     (-2e5, "-2.0 × 10⁵"), (math.inf, "infinite"), (math.nan, "not a number")],
)  # fmt: skip
def test_numbers(value: float | None, text: str) -> None:
    assert scientific(value) == text


def test_words() -> None:
    assert [power(e) for e in (-3, 0, 1, 2, 12)] == ["10⁻³", "1", "10", "100", "10¹²"]
    assert knobs({"form": "x"}) == "x"
    assert knobs({"form": "x", "n": 0.5, "on": True}) == "form x, n 0.5, on on"
    assert knobs({"form": "x", "n": 3}, "form") == "n 3"
    assert knobs({"form": "x", "value": ""}) == "x"


def test_problems_have_fronts_of_their_own_and_labels_only_what_differs(report: Report) -> None:
    result = report.experiments[0]
    for p in result.points:
        p.knobs["scene"] = "one"
    drawing = diagram.work_precision(result)
    assert "scene" not in re.sub("<title>.*?</title>", "", drawing), "the same everywhere"
    for p in result.points[3:]:
        p.knobs["scene"] = "two"
        p.front = True
    result.problem = "scene"
    assert diagram.work_precision(result).count('class="front" d="M') == drawing.count('class="front" d="M') + 1


def test_advice_is_no_defect(report: Report) -> None:
    result = report.experiments[0]
    result.default_on_front, result.beaten_by, result.advisory = False, {"kind": "b", "n": 4}, True
    text = page(report)
    assert "better here: kind b, n 4" in text
    assert "beaten by kind" not in text
