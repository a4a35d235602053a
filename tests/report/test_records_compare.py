"""The JSON twin: its form, reading it back, comparing two."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import pytest

from engine.core.errors import FormatError, InputError
from engine.report.compare import compare
from engine.report.records import Report
from engine.report.writing import load_twin, write_report


def test_the_twin_has_the_agreed_form(report: Report) -> None:
    data = json.loads(json.dumps(report.to_json(), allow_nan=False))
    assert {"device": str, "driver": str, "versions": dict, "experiments": list}.items() <= {
        k: type(v) for k, v in data.items()
    }.items()
    experiment = data["experiments"][0]
    types = {
        "name": str, "method": str, "truth": str, "metric": str, "expected_order": float, "observed_order": float,
        "default": dict, "default_on_front": bool, "points": list, "noise_floor": float, "omitted": list,
    }  # fmt: skip
    assert {k: type(experiment[k]) for k in types} == types
    point = experiment["points"][0]
    assert point["knobs"] == {"kind": "a", "n": 4}
    assert point["error"] == {"rmse": 0.0625, "max_error": 0.25}
    assert point["ms"]["n"] == 11
    assert point["ms"]["median"] == pytest.approx(0.4)
    assert set(point["ms"]) >= {"median", "iqr", "n"}
    assert experiment["omitted"] == [{"what": "n 64", "why": "too <slow>"}]


def test_what_is_no_number_is_null_with_a_status(report: Report) -> None:
    last = report.to_json()["experiments"][0]["points"][-1]
    assert last["status"] == "nan"
    assert last["error"] == {"rmse": None, "max_error": None}


def test_order_is_met_within_its_tolerance(report: Report) -> None:
    orders = report.experiments[0].orders
    assert [o.met for o in orders] == [True, True, False]


def test_written_twice_the_same_and_read_back(report: Report, tmp_path: Path) -> None:
    page, twin = write_report(report, tmp_path / "a")
    write_report(report, tmp_path / "b")
    assert page.read_bytes() == (tmp_path / "b" / "report.html").read_bytes()
    assert load_twin(twin) == report.to_json()
    assert sorted(p.name for p in (tmp_path / "a").iterdir()) == ["report.html", "report.json"]


BAD_POINT = '{"experiments": [{"name": "x", "points": [%s]}]}'


@pytest.mark.parametrize(
    "text",
    [
        "", "{", "[]", '{"experiments": 3}', '{"experiments": [{"name": "x"}]}', "[" * 99999, BAD_POINT % "3",
        BAD_POINT % '{"error": {"rmse": "x"}}', BAD_POINT % '{"ms": 3}',
        '{"experiments": [{"name": "x", "points": [], "orders": [1]}]}',
    ],
)  # fmt: skip
def test_bad_twins(tmp_path: Path, text: str) -> None:
    path = tmp_path / "x.json"
    path.write_text(text, "utf-8")
    with pytest.raises(FormatError, match=r"x\.json"):
        load_twin(path)
    with pytest.raises(InputError, match="cannot read"):
        load_twin(tmp_path / "none.json")


@pytest.fixture
def before(report: Report) -> dict[str, Any]:
    return report.to_json()


def test_nothing_changed(before: dict[str, Any]) -> None:
    result = compare(before, before)
    assert result.changes == []
    assert result.lines() == ["0 worse, 0 better"]


def test_errors_times_and_fronts(before: dict[str, Any]) -> None:
    after = copy.deepcopy(before)
    experiment = after["experiments"][0]
    experiment["default_on_front"] = False
    experiment["points"][0]["error"]["rmse"] *= 1.5
    experiment["points"][1]["error"]["rmse"] *= 0.5
    experiment["points"][2]["ms"]["median"] *= 2.0
    experiment["points"][3]["ms"]["median"] *= 1.1  # within the noise
    experiment["points"][4]["error"]["rmse"] = None
    result = compare(before, after)
    assert [(c.kind, c.worse) for c in result.changes] == [
        ("default left its front", True), ("rmse", True), ("rmse", False), ("ms", True), ("rmse", True),
    ]  # fmt: skip
    assert result.lines()[-1] == "4 worse, 1 better"
    assert json.loads(json.dumps(result.to_json()))["worse"] == 4


def test_orders_and_extreme_cases(before: dict[str, Any]) -> None:
    after = copy.deepcopy(before)
    after["experiments"][0]["orders"][0].update(met=False, observed=1.2)
    after["experiments"][0]["orders"][2].update(met=True, observed=2.0)
    after["experiments"][0]["extremes"][0].update(ok=False, found="nan")
    result = compare(before, after)
    assert [c.worse for c in result.changes] == [True, False, True]
    text = "\n".join(result.lines())
    assert "worse: toy [a]: order over 1 / n (expected 2) 2.01 -> 1.2" in text
    assert "worse: toy [zero]: extreme case fails (nan)" in text
    assert result.lines()[-1] == "2 worse, 1 better"


def test_other_settings_are_said(before: dict[str, Any]) -> None:
    after = copy.deepcopy(before)
    after.update(quick=False, seed=7)
    after["experiments"][0]["default"] = {"kind": "b", "n": 16}
    text = "\n".join(compare(before, after).lines())
    for word in ("quick was True and is False", "seed was 1 and is 7", "the default was {'kind': 'a'"):
        assert word in text


def test_other_devices_are_not_timed_against_each_other(before: dict[str, Any]) -> None:
    after = copy.deepcopy(before)
    after["device"] = "another"
    for point in after["experiments"][0]["points"]:
        point["ms"]["median"] *= 10.0
    result = compare(before, after)
    assert result.changes == []
    assert "not compared" in result.notes[0]


def test_what_came_and_went_is_said(before: dict[str, Any]) -> None:
    after = copy.deepcopy(before)
    gone = after["experiments"][0]["points"].pop()
    after["experiments"].append({"name": "new", "points": []})
    text = "\n".join(compare(before, after).lines())
    assert "new is only in the second report" in text
    assert f"[kind b, n {gone['knobs']['n']}] is gone" in text
