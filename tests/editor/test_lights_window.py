"""Lights in a real window: placed, tuned, profiled, scattered, drawn by every path, undone, redone, saved."""

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
    folder = tmp_path_factory.mktemp("lights")
    _code, seen = run_in_window("lights_window_ui.py", folder)
    return {**seen, "folder": folder}


def test_lights_are_placed_and_tuned(told: dict[str, Any]) -> None:
    assert told["placed"] == 5
    assert told["placing_shows"] > 1.0
    assert told["brighter"] > 1.2


def test_a_profile_is_chosen_and_followed(told: dict[str, Any]) -> None:
    assert told["profile"] == "lamp.ies"
    assert told["profile_shows"] > 0.1
    assert "lamp.ies:7" in told["badge"]
    assert told["kept"] == 0.0, "a broken file changes nothing"
    assert told["mended_shows"] > 0.01


def test_many_at_once(told: dict[str, Any]) -> None:
    assert told["in_box"]
    assert told["duration"] == 16.0
    assert told["drifted"] > 0.2
    assert (told["ring"], told["lights"]) == (6, 24)


def test_the_toolbar_switches_paths_of_one_picture(told: dict[str, Any]) -> None:
    assert told["paths"] == ["forward", "deferred", "tiled-deferred", "forward-plus"]
    assert told["paths_differ"] <= 1
    assert "23 local lights" in told["auto"]


def test_keys_show_debug_views_with_legends(told: dict[str, Any]) -> None:
    views = told["views"]
    assert len(views) == 18
    assert {name for name, (heading, _) in views.items() if heading} == {
        "depth", "overdraw", "texel_density", "light_tiles"
    }  # fmt: skip
    assert all(spread > 1.0 for _, spread in views.values()), "none of them is blank"


def test_undo_restores_every_bit_and_redo_is_saved(told: dict[str, Any]) -> None:
    assert told["entries"][-4:] == ["Change intensity", "Change profile", "Scatter 12 lights", "Ring of 6"]
    assert len(told["entries"]) == 10
    assert told["restored"] == []
    assert told["drifting_after_undo"] == 0
    assert told["again"] == 24
    assert told["saved"] == {"lights": 24, "clips": ["lit.drift.lanim"], "moves": 12}


def test_the_window_shows_the_legend(told: dict[str, Any]) -> None:
    picture = np.asarray(load_png(told["folder"] / "lights.png")).astype(int)
    assert not is_blank(picture.astype(np.uint8))
    yellow = (np.abs(picture[..., :3] - (253, 231, 37)) < 8).all(axis=-1)
    assert yellow[picture.shape[0] // 3 :, : picture.shape[1] // 2].sum() > 20, "the near end of the ramp"
