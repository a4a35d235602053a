"""Materials edited one or many at a time: shared parameters, copies as text, resets; each one entry of the history."""

from __future__ import annotations

from pathlib import Path

import pytest

from editor import material_editing as editing
from editor.document import Document
from editor.host import Resolved
from editor.preferences import Preferences
from editor.session import Session
from engine.assets.material_toml import parse_material
from tests.editor.support.fake_engine import FakeHost


@pytest.fixture
def session() -> Session:
    host = FakeHost()
    session = Session(host, Preferences())
    session.save_preferences = False
    runtime = host.open_runtime(None, Path("thing.scene.json"))
    session.document = Document(Resolved(Path("thing.glb"), Path("thing.scene.json")), runtime)
    return session


def params(session: Session, material: int) -> dict[str, object]:
    assert session.document is not None
    return dict(session.document.runtime.residency.records[material].asset.params)


def entries(session: Session) -> list[str]:
    assert session.document is not None
    return [entry.describe() for entry in session.document.history.entries]


def test_several_share_what_all_of_them_have_and_differences_are_known(session: Session) -> None:
    assert session.document is not None
    assert editing.materials_of(session.document, [1, 2]) == [0, 1]
    shared = {s.param.name: s for s in editing.shared_params(session.document.runtime.residency, [0, 1])}
    assert shared["roughness"].values == (0.4, 1.0)
    assert shared["roughness"].mixed
    assert shared["roughness"].changed
    assert not shared["metallic"].mixed
    assert not shared["metallic"].changed


def test_an_edit_of_several_is_one_entry_and_a_drag_of_them_too(session: Session) -> None:
    for value in (0.1, 0.2, 0.3):
        editing.set_param(session, [0, 1], "roughness", value)
    assert [params(session, m)["roughness"] for m in (0, 1)] == [0.3, 0.3]
    assert entries(session) == ["Roughness of 2 materials"]
    session.undo()
    assert params(session, 0)["roughness"] == 0.4
    assert params(session, 1).get("roughness", 1.0) == 1.0


def test_reset_one_and_all(session: Session) -> None:
    editing.set_param(session, [0, 1], "metallic", 0.0)
    editing.reset(session, [0, 1], ["metallic"])
    assert params(session, 1)["metallic"] == 1.0
    assert params(session, 0)["roughness"] == 0.4, "others stay"
    editing.set_param(session, [0], "metallic", 0.5)
    editing.reset(session, [0])
    assert (params(session, 0)["roughness"], params(session, 0)["metallic"]) == (1.0, 1.0)
    assert entries(session)[-1] == "Reset paint"
    session.undo()
    assert (params(session, 0)["roughness"], params(session, 0)["metallic"]) == (0.4, 0.5)
    editing.reset(session, [1])
    before = len(entries(session))
    editing.reset(session, [1])
    assert len(entries(session)) == before, "nothing to reset is no entry"


def test_one_parameter_goes_through_the_clipboard_as_toml(session: Session) -> None:
    text = editing.copy_text(session, 0, "roughness")
    assert text == "roughness = 0.4\n"
    editing.paste(session, [1], text)
    assert params(session, 1)["roughness"] == 0.4
    assert entries(session) == ["Paste Roughness of steel"]
    editing.paste(session, [1], "[params]\nbase_color = [1, 0, 0, 1]\n")
    assert params(session, 1)["base_color"] == (1.0, 0.0, 0.0, 1.0)


def test_a_whole_copy_is_a_material_file(session: Session) -> None:
    said = parse_material(editing.copy_text(session, 0), "clipboard")
    assert (said.name, said.params["roughness"], said.params["metallic"]) == ("paint", 0.4, 1.0)
    assert said.textures["base_color_map"].path == "paint.dds"


@pytest.mark.parametrize("text", ["", "hello world", "a = { b = 1 }", 'schema = "lucarna.material/1"\n'])
def test_what_is_no_copy_changes_nothing_and_is_told(session: Session, text: str) -> None:
    editing.paste(session, [0], text)
    assert not entries(session)
    assert "clipboard holds no material" in session.ui.notice


def test_what_the_effect_does_not_take_is_told_and_the_rest_is_taken(session: Session) -> None:
    editing.paste(session, [0], "roughness = 0.7\nwetness = 1.0\nmetallic = 7.0\n")
    assert params(session, 0)["roughness"] == 0.7
    assert session.ui.notice == "Not taken by effect surface: wetness, metallic"
