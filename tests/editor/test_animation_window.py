"""Animation in a real window: scrubbed, blended, masked by a click on a bone, states edited, and all of it undone."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from engine.report.image import load_png
from engine.report.metrics import is_blank
from tests.support.ui_scripts import run_in_window

pytestmark = pytest.mark.window


@pytest.fixture(scope="module")
def told(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    folder = tmp_path_factory.mktemp("animation")
    _code, seen = run_in_window("animation_window_ui.py", folder)
    return {**seen, "folder": folder}


def test_scrubbing_moves_the_time_and_edits_nothing(told: dict[str, Any]) -> None:
    assert abs(told["scrubbed"] - 0.3) < 0.02
    assert told["scrub_edits"] == 0


def test_a_block_follows_the_drag(told: dict[str, Any]) -> None:
    assert abs(told["moved"] - 0.15) < 0.02


def test_a_click_on_a_bone_masks_its_subtree_with_the_fall_off(told: dict[str, Any]) -> None:
    masked, bones = told["masked"]
    assert 0 < masked < bones
    assert told["fall_off"] == [2]


def test_the_puck_and_a_sample_are_dragged(told: dict[str, Any]) -> None:
    assert 0.3 < told["puck"] < 1.2
    assert told["sample"] < 1.9


def test_states_are_joined_and_put_elsewhere(told: dict[str, Any]) -> None:
    assert told["joined"] == [["idle", "act"], ["any", "idle"]]
    assert told["put"] is not None


def test_undoing_everything_restores_exactly_and_redoing_too(told: dict[str, Any]) -> None:
    assert told["count"][0] == told["count"][1] > 20
    assert told["restored"] == []
    assert told["redone"] == []
    for label in ("Move", "Mask ", "Move sample", "Add transition idle to act", "Add blend", "Add layer draw"):
        assert any(entry.startswith(label) for entry in told["entries"]), label


def test_every_tool_shows_something(told: dict[str, Any]) -> None:
    assert len(told["pictures"]) >= 13
    pictures = {name: np.asarray(load_png(told["folder"] / f"{name}.png")) for name in told["pictures"]}
    for name, picture in pictures.items():
        height, width = picture.shape[:2]
        lower = picture[int(0.75 * height) : int(0.9 * height), int(0.2 * width) : int(0.7 * width)]
        assert not is_blank(lower), name
    assert not np.array_equal(pictures["weights"], pictures["influences"])
    assert not np.array_equal(pictures["timeline"], pictures["dope_sheet"])
