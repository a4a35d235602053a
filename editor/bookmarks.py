"""Operations of camera bookmarks: places to look from, by number, kept with the scene. No imgui."""

from __future__ import annotations

from collections.abc import Callable

from editor.bookmark_table import BOOKMARKS, COLUMN, to_plain
from editor.operations import Operation, Operations
from editor.session import Session

#: bookmarks that have keys: Alt+1 …
COUNT = 4


def add_bookmark_operations(ops: Operations) -> None:
    """Go to each, set each, forget each."""

    def add(id: str, label: str, run: Callable[[Session], None], key: str, enabled: Callable[[Session], bool],
            first: bool) -> None:  # fmt: skip
        ops.add(Operation(id, label, run, "View", (key,) if key else (), enabled, None, first))

    for n in range(1, COUNT + 1):
        add(f"view.bookmark-{n}", f"Go to bookmark {n}", _recall(n), f"Alt+{n}", _has(n), n == 1)
    for n in range(1, COUNT + 1):
        add(f"view.set-bookmark-{n}", f"Set bookmark {n}", _store(n), f"Ctrl+Alt+{n}", _has_document, False)
    for n in range(1, COUNT + 1):
        ops.add(Operation(f"view.forget-bookmark-{n}", f"Forget bookmark {n}", _forget(n), enabled=_has(n)))


def _store(number: int) -> Callable[[Session], None]:
    def run(session: Session) -> None:
        session.edit(BOOKMARKS, COLUMN, (number,), (to_plain(session.camera),), label=f"Set bookmark {number}")
        session.ui.notice = f"Bookmark {number} set: Alt+{number} comes back"

    return run


def _recall(number: int) -> Callable[[Session], None]:
    def run(session: Session) -> None:
        if session.document is not None and number in session.document.bookmarks:
            session.camera = session.document.bookmarks[number]

    return run


def _forget(number: int) -> Callable[[Session], None]:
    return lambda s: s.edit(BOOKMARKS, COLUMN, (number,), (None,), label=f"Forget bookmark {number}")


def _has_document(session: Session) -> bool:
    return session.document is not None


def _has(number: int) -> Callable[[Session], bool]:
    return lambda session: session.document is not None and number in session.document.bookmarks
