"""The interface's languages: nothing of menus, operations and panels is without a translation; how words are found."""

from __future__ import annotations

import pytest

from editor import strings
from editor.fonts import find_font
from editor.strings import listing
from editor.strings.doors import LABELS, TEXTS


@pytest.fixture
def chinese() -> object:
    strings.set_language("zh")
    yield
    strings.set_language("en")


def test_menus_operations_and_panels_are_all_translated() -> None:
    lacking = listing.missing("zh", listing.required())
    assert not lacking, f"add to editor/strings/zh.toml: {lacking}"


def test_what_the_source_shows_is_found_and_translated() -> None:
    source = listing.written()
    assert len(source) > 400
    assert source["No edits yet"].startswith("editor/panels/history.py:")
    assert "Opening {}" in source, "f-strings become templates"
    assert "{} is there already" in source, "what is filled in first stays; an icon does not"
    lacking = listing.missing("zh", source)
    assert not lacking, f"add to editor/strings/zh.toml: {lacking}"


def test_parameters_with_their_descriptions_are_all_translated() -> None:
    found = listing.declared()
    assert found["perceptual roughness; alpha is its square"] == "blinn_phong.roughness"
    assert {"Ao radius", "Gtao", "scales the environment light", "Haze of the sky", "Year"} - set(found) == {"Year"}
    lacking = listing.missing("zh", found)
    assert not lacking, f"add to editor/strings/zh.toml: {lacking}"


def test_what_the_engine_tells_is_all_translated() -> None:
    found = listing.told()
    assert {"no blended material in the scene", "Ambient occlusion against rays", "Flip green"} <= set(found)
    lacking = listing.missing("zh", found)
    assert not lacking, f"add to editor/strings/zh.toml: {lacking}"


def test_the_table_has_no_empty_entry_and_keeps_its_placeholders() -> None:
    for english, words in strings.load("zh").entries.items():
        assert words.strip(), english
        assert english.count("{}") >= words.count("{}"), english


@pytest.mark.parametrize(
    ("english", "shown"),
    [
        ("Select all", "全选"),
        ("Select all###edit.select-all", "全选###edit.select-all"),
        ("\uf002  Scene###Scene", "\uf002  场景###Scene"),
        ("Undo: Move lid", "撤销：Move lid"),
        ("Show depth\nShow normal", "显示深度\n显示法线"),
        ("##id", "##id"),
        ("木", "木"),
        ("something nobody translated", "something nobody translated"),
    ],
)
def test_how_words_are_found(chinese: object, english: str, shown: str) -> None:
    assert strings.tr(english) == shown


def test_what_is_the_users_own_stays(chinese: object) -> None:
    with strings.verbatim():
        assert strings.tr("Camera") == "Camera"
    assert strings.tr("Camera") == "相机"


def test_an_unknown_language_is_english_and_the_systems_is_known(monkeypatch: pytest.MonkeyPatch) -> None:
    strings.set_language("xx")
    assert (strings.language(), strings.tr("Save")) == ("en", "Save")
    monkeypatch.delenv("LC_MESSAGES", raising=False)
    for said, code in (("zh_CN.UTF-8", "zh"), ("Chinese (Simplified)_China", "zh"), ("de_DE", "en"), ("C", "en")):
        monkeypatch.setenv("LC_ALL", said)
        assert strings.system_language() == code


def test_the_doors_translate_and_go_away_without_a_trace() -> None:
    imgui = pytest.importorskip("imgui_bundle").imgui
    from editor.strings import doors

    before = {name: getattr(imgui, name) for name in (*LABELS, *TEXTS)}
    doors.apply("zh")
    try:
        assert imgui.button is not before["button"]
        assert doors.translated_label("Save") == "保存###Save"
        assert doors.translated_label("Save##here") == "保存##here"
        assert doors.translated_label("no word of ours") == "no word of ours"
        doors.apply("zh")
    finally:
        doors.apply("en")
    assert {name: getattr(imgui, name) for name in (*LABELS, *TEXTS)} == before


def test_the_first_font_of_the_list_is_taken(tmp_path) -> None:
    (tmp_path / "a" / "b").mkdir(parents=True)
    (tmp_path / "a" / "b" / "second.ttc").touch()
    (tmp_path / "first.ttf").touch()
    known = (("none.otf", 0), ("first.ttf", 0), ("second.ttc", 3))
    found = find_font([tmp_path], known)
    assert found is not None
    assert found.path == tmp_path / "first.ttf"
    second = find_font([tmp_path / "a"], known)
    assert second is not None
    assert (second.path.name, second.index) == ("second.ttc", 3)
    assert find_font([tmp_path / "nowhere"], known) is None
