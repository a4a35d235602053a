"""The editor in a real window with the real renderer, under a display or a virtual one."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.assets.material_toml import read_material
from engine.assets.scene_json import read_scene
from engine.report.image import load_png
from engine.report.metrics import is_blank
from tests.support.ui_scripts import on_display, run_in_window

pytestmark = pytest.mark.window
HERE = Path(__file__).parent


def environment(folder: Path) -> dict[str, str]:
    return {**os.environ, "LUCARNA_CACHE": str(folder / "cache"), "LUCARNA_CONFIG": str(folder / "config")}


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    folder = tmp_path_factory.mktemp("window")
    _, found = run_in_window("window_ui.py", folder)
    return {**found, "folder": folder}


def test_the_scene_is_drawn(seen: dict[str, Any]) -> None:
    assert seen["distinct_colours"] > 20
    assert seen["picked"] == "cube"


def test_nothing_is_rendered_while_nothing_changes(seen: dict[str, Any]) -> None:
    assert seen["idle_renders"] == 0


def test_a_material_slider_changes_the_picture_and_undo_restores_it(seen: dict[str, Any]) -> None:
    assert seen["dragged"] > 0.01
    assert seen["entries"] == ["Metallic of red"]
    assert seen["undone"] == 0.0


def test_hiding_and_moving_change_the_picture(seen: dict[str, Any]) -> None:
    assert seen["hidden"] > 0.01
    assert seen["moved"] > 0.01


def test_saving_writes_scene_and_material_in_place(seen: dict[str, Any]) -> None:
    assert seen["saved"] is True
    assert seen["dirty"] is False
    scene = read_scene(seen["folder"] / "boxes.scene.json")
    assert scene.nodes[2].translation == (0.0, 0.4, 0.0)
    assert read_material(seen["folder"] / "boxes.red.material.toml").params["metallic"] > 0.1
    assert read_material(seen["folder"] / "boxes.grey.material.toml").params["metallic"] == 0.0


def test_a_dropped_file_opens(seen: dict[str, Any]) -> None:
    if not seen["can_drop"]:
        pytest.skip("the window library takes no drops")
    assert seen["dropped"]


def test_the_window_shows_all_panels(seen: dict[str, Any]) -> None:
    picture = load_png(seen["folder"] / "window.png")
    height, width = picture.shape[:2]
    assert (width, height) == (1100, 700)
    for name, y, x in (("tree", 0.15, 0.1), ("viewport", 0.4, 0.5), ("inspector", 0.3, 0.85), ("log", 0.85, 0.35)):
        cy, cx, h, w = int(y * height), int(x * width), height // 14, width // 14
        assert not is_blank(picture[cy - h : cy + h, cx - w : cx + w]), f"nothing where the {name} should be"


def test_the_command_writes_a_screenshot(tmp_path: Path) -> None:
    sys.path.insert(0, str(HERE / "support"))
    from small_scene import write_small_scene

    scene = write_small_scene(tmp_path / "scene")
    out = tmp_path / "shot.png"
    words = ["edit", str(scene), "--screenshot", str(out), "--frames", "4", "--size", "900x600", "--select", "cube"]
    command = on_display([sys.executable, "-m", "importers.cli", *words])
    done = subprocess.run(
        command,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
        env=environment(tmp_path),
        cwd=HERE.parents[1],
    )
    assert done.returncode == 0, done.stderr
    picture = load_png(out)
    assert picture.shape[:2] == (600, 900)
    centre = np.asarray(picture[200:350, 350:550], float)
    assert centre.std() > 3.0, "the viewport is not flat"
    assert not (tmp_path / "config" / "editor.json").exists(), "a screenshot leaves the user's settings alone"
    bad = subprocess.run(
        [*command[: command.index("edit")], "edit", str(tmp_path / "no.glb")],
        capture_output=True, text=True, timeout=120, check=False, cwd=HERE.parents[1],
    )  # fmt: skip
    assert bad.returncode == 1
    assert "no such file" in bad.stderr
    assert "Traceback" not in bad.stderr
