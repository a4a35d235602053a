"""A small report with everything in it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from engine.report.records import (
    Extreme,
    Floor,
    Omission,
    OrderResult,
    Picture,
    Point,
    Profile,
    Report,
    Result,
    Table,
    Timing,
)


def make_result(name: str = "toy", *, title: str = "Toys & <games>") -> Result:
    points = [
        Point(
            {"kind": kind, "n": n}, kind, {"rmse": scale / n**2, "max_error": scale / n},
            Timing(0.1 * n * scale, 0.01, 11, "cpu", 0.095 * n * scale, 0.105 * n * scale), step=1.0 / n,
            front=kind == "a", extra={"bytes": 4 * n},
            profile=Profile((1.0, 10.0, 100.0), (1e-3 / n, math.inf if n == 16 else 1e-2 / n, 1e-1 / n)),
        )
        for kind, scale in (("a", 1.0), ("b", 2.0))
        for n in (4, 8, 16)
    ]  # fmt: skip
    points.append(
        Point({"kind": "b", "n": 32}, "b", {"rmse": math.nan, "max_error": math.inf}, Timing(1, 0, 11), "nan")
    )
    return Result(
        name, title, "a method with <angle> & ampersand", "the truth", "rmse", "units", {"kind": "a", "n": 16}, True,
        points, 1, "this machine",
        orders=[
            OrderResult("a", 2.0, 2.01, 0.2, "h²", "1 / n", 1.0, cost=1.0),
            OrderResult("a", 1.0, 1.0, 0.2, "linear", "x", 1.0, from_profile=True, span=(1.0, 100.0),
                        knobs={"kind": "a", "n": 4}),
            OrderResult("b", 2.0, None, 0.2, "unseen", "1 / n"),
        ],
        noise_floor=Floor(1e-4, "truth's noise"), format_floor=Floor(1.1e-3, "8 bit"),
        omitted=[Omission("n 64", "too <slow>")], extremes=[Extreme("zero", "0", True), Extreme("one", "nan", False)],
        tables=[Table("More", ["x", "y"], [["<1>", "2"]], "a note")],
        pictures=[[Picture("a & b", np.zeros((4, 5, 3), np.uint8))]],
        step_label="1 / n", profile_label="x", time_label="median time", note="A note.",
    )  # fmt: skip


@pytest.fixture
def report() -> Report:
    return Report("llvmpipe", "Mesa 1", {"numpy": "2", "python": "3"}, [make_result()], True, 1, "a processor")
