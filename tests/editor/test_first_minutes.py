"""The first five minutes of a new user, in a real window: every step does what it should, and shows it."""

from __future__ import annotations

from typing import Any

import pytest

from engine.report.image import load_png
from engine.report.metrics import is_blank
from tests.support.ui_scripts import run_in_window

pytestmark = pytest.mark.window
SHOTS = (
    "welcome", "dropped", "view-normals", "light-turned", "wiped", "shader-broken", "blended", "command-copied",
)  # fmt: skip


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    folder = tmp_path_factory.mktemp("minutes")
    _code, found = run_in_window("first_minutes_ui.py", folder)
    return {**found, "folder": folder}


def test_the_window_opens_with_something_that_moves_and_one_card(seen: dict[str, Any]) -> None:
    assert seen["animated"]
    assert seen["moves"]
    assert seen["card"]
    assert seen["keymap"] == "blender", "a click on the card chooses"
    assert not seen["card_again"]


def test_a_dropped_folder_is_a_model_with_its_import_card(seen: dict[str, Any]) -> None:
    assert seen["dropped"] == "model"
    assert seen["import_card"]
    assert seen["distinct"] > 100


def test_number_keys_go_through_the_debug_views(seen: dict[str, Any]) -> None:
    assert [known for known, _share in seen["views"]] == [True, True]
    assert min(share for _known, share in seen["views"]) > 0.05
    assert seen["lit_again"]


def test_turning_the_light_is_one_entry(seen: dict[str, Any]) -> None:
    assert abs(seen["turned"]) > 20.0
    assert seen["turn_entries"] == ["Turn the light"]


def test_the_state_before_is_held_against_this_one_and_wiped(seen: dict[str, Any]) -> None:
    assert seen["held"], "the key shows the picture from before the light was turned, to the bit"
    assert not seen["let_go"]
    assert seen["split"] == pytest.approx(0.4, abs=0.01)
    assert seen["flip"] > 0.05


def test_a_broken_shader_leaves_the_last_good_picture_and_is_mended(seen: dict[str, Any]) -> None:
    assert "undeclared" in seen["problem"] or "undefined" in seen["problem"]
    assert seen["last_good_stays"]
    assert seen["mended"]


def test_two_clips_are_blended_with_the_pointer(seen: dict[str, Any]) -> None:
    assert seen["blended"] > 0.005


def test_the_copied_command_is_that_of_the_view(seen: dict[str, Any]) -> None:
    assert seen["command_is_it"]
    assert seen["command"].startswith("lucarna render ")
    assert "--set environment_rotation=" in seen["command"]


def test_every_step_has_its_picture(seen: dict[str, Any]) -> None:
    assert tuple(seen["shots"]) == SHOTS
    for number, name in enumerate(SHOTS, 1):
        picture = load_png(seen["folder"] / f"{number:02d}-{name}.png")
        height, width = picture.shape[:2]
        assert not is_blank(picture[height // 5 : height // 2, width // 4 : width // 2]), name
