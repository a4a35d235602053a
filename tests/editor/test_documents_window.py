"""Documents in a real window: what the tabs, the import card, the rename dialog and prefabs do, and that they show."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.report.image import load_png
from engine.report.metrics import is_blank
from tests.support.ui_scripts import run_in_window

pytestmark = pytest.mark.window


@pytest.fixture(scope="module")
def told(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    folder = tmp_path_factory.mktemp("documents")
    _code, seen = run_in_window("documents_window_ui.py", folder)
    return {**seen, "folder": folder}


def test_a_drop_opens_tabs_and_shows_the_card_whose_fix_turns_the_model(told: dict[str, Any]) -> None:
    assert told["card"]
    assert told["heights"] == pytest.approx([1.0, 2.0])


def test_a_changed_source_comes_in_and_leaves_the_users_edits(told: dict[str, Any]) -> None:
    assert told["params"] == [0.125, 0.75]
    assert told["conflicts"] == ["material wood: roughness: yours is 0.125, the source now says 0.9"]
    assert told["history"] == ["Import crate.gltf: Z up → Y up", "Change roughness", "Import crate.gltf again"]


def test_tabs_change_and_files_move_and_come_back(told: dict[str, Any]) -> None:
    assert told["front"] == "boxes.scene.json"
    assert not told["error"]
    assert (told["moved"], told["back"]) == (True, True)


def test_prefabs_are_made_placed_and_applied(told: dict[str, Any]) -> None:
    assert not told["prefab_error"]
    assert told["scales"] == [0.4, 0.4], "the first follows what was done to the second"
    assert told["drawn"] == 3


def test_every_step_shows(told: dict[str, Any]) -> None:
    folder: Path = told["folder"]
    assert told["shots"] == ["dropped", "changed", "rename", "moved", "prefab", "applied"]
    for number, name in enumerate(told["shots"], 1):
        picture = np.asarray(load_png(folder / f"{number:02d}-{name}.png"))
        height, width = picture.shape[:2]
        middle = picture[int(0.3 * height) : int(0.6 * height), int(0.25 * width) : int(0.7 * width)]
        assert not is_blank(middle), name
