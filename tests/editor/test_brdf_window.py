"""The BRDF explorer in a real window."""

from __future__ import annotations

from typing import Any

import pytest

from engine.report.image import load_png
from engine.report.metrics import is_blank
from tests.support.ui_scripts import run_in_window

pytestmark = pytest.mark.window


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    folder = tmp_path_factory.mktemp("brdf")
    _, found = run_in_window("brdf_window_ui.py", folder)
    return {**found, "folder": folder}


def test_it_follows_the_selection_and_its_values(seen: dict[str, Any]) -> None:
    assert seen["error"] == ""
    assert seen["nothing"], "nothing is selected"
    assert seen["parts"] == ["diffuse", "specular", "coat"]
    assert seen["kept"]
    assert seen["flatter"]


def test_a_mismatched_pair_is_told(seen: dict[str, Any]) -> None:
    assert len(seen["pairs"]) == 1
    assert "Smith for Beckmann" in seen["pairs"][0]


def test_it_stays_with_a_pinned_material(seen: dict[str, Any]) -> None:
    assert seen["pinned"]
    assert not is_blank(load_png(seen["folder"] / "brdf.png"))
