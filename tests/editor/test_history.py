"""Commands and their history: undo, redo, one entry per gesture, what counts as unsaved."""

from __future__ import annotations

from typing import Any

import pytest

from editor.commands.command import Command
from editor.commands.history import History


class Store(dict[tuple[str, int], Any]):
    """A table of one: what commands write to."""

    def write(self, command: Command) -> None:
        for row, value in zip(command.rows, command.after, strict=True):
            self[command.column, row] = value


def step(before: Any, after: Any, column: str = "x", row: int = 0) -> Command:
    return Command("nodes", column, (row,), (before,), (after,))


@pytest.fixture
def store() -> Store:
    return Store({("x", 0): 0, ("x", 1): 0, ("y", 0): 0})


@pytest.fixture
def history(store: Store) -> History:
    return History(store.write)


def test_undo_and_redo_walk_back_and_forth(store: Store, history: History) -> None:
    history.do(step(0, 1))
    history.do(step(1, 2))
    assert store["x", 0] == 2
    assert history.undo() is not None
    assert store["x", 0] == 1
    history.undo()
    assert store["x", 0] == 0
    assert history.undo() is None
    history.redo()
    history.redo()
    assert store["x", 0] == 2
    assert history.redo() is None


def test_a_drag_is_one_entry(store: Store, history: History) -> None:
    for value in range(1, 300):
        history.do(step(value - 1, value), gesture="drag")
    assert len(history.entries) == 1
    history.undo()
    assert store["x", 0] == 0
    history.redo()
    assert store["x", 0] == 299


def test_two_drags_of_the_same_slider_are_two_entries(store: Store, history: History) -> None:
    history.do(step(0, 1), gesture="drag")
    history.end_gesture()
    history.do(step(1, 2), gesture="drag")
    assert len(history.entries) == 2
    history.undo()
    assert store["x", 0] == 1


@pytest.mark.parametrize("other", [step(0, 5, column="y"), step(0, 5, row=1)])
def test_another_target_in_the_same_gesture_is_an_entry_of_its_own(history: History, other: Command) -> None:
    history.do(step(0, 1), gesture="drag")
    history.do(other, gesture="drag")
    assert len(history.entries) == 2


def test_edits_without_a_gesture_never_merge(history: History) -> None:
    history.do(step(0, 1))
    history.do(step(1, 2))
    assert len(history.entries) == 2


def test_a_gesture_that_ends_where_it_began_leaves_nothing(history: History) -> None:
    history.do(step(0, 1), gesture="drag")
    history.do(step(1, 0), gesture="drag")
    history.end_gesture()
    assert history.entries == ()
    assert not history.dirty


def test_what_changes_nothing_is_not_recorded(history: History) -> None:
    history.do(step(3, 3))
    assert history.entries == ()
    assert history.revision == 0


def test_a_new_edit_cuts_off_what_was_undone(store: Store, history: History) -> None:
    history.do(step(0, 1))
    history.undo()
    history.do(step(0, 7))
    assert history.redo() is None
    assert store["x", 0] == 7


def test_dirty_follows_the_saved_place(history: History) -> None:
    assert not history.dirty
    history.do(step(0, 1))
    assert history.dirty
    history.mark_saved()
    assert not history.dirty
    history.undo()
    assert history.dirty
    history.redo()
    assert not history.dirty
    history.undo()
    history.do(step(0, 9))  # the saved state can no longer be reached
    history.undo()
    assert history.dirty


def test_a_saved_gesture_that_goes_on_is_dirty(history: History) -> None:
    history.do(step(0, 1), gesture="drag")
    history.mark_saved()
    history.do(step(1, 2), gesture="drag")
    assert history.dirty


def test_the_revision_grows_with_every_write(history: History) -> None:
    seen = [history.revision]
    for action in (lambda: history.do(step(0, 1)), history.undo, history.redo):
        action()
        seen.append(history.revision)
    assert seen == sorted(set(seen))


def test_a_write_that_fails_leaves_the_history_as_it_was() -> None:
    def refuse(command: Command) -> None:
        raise ValueError(command.column)

    history = History(refuse)
    with pytest.raises(ValueError, match="x"):
        history.do(step(0, 1))
    assert history.entries == ()
    assert history.revision == 0


def test_the_history_is_bounded(history: History) -> None:
    small = History(lambda _command: None, limit=10)
    for value in range(50):
        small.do(step(value, value + 1))
    assert len(small.entries) == 10
    assert small.dirty


def test_labels_say_what_undo_would_take_back(history: History) -> None:
    assert history.undo_label == ""
    history.do(Command("nodes", "visible", (0,), (True,), (False,), "Hide lamp"))
    assert history.undo_label == "Hide lamp"
    history.undo()
    assert (history.undo_label, history.redo_label) == ("", "Hide lamp")
