"""Texture viewer, frame graph and asset report in a real window with an interface of twice the size: that they show."""

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
    folder = tmp_path_factory.mktemp("panels")
    _code, seen = run_in_window("panels_window_ui.py", folder, "--only", "textures,graph,assets", "--scale", "2")
    return {**seen, "folder": folder}


def test_every_source_of_the_texture_viewer_is_read(told: dict[str, Any]) -> None:
    for name in ("target-hdr", "target-depth", "target-color", "renderer-environment", "renderer-dfg-table"):
        assert f"texture-{name}" in told["shots"]
    assert told["unread"] == []


def test_every_step_shows(told: dict[str, Any]) -> None:
    folder: Path = told["folder"]
    for number, name in enumerate(told["shots"], 1):
        picture = np.asarray(load_png(folder / f"{number:02d}-{name}.png"))
        height, width = picture.shape[:2]
        assert not is_blank(picture[int(0.1 * height) : int(0.6 * height), : int(0.6 * width)]), name


def test_a_click_on_a_pass_shows_what_it_writes(told: dict[str, Any]) -> None:
    assert told["clicked"] == "hdr"
