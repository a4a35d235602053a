"""Editing in a real window: a gizmo drag cut off by SIGKILL, and what the next start gives back."""

from __future__ import annotations

import signal
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.report.image import load_png
from engine.report.metrics import is_blank
from tests.support.ui_scripts import run_in_window

pytestmark = pytest.mark.window


def run(folder: Path, what: str) -> tuple[int, dict[str, Any]]:
    """Run a half of the script; (exit code, what it saw). Skips where no window can be."""
    if sys.platform != "linux":
        pytest.skip("kills its process in a way that only Linux displays survive")
    return run_in_window("editing_window_ui.py", folder, what)


@pytest.fixture(scope="module")
def told(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    folder = tmp_path_factory.mktemp("editing")
    code, before = run(folder, "die")
    assert code in {-signal.SIGKILL, 128 + signal.SIGKILL}, "it was to die in the middle of a drag"
    _code, after = run(folder, "restore")
    return {"before": before, "after": after, "folder": folder}


def test_the_drag_moved_the_cube_along_one_axis(told: dict[str, Any]) -> None:
    x, y, z = told["before"]["translation"]
    assert x > 0.2
    assert max(abs(y), abs(z)) < 1e-6


def test_no_edit_is_lost(told: dict[str, Any]) -> None:
    before, after = told["before"], told["after"]
    assert after["asked"] == [3]
    assert after["entries"] == ["Duplicate cube", "Add point light", "Move cube"]
    for key in ("names", "translation", "lights", "drawn"):
        assert after[key] == before[key], key
    assert not after["image_error"]


def test_what_was_restored_can_be_saved(told: dict[str, Any]) -> None:
    assert told["after"]["saved"] == ["stage", "plinth", "cube", "lamp", "cube 2", "Point light"]
    assert not list((told["folder"] / "config" / "recovery").iterdir()), "a good end leaves nothing to ask about"


def test_the_panels_show_the_frame(told: dict[str, Any]) -> None:
    after = told["after"]
    assert "opaque" in after["passes"]
    assert "tone_map" in after["passes"]
    assert after["left_out"], "a scene this small needs not every pass"
    assert "hdr" in after["textures"]
    assert not after["texture_problem"]
    assert after["texture_colours"] > 20


def test_the_window_shows_gizmo_and_history(told: dict[str, Any]) -> None:
    picture = np.asarray(load_png(told["folder"] / "editing.png"))
    height, width = picture.shape[:2]
    assert (width, height) == (1300, 800)
    for name, y, x in (("history", 0.65, 0.08), ("viewport", 0.4, 0.5)):
        cy, cx, h, w = int(y * height), int(x * width), height // 16, width // 16
        assert not is_blank(picture[cy - h : cy + h, cx - w : cx + w]), f"nothing where the {name} should be"
    pure = picture[:, :, :3].astype(int)
    greens = (pure[..., 1] > 150) & (pure[..., 0] < 30) & (pure[..., 2] < 30)
    assert greens[int(0.1 * height) : int(0.65 * height), int(0.2 * width) : int(0.72 * width)].sum() > 30, (
        "the gizmo's green axis"
    )
