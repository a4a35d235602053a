"""History: the undo stack. Every write to a document goes through it."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager

from editor.commands.command import Edit

#: (what: do | undo | redo | end | saved | unsaved, the edit of a `do`, its gesture)
Listener = Callable[[str, Edit | None, Hashable | None], None]


class History:
    """Applies commands through `write` and remembers them.

    Edits with the same `gesture` token and the same target, made before `end_gesture()`, are one entry: a drag of
    three hundred frames is one undo. Two drags are never merged. A gesture that ends where it began leaves no entry.
    """

    def __init__(self, write: Callable[[Edit], None], limit: int = 1000) -> None:
        self._write = write
        self._limit = limit
        self._done: list[Edit] = []
        self._undone: list[Edit] = []
        self._gesture: Hashable | None = None
        self._saved: int | None = 0
        #: told of everything after it happened, so that it can be written down
        self.listener: Listener | None = None
        #: somebody looks at another state for a moment (see `visiting`)
        self.visited = False
        #: told of entries that are neither to be undone nor done again any more
        self.on_dropped: Callable[[list[Edit]], None] | None = None
        #: grows with every write to the document, undo and redo too: a cheap "did anything change"
        self.revision = 0

    def do(self, command: Edit, gesture: Hashable | None = None) -> None:
        """Apply `command`; what `write` raises comes through and leaves the history as it was."""
        merges = gesture is not None and gesture == self._gesture and self._done[-1].target == command.target
        if not command.changes:
            return
        if not merges:
            self._settle()
        self._write(command)
        self.revision += 1
        if merges:
            self._done[-1] = self._done[-1].followed_by(command)
            if self._saved == len(self._done):
                self._saved = None
            self._tell("do", command, gesture)
            return
        if self._saved is not None and self._saved > len(self._done):
            self._saved = None  # the saved state was in the branch that this edit cuts off
        dropped = self._undone[:]
        self._undone.clear()
        self._done.append(command)
        self._gesture = gesture
        if len(self._done) > self._limit:
            dropped += self.forget(1)
        self._tell("do", command, gesture)
        if dropped and self.on_dropped is not None:
            self.on_dropped(dropped)

    def forget(self, count: int) -> list[Edit]:
        """Drop the `count` oldest entries, which can no longer be undone; returns them."""
        dropped = self._done[:count]
        del self._done[:count]
        if self._saved is not None:
            self._saved = self._saved - count if self._saved >= count else None
        return dropped

    def end_gesture(self) -> None:
        """The pointer was let go: the next edit starts an entry of its own."""
        if self._gesture is not None:
            self._settle()
            self._tell("end")

    def undo(self) -> Edit | None:
        """Take back the last entry and return it, or None when there is none."""
        self._settle()
        if not self._done:
            return None
        command = self._done[-1]
        self._write(command.inverse())
        self.revision += 1
        self._undone.append(self._done.pop())
        self._tell("undo")
        return command

    def redo(self) -> Edit | None:
        self._settle()
        if not self._undone:
            return None
        command = self._undone[-1]
        self._write(command)
        self.revision += 1
        self._done.append(self._undone.pop())
        self._tell("redo")
        return command

    def go_to(self, count: int) -> None:
        """Undo or redo until `count` entries are done (0: as it was opened)."""
        self._settle()
        while len(self._done) > max(count, 0) and self.undo() is not None:
            pass
        while len(self._done) < count and self.redo() is not None:
            pass

    @contextmanager
    def visiting(self, count: int) -> Iterator[None]:
        """For a while as it was with `count` entries done, then as it is; nobody is told. Not during a gesture."""
        assert self._gesture is None, "a gesture would be torn in two"
        here, listener = len(self._done), self.listener
        self.listener, self.visited = None, True
        try:
            self.go_to(count)
            yield
        finally:
            self.go_to(here)
            self.listener, self.visited = listener, False

    @property
    def in_gesture(self) -> bool:
        return self._gesture is not None

    @property
    def undo_label(self) -> str:
        """What undo would take back, or ''."""
        return self._done[-1].describe() if self._done else ""

    @property
    def redo_label(self) -> str:
        return self._undone[-1].describe() if self._undone else ""

    @property
    def entries(self) -> tuple[Edit, ...]:
        return tuple(self._done)

    @property
    def last(self) -> Edit | None:
        """The entry that undo would take back."""
        return self._done[-1] if self._done else None

    @property
    def undone(self) -> tuple[Edit, ...]:
        """What redo would do again, the next first."""
        return tuple(reversed(self._undone))

    @property
    def saved_at(self) -> int | None:
        """How many entries were done when the document was saved, or None when that state cannot be reached."""
        return self._saved

    @property
    def dirty(self) -> bool:
        """Whether the document differs from what was last saved."""
        if self._saved is None:
            return True
        between = self._done[self._saved :] or self._undone[len(self._undone) - (self._saved - len(self._done)) :]
        return self._saved != len(self._done) and not all(edit.of_view for edit in between)

    def mark_saved(self) -> None:
        self._settle()
        self._saved = len(self._done)
        self._tell("saved")

    def mark_unsaved(self) -> None:
        """The document differs from what is in its file, whatever is undone."""
        self._settle()
        self._saved = None
        self._tell("unsaved")

    def _tell(self, what: str, command: Edit | None = None, gesture: Hashable | None = None) -> None:
        if self.listener is not None:
            self.listener(what, command, gesture)

    def _settle(self) -> None:
        if self._gesture is None:
            return
        self._gesture = None
        if self._done and not self._done[-1].changes:
            # it ended where it began, and also what was said of it is what it was (see Command.said)
            self._write(self._done.pop().inverse())
