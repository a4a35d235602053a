"""The keymap: presets, changes over them, conflicts, export and import, keys by their place."""

from __future__ import annotations

from pathlib import Path

import pytest

from editor import physical_keys
from editor.builtin_operations import builtin_operations
from editor.keymap import PRESET_KEYS, Keymap, normal
from editor.preferences import Preferences, load, save
from engine.core.errors import FormatError, InputError


@pytest.fixture
def keymap() -> Keymap:
    return Keymap(builtin_operations(), Preferences())


def use(keymap: Keymap, preset: str) -> dict[str, str]:
    keymap.preferences.keymap = preset
    keymap.apply()
    return keymap.operations.shortcuts()


@pytest.mark.parametrize("preset", PRESET_KEYS)
def test_presets_name_operations_that_there_are_and_keys_once(keymap: Keymap, preset: str) -> None:
    assert set(PRESET_KEYS[preset]) <= {o.id for o in keymap.operations}
    keys = [key for rebound in PRESET_KEYS[preset].values() for key in rebound]
    assert len(keys) == len(set(keys))
    assert [normal(key) for key in keys] == keys
    assert "edit.undo" in use(keymap, preset).values()


def test_what_each_habit_expects(keymap: Keymap) -> None:
    industry = use(keymap, "industry")
    assert [industry[key] for key in "QWERX"] == [
        "tool.select", "tool.move", "tool.rotate", "tool.scale", "tool.local",
    ]  # fmt: skip
    blender = use(keymap, "blender")
    assert [blender[key] for key in "GRSXA"] == [
        "tool.move", "tool.rotate", "tool.scale", "edit.delete", "edit.select-all",
    ]  # fmt: skip
    assert "tool.local" not in blender.values()
    assert use(keymap, "viewer")["H"] == "help.keys"


def test_a_taken_key_is_refused_or_taken_away(keymap: Keymap) -> None:
    assert keymap.conflicts("edit.group", ["Ctrl+D"]) == ["edit.duplicate"]
    with pytest.raises(InputError, match=r"Ctrl\+D is taken by edit\.duplicate"):
        keymap.bind("edit.group", ["Ctrl+D"])
    assert keymap.changes == {}
    keymap.bind("edit.group", ["ctrl+d"], replace=True)
    assert keymap.operations.shortcuts()["Ctrl+D"] == "edit.group"
    assert keymap.keys("edit.duplicate") == ()
    assert keymap.changes == {"edit.group": ["Ctrl+D"], "edit.duplicate": []}


def test_only_the_difference_is_kept_and_by_preset(keymap: Keymap, tmp_path: Path) -> None:
    keymap.bind("edit.group", ["F6"])
    keymap.bind("edit.lock", ["F7"])
    keymap.bind("edit.lock", keymap.preset_keys("edit.lock"))
    assert keymap.preferences.shortcuts == {"industry": {"edit.group": ["F6"]}}
    assert not save(keymap.preferences, tmp_path / "p.json")
    again = Keymap(builtin_operations(), load(tmp_path / "p.json"))
    assert again.keys("edit.group") == ("F6",)
    assert use(again, "blender").get("F6") is None
    use(again, "industry")
    again.reset("edit.group")
    assert again.keys("edit.group") == ("Ctrl+G",)


@pytest.mark.parametrize("text", ["", "Ctrl+", "Hyper+G", "F99", "Ctrl+Ctr+G", "GG"])
def test_what_is_no_key(text: str) -> None:
    with pytest.raises(InputError):
        normal(text)


def test_export_and_import(keymap: Keymap, tmp_path: Path) -> None:
    use(keymap, "blender")
    keymap.bind("edit.group", ["F6"])
    keymap.export_to(tmp_path / "keys.json")
    other = Keymap(builtin_operations(), Preferences())
    assert other.import_from(tmp_path / "keys.json") == []
    assert other.preset == "blender"
    assert other.operations.shortcuts() == keymap.operations.shortcuts()
    (tmp_path / "keys.json").write_text(
        '{"schema": "lucarna.keymap/1", "preset": "viewer", "changes": {"no.such": ["F1"]}}'
    )
    assert other.import_from(tmp_path / "keys.json") == ["no.such"]
    (tmp_path / "keys.json").write_text("[]")
    with pytest.raises(FormatError):
        other.import_from(tmp_path / "keys.json")
    assert other.preset == "viewer"


def test_bare_letters_go_by_their_place_and_control_by_the_letter(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("imgui_bundle")
    from editor.keys import by_place

    def french(place: int, _scancode: int) -> bytes:
        return {"Q": b"a", "W": b"z", "A": b"q", "Z": b"w"}.get(chr(place), chr(place).lower().encode())

    monkeypatch.setattr(physical_keys, "_key_name", lambda: french)
    monkeypatch.setattr(physical_keys, "_known", (-1e9, {}))
    assert [by_place(key) for key in ("W", "Shift+Q", "Ctrl+Z", "F", "F5", "1")] == [
        "Z", "Shift+A", "Ctrl+Z", "F", "F5", "1",
    ]  # fmt: skip


def test_a_layout_without_latin_letters_changes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(physical_keys, "_key_name", lambda: lambda place, _scancode: "й".encode())
    assert all(place == letter for place, letter in physical_keys.read_layout().items())
