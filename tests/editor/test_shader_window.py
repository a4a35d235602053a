"""Shaders edited, broken in six ways and mended in a real window: the picture is never lost, the place is right."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from engine.report.image import load_png
from engine.report.metrics import is_blank
from tests.support.ui_scripts import run_in_window

pytestmark = pytest.mark.window

#: mistake -> (place named, words of the message)
EXPECTED = {
    "syntax": (r"surface.frag:", "syntax error"),
    "type": (r"surface.frag:", "type"),
    "missing include": ("surface.frag:9:10", "did you mean 'lib/view.glsl'?"),
    "include cycle": ("brdf.glsl:3:10", "closes a cycle"),
    "unknown key": ("surface.effect.toml:3:1", "did you mean 'doc'?"),
    "not finite": (r"surface.frag:", "the change begins at line"),
}


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    folder = tmp_path_factory.mktemp("shaders")
    _, found = run_in_window("shader_ui.py", folder)
    return {**found, "folder": folder}


def test_a_drag_of_a_slider_is_one_entry_and_shows(seen: dict[str, Any]) -> None:
    entries, many_edits, label = seen["dragged"]
    assert (entries, label) == (1, "Roughness of walnut")
    assert many_edits, "of many frames"
    assert seen["drag_shows"]


def test_the_effect_of_the_selected_material_opens(seen: dict[str, Any]) -> None:
    assert seen["opened"] == ["surface.effect.toml", "surface.frag"]


def test_saved_text_is_new_pixels_and_unsaved_text_is_not(seen: dict[str, Any]) -> None:
    assert seen["unsaved_changes_nothing"]
    assert seen["edited"] > 0.1
    assert seen["restored"], "the old text gives the old picture, bit for bit"


@pytest.mark.parametrize("mistake", list(EXPECTED))
def test_a_mistake_keeps_the_last_good_picture_and_names_its_line(seen: dict[str, Any], mistake: str) -> None:
    said = seen["mistakes"][mistake]
    place, words = EXPECTED[mistake]
    assert said["same_picture"], "not the last good picture"
    assert said["place"].startswith(place), said
    assert words in said["message"]
    assert said["badge"].startswith("running previous version: ")
    assert said["opened"] == said["place"].split(":")[0], "next error opens the file"
    assert said["mended"], "the badge goes when it is mended"
    assert said["same_after"]


def test_the_line_named_is_that_of_the_mistake(seen: dict[str, Any]) -> None:
    text = (Path(__file__).resolve().parents[2] / "shaders/effects/surface.frag").read_text(encoding="utf-8")
    lines = text.splitlines()
    for mistake, words in (("syntax", "vec4(sanitise(color), 1.0)"), ("type", "vec3 color = shade(")):
        line = next(i for i, code in enumerate(lines, 1) if words in code)
        assert seen["mistakes"][mistake]["place"].split(":")[1] == str(line)


def test_typing_is_the_texts_and_not_the_scenes(seen: dict[str, Any]) -> None:
    starts, dirty, revision = seen["typed"]
    assert starts
    assert dirty
    same, still_dirty, revision_after = seen["typing_undone"]
    assert same, "one Ctrl+Z in the text undoes what was typed in one go"
    assert seen["typing_redone"]
    assert not still_dirty
    assert revision_after == revision, "and nothing of the scene"
    written, text_dirty, scene_dirty = seen["saved_by_key"]
    assert written
    assert not text_dirty
    assert scene_dirty, "Ctrl+S in the text does not save the scene"


def test_completion_by_keys(seen: dict[str, Any]) -> None:
    assert seen["completion_open"]
    assert seen["narrowed"], "what is typed while the list is open goes into the text"
    assert seen["completed"]


def test_replacing_all_is_one_step_of_the_texts_undo(seen: dict[str, Any]) -> None:
    assert seen["replaced"]
    assert seen["replacing_undone"]


def test_changes_on_both_sides_overwrite_nothing(seen: dict[str, Any]) -> None:
    assert seen["conflict"]
    assert seen["theirs_kept"], "saving in a conflict wrote the file"
    assert seen["still_a_conflict"], "looking at the difference decides nothing"
    assert seen["took"] == [True, False, False]


def test_undoing_everything_gives_the_first_picture(seen: dict[str, Any]) -> None:
    assert seen["undone"]
    assert seen["clean"]


def test_what_never_compiled_is_magenta_and_says_why(seen: dict[str, Any]) -> None:
    magenta, badge, place = seen["never"]
    assert magenta
    assert badge.startswith("drawn in magenta: bad.frag:2:")
    assert place.startswith("bad.frag:2:")


def test_there_is_a_picture_of_the_window_after_each_step(seen: dict[str, Any]) -> None:
    mistakes = [f"{state}-{name.replace(' ', '-')}" for name in EXPECTED for state in ("broken", "mended")]
    steps = ["opened", "slider-dragged", "text-opened", "text-edited", *mistakes, "completion", "find-and-replace",
             "conflict", "difference-side-by-side", "difference-unified", "all-undone", "never-compiled"]  # fmt: skip
    assert seen["shots"] == [f"{number:02d}-{step}.png" for number, step in enumerate(steps, 1)]
    pictures = [load_png(seen["folder"] / name) for name in seen["shots"]]
    height, width = pictures[0].shape[:2]
    viewport = (slice(height // 5, height * 3 // 5), slice(width // 5, width * 2 // 5))
    for name, picture in zip(seen["shots"], pictures, strict=True):
        assert not is_blank(picture[viewport]), name
    text = pictures[2][height // 6 : height // 2, width // 2 : int(width * 0.74)]
    assert not is_blank(text), "the text shows beside the picture"
