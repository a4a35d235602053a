"""Materials in a real window: declarations as widgets, several at once, copies, the preview, thumbnails."""

from __future__ import annotations

import itertools
from typing import Any

import pytest

from engine.report.image import load_png
from engine.report.metrics import is_blank
from tests.support.ui_scripts import run_in_window

pytestmark = pytest.mark.window


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    folder = tmp_path_factory.mktemp("materials")
    _, found = run_in_window("materials_ui.py", folder)
    return {**found, "folder": folder}


def test_parameters_stand_in_their_groups_and_show_by_their_conditions(seen: dict[str, Any]) -> None:
    assert seen["grouped"]
    assert seen["hidden_while_dry"]
    assert seen["shown_when_wet"]


def test_a_drag_with_two_selected_edits_both_as_one_entry(seen: dict[str, Any]) -> None:
    assert seen["several"] == [True, 1, "Roughness of 2 materials"]
    assert seen["several_undone"]


def test_of_values_that_differ_only_the_edited_component_changes(seen: dict[str, Any]) -> None:
    assert seen["one_component"] == [True, True, True]


def test_copy_paste_and_reset_of_a_whole_material(seen: dict[str, Any]) -> None:
    assert seen["pasted"]
    assert seen["reset"] == [[1.0, 1.0, 1.0, 1.0], 1.0]


def test_the_preview_turns_is_remembered_follows_edits_and_rests(seen: dict[str, Any]) -> None:
    assert seen["idle_preview"] == 0, "nothing changed, nothing drawn"
    assert seen["gestures"] == [True, True], "Shift + right drag turns the light, a drag the camera"
    assert seen["remembered"] == ["ball", True]
    assert seen["edit_reaches_it"]


def test_thumbnails_come_and_what_is_broken_says_why(seen: dict[str, Any]) -> None:
    thumbnails = seen["thumbnails"]
    for name in ("boxes.red.material.toml", "boxes.scene.json", "paint.png"):
        assert thumbnails[name] == ["ready", ""], name
    state, why = thumbnails["broken.glb"]
    assert state == "broken"
    assert "broken.glb" in why
    assert "GLB" in why


def test_a_parameter_of_one_object_alone(seen: dict[str, Any]) -> None:
    assert seen["own"] == [["roughness"], True, True], "the material keeps its own"
    assert seen["own_entries"] == ["Roughness of red on cube"] * 2
    assert seen["own_seen"]
    assert seen["own_saved"]
    assert seen["own_reset"] == [{}, True]
    assert seen["own_undone"]


def test_hot_reload_reaches_preview_and_thumbnails(seen: dict[str, Any]) -> None:
    assert seen["reload_preview"]
    assert seen["reload_thumbnail"]
    assert seen["broken_badge"]
    assert seen["broken_keeps"], "the last good picture, bit for bit"
    assert seen["mended"]


def test_everything_is_undone(seen: dict[str, Any]) -> None:
    assert seen["undone"]
    assert seen["clean"]


def test_the_previews_differ_from_shape_to_shape(seen: dict[str, Any]) -> None:
    names = [name for name in seen["shots"] if "-preview-" in name]
    assert len(names) == 7
    pictures = [load_png(seen["folder"] / name) for name in names]
    height, width = pictures[0].shape[:2]
    panel = (slice(int(height * 0.79), int(height * 0.94)), slice(int(width * 0.5), int(width * 0.74)))
    for one, other in itertools.pairwise(pictures[:4]):
        assert not is_blank(one[panel])
        assert (one[panel] != other[panel]).any()
