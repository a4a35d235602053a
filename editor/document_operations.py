"""Operations on the documents that are open: the next, the one before, one by its place, all but one."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from editor import file_moves, tabs
from editor.arguments import Argument
from editor.operations import Operation, Operations
from editor.session import Session

#: how many tabs can be named by their place
PLACES = 9


def add_document_operations(ops: Operations) -> None:
    """Add them all to the registry."""

    def add(id: str, label: str, run: Callable[[Session], None], *keys: str, first: bool = False, about: str) -> None:
        ops.add(Operation(id, label, run, "File", keys, _several, None, first, about))

    add("document.next", "Next document", lambda s: tabs.step(s, 1), "Ctrl+Tab", "Ctrl+PageDown", first=True,
        about="Each document has its own undo history, camera and settings")  # fmt: skip
    add("document.previous", "Previous document", lambda s: tabs.step(s, -1), "Ctrl+Shift+Tab", "Ctrl+PageUp",
        about="The tab to the left, round and round")  # fmt: skip
    add("document.close-others", "Close other documents", close_others, about="Asks first where changes are unsaved")
    ops.add(
        Operation(
            "file.move", "Move a file of the project", _move,
            arguments=(Argument("old", "path", doc="a file or folder"), Argument("new", "path", doc="its new place")),
            doc="What refers to it follows, as `lucarna mv` does it; undone like an edit",
        )
    )  # fmt: skip
    ops.add(
        Operation(
            "file.rename-asset",
            "Rename or move the chosen asset…",
            _rename_asset,
            enabled=lambda s: s.asset is not None,
        )
    )
    for place in range(PLACES):
        ops.add(
            Operation(f"document.show-{place + 1}", f"Go to document {place + 1}", _shower(place), enabled=_has(place))
        )


def _move(session: Session, old: Path, new: Path) -> None:
    file_moves.move(session, old, new)


def _rename_asset(session: Session) -> None:
    session.ui.rename_asset = session.asset


def close_others(session: Session) -> None:
    """Close all documents but the one in front; those with unsaved changes stay, and the first of them is asked
    about."""
    kept = session.document
    for tab in [t for t in session.tabs if t.document is not kept and not t.document.dirty]:
        tabs.show(session, session.tabs.index(tab))
        session.close()
    dirty = next((i for i, t in enumerate(session.tabs) if t.document is not kept), -1)
    tabs.show(session, next((i for i, t in enumerate(session.tabs) if t.document is kept), -1))
    if dirty >= 0:
        tabs.show(session, dirty)

        def then() -> None:
            session.close()
            tabs.show(session, next((i for i, t in enumerate(session.tabs) if t.document is kept), -1))
            close_others(session)

        session.ask_discard(then)


def _shower(place: int) -> Callable[[Session], None]:
    return lambda session: tabs.show(session, place)


def _has(place: int) -> Callable[[Session], bool]:
    return lambda session: place < len(session.tabs)


def _several(session: Session) -> bool:
    return len(session.tabs) > 1
