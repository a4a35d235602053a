"""A real window: pictures in the history, an instance's values, a character that plays, an import card that folds."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from engine.report.image import load_png
from engine.report.metrics import is_blank
from tests.support.ui_scripts import run_in_window

pytestmark = pytest.mark.window

#: what the card covers of the picture at most, with what a row of pixels more or less is
THIRD = 1.0 / 3.0 + 0.005


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    folder = tmp_path_factory.mktemp("instances")
    return {**run_in_window("instances_window_ui.py", folder, "1280x720")[1], "folder": folder}


def test_every_entry_has_the_picture_after_it_and_a_drag_has_one(seen: dict[str, Any]) -> None:
    opened, shrunk, dragged, brighter = seen["pictures"]
    assert min(opened, shrunk, dragged) > 10.0
    assert len({round(p, 2) for p in (opened, shrunk, dragged)}) == 3, "each shows its own state"
    assert brighter > 1.3 * dragged, "the exposure that was set last"


def test_a_click_goes_there_and_the_pictures_stay(seen: dict[str, Any]) -> None:
    assert seen["at"] == 1
    assert seen["same"]


def test_a_value_is_given_back_by_its_button(seen: dict[str, Any]) -> None:
    assert seen["reverted"] == [0.9, 0.4, 0.0], "as the prefab was made"
    assert seen["label"] == "Revert place of cube"


def test_placed_characters_play(seen: dict[str, Any]) -> None:
    assert seen["clips"] == ["figure/walk", "figure/run", "figure/wave"]
    assert 0.001 < seen["moved"] < 0.2, "they, and nothing else"


def test_the_import_card_covers_a_third_at_most_and_folds(seen: dict[str, Any]) -> None:
    assert 0.1 < seen["covers"] <= THIRD
    assert seen["line"] < 0.4 * seen["whole"], "a selection folds it"
    assert seen["by_hand"] > 2.0 * seen["line"], "the menu opens it, and it stays when something is selected"
    assert seen["by_hand_at_2"] <= THIRD
    assert seen["line_at_2"] <= THIRD


def test_the_window_shows_them(seen: dict[str, Any]) -> None:
    assert len(seen["shots"]) == 11
    for number, name in enumerate(seen["shots"], 1):
        picture = np.asarray(load_png(seen["folder"] / f"{number:02d}-{name}.png"))
        assert picture.shape[:2] == (720, 1280)
        assert not is_blank(picture[150:480, 250:900]), f"no picture in {name}"
