"""The window left alone: it draws nothing and costs next to nothing, and still sees what happens. In a real window."""

from __future__ import annotations

from typing import Any

import pytest

from tests.support.ui_scripts import run_in_window

pytestmark = pytest.mark.window


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    return run_in_window("idle_window_ui.py", tmp_path_factory.mktemp("idle"))[1]


def test_left_alone_it_draws_nothing(seen: dict[str, Any]) -> None:
    assert seen["alone"][0] == 0
    assert seen["after_reload"] == 0


def test_left_alone_it_needs_next_to_no_processor_time(seen: dict[str, Any]) -> None:
    assert seen["alone"][1] < 0.05, "share of one core; a window that draws needs twenty times as much"


def test_files_that_change_wake_it(seen: dict[str, Any]) -> None:
    assert seen["reloaded"], "a material in use"
    assert seen["text_followed"], "a text that is open in the shader editor"


def test_frames_that_are_gathered_come_to_an_end(seen: dict[str, Any]) -> None:
    assert seen["settles"]
    assert seen["gathered"] >= 8, "two rounds of four places in a pixel"
    assert seen["after_settling"] == 0


def test_an_autosave_comes_in_time(seen: dict[str, Any]) -> None:
    assert seen["kept"]


def test_what_plays_is_drawn_and_rests_with_its_window(seen: dict[str, Any]) -> None:
    assert seen["plays"]
    frames, played = seen["away"]
    assert played == 0.0, "minimised: the clock stands"
    assert frames <= 4
    assert seen["behind_goes_on"]
    assert seen["behind"] <= 25, "ten a second and those that a word of the test brings, in 1.5 s"
    assert seen["stopped"] <= 8
    assert seen["plays_again"]


def test_an_interrupt_ends_it_and_loses_no_edit(seen: dict[str, Any]) -> None:
    assert seen["interrupted"]
    assert seen["recoveries"] == 1
