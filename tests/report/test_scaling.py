"""Cost against size: where methods cross, and the figure that shows it."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import pytest

from engine.report.crossover import crossover
from engine.report.page.scaling import scaling
from engine.report.records import Chart, ChartLine, ChartMark, ChartPoint

SIZES = [1.0, 10.0, 100.0, 1000.0]


def test_lines_cross_where_powers_of_the_size_are_equal() -> None:
    steep = [0.1 * n for n in SIZES]
    gentle = [3.0 * n**0.5 for n in SIZES]  # equal at 900
    assert crossover(SIZES, steep, gentle) == pytest.approx(900.0)
    assert crossover(SIZES, gentle, steep) is None, "the steep one costs more at the largest"


def test_only_the_last_crossing_counts() -> None:
    assert crossover(SIZES, [1.0, 1.0, 1.0, 1.0], [0.5, 2.0, 2.0, 0.5]) == pytest.approx(10**2.5)


def test_never_and_always() -> None:
    assert crossover(SIZES, [1.0] * 4, [2.0] * 4) is None
    assert crossover(SIZES, [2.0] * 4, [1.0] * 4) == 1.0
    assert crossover([], [], []) is None


def line(name: str, power: float) -> ChartLine:
    return ChartLine(name, [ChartPoint(n, 2.0 * n**power, 1.8 * n**power, 2.2 * n**power) for n in SIZES])


def test_the_figure_has_all_points_and_says_where_lines_cross() -> None:
    chart = Chart(
        "a & b", "lights", "time (ms)", [line("a", 1.0), line("b", 0.5)], [ChartMark(30.0, 20.0, "b below a")]
    )
    drawn = scaling(chart)
    root = ElementTree.fromstring(drawn)
    assert root.attrib["aria-label"] == "a & b"
    markers = re.findall(r"<(?:circle|polygon) class=\"dot on c\d\"[^>]*><title>", drawn)
    assert len(markers) == 8, "a marker with a tip for each point"
    assert len(re.findall(r'class="bar', drawn)) == 8
    assert "N* = 30: b below a" in drawn
    assert "time (ms)" in drawn
    # the ring is at the mark: between the ticks of 10 and 100, on a logarithmic axis
    ring = re.search(r'class="default" cx="([\d.]+)"', drawn)
    ticks = {
        m[1]: float(m[0]) for m in re.findall(r'x="([\d.]+)" y="\d+(?:\.\d+)?" text-anchor="middle">(\d+)<', drawn)
    }
    assert ring is not None
    part = (float(ring[1]) - ticks["10"]) / (ticks["100"] - ticks["10"])
    assert part == pytest.approx(0.477, abs=0.01)


def test_nothing_measured_draws_nothing() -> None:
    assert scaling(Chart("none", "x", "y", [ChartLine("a", [])])) == ""
