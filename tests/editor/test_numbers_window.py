"""The check of the numbers, the frame graph and the report in a real window, on a project whose shader writes NaN."""

from __future__ import annotations

from typing import Any

import pytest

from engine.report.image import load_png
from engine.report.metrics import is_blank
from tests.support.ui_scripts import run_in_window

pytestmark = pytest.mark.window


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    folder = tmp_path_factory.mktemp("numbers")
    _, found = run_in_window("numbers_window_ui.py", folder)
    return {**found, "folder": folder}


def test_the_pass_that_made_the_first_is_named(seen: dict[str, Any]) -> None:
    assert (seen["pass"], seen["texture"], seen["nan"]) == ("opaque", "hdr", 16)
    assert seen["summary"] == "16 NaN/Inf, first in opaque"


def test_off_it_is_not_there_and_on_it_draws_nothing_by_itself(seen: dict[str, Any]) -> None:
    assert not seen["before"]
    assert seen["idle_renders"] == 0


def test_the_view_marks_exactly_those_pixels(seen: dict[str, Any]) -> None:
    assert seen["marked"] == 16


def test_a_click_goes_to_the_texel_and_selects_what_lies_under_it(seen: dict[str, Any]) -> None:
    assert seen["shown"] == "hdr"
    assert seen["texel"]
    assert seen["is_nan"]
    assert seen["selected"] == "plinth"


def test_what_is_left_out_can_be_measured(seen: dict[str, Any]) -> None:
    """Each pass that is left out has run in the forced frames, and has a time."""
    assert {"sky", "transparent", "resolve"} <= set(seen["left_out"])
    assert min(seen["costs"]) >= 0.0
    assert max(seen["costs"]) > 0.0


def test_the_graph_sleeps_and_follows_what_changes(seen: dict[str, Any]) -> None:
    assert seen["idle_graph"] == 0
    assert seen["live"] == 1


def test_the_report_runs_between_frames_and_can_be_called_off(seen: dict[str, Any]) -> None:
    assert seen["called_off"]
    assert seen["steps"] > 5
    assert seen["points"] >= 4
    assert seen["plotted"] == seen["points"]
    assert seen["now"]
    assert len(seen["answers"]) == 3
    assert seen["idle_report"] == 0
    picture = load_png(seen["folder"] / "numbers.png")
    height, width = picture.shape[:2]
    assert not is_blank(picture[height // 6 : height // 2, width * 2 // 5 : width * 2 // 3]), "no plot"


def test_what_the_report_advises_is_set_and_taken_back(seen: dict[str, Any]) -> None:
    assert seen["applied"] == 4
    assert seen["label"] == "Apply samples 4"
    assert not seen["dirty"], "how it is looked at is no change of the document"
    assert seen["taken_back"]
