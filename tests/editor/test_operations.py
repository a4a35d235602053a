"""The registry of operations and the palette's matching."""

from __future__ import annotations

import pytest
from fake_engine import FakeHost

from editor.builtin_operations import builtin_operations
from editor.operations import Operation, Operations, match_score
from editor.session import Session
from engine.core.errors import InputError, UsageError


def test_ids_and_shortcuts_are_unique() -> None:
    operations = Operations()
    operations.add(Operation("a", "A", lambda s: None, shortcuts=("Ctrl+A",)))
    with pytest.raises(AssertionError, match="twice"):
        operations.add(Operation("a", "B", lambda s: None))
    with pytest.raises(AssertionError, match=r"Ctrl\+A is taken by a"):
        operations.add(Operation("b", "B", lambda s: None, shortcuts=("Ctrl+A",)))


def test_the_shortcuts_artists_expect() -> None:
    keys = builtin_operations().shortcuts()
    for key, operation in {
        "Ctrl+Z": "edit.undo", "Ctrl+Y": "edit.redo", "Ctrl+Shift+Z": "edit.redo", "Ctrl+O": "file.open",
        "Ctrl+S": "file.save", "F": "view.frame", "A": "view.frame-all", "Home": "view.frame-all", "F12":
        "file.screenshot", "Ctrl+Shift+P": "help.palette", "Space": "play.toggle", "H": "edit.hide",
    }.items():  # fmt: skip
        assert keys[key] == operation


def test_every_shortcut_is_a_key_chord() -> None:
    pytest.importorskip("imgui_bundle")
    from editor.keys import chord

    chords = [chord(key) for key in builtin_operations().shortcuts()]
    assert len(set(chords)) == len(chords)


def test_an_unknown_operation_is_an_error_and_a_disabled_one_is_not_run() -> None:
    session = Session(FakeHost())
    with pytest.raises(UsageError):
        builtin_operations().run("view.nowhere", session)
    assert not builtin_operations().run("view.frame-all", session)


def test_what_a_key_asks_and_is_refused_is_in_the_error_bar() -> None:
    session = Session(FakeHost())
    operations = builtin_operations()

    def refuse(session: Session) -> None:
        raise InputError("it is gone")

    operations.add(Operation("test.refuse", "Refuse", refuse))
    assert not operations.attempt("test.refuse", session)
    assert "it is gone" in session.ui.error_bar
    assert session.failure is not None


@pytest.mark.parametrize("pattern", ["frame all", "FRAME", "fa", "view frame", ""])
def test_what_matches(pattern: str) -> None:
    assert match_score(pattern, "View Frame all") is not None


@pytest.mark.parametrize("pattern", ["frame allx", "xf", "llf"])
def test_what_does_not(pattern: str) -> None:
    assert match_score(pattern, "View Frame all") is None


def test_whole_words_come_before_scattered_letters() -> None:
    word, inside, scattered = (match_score("re", text) for text in ("Edit Redo", "File Screenshot", "Reset"))
    assert word is not None
    assert inside is not None
    assert scattered is not None
    assert word < inside
    assert scattered < inside, "the start of a word"
    assert (match_score("undo", "Edit Undo") or 0) < (match_score("undo", "up noted often") or 0)
