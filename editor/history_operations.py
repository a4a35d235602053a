"""Operations on the history: go to any entry, with pictures or without."""

from __future__ import annotations

import random
from typing import Any

from editor.arguments import Argument
from editor.operations import Operation, Operations
from editor.session import Session


def add_history_operations(ops: Operations) -> None:
    """Add them all to the registry."""
    ops.add(
        Operation(
            "edit.history", "Go to a place in the history", _go, enabled=_has_history, sample=_sample,
            arguments=(Argument("entries", "int", 0, doc="how many entries are done; 0: as it was opened"),),
            doc="As a click in the history panel: undo or redo until there",
        )
    )  # fmt: skip
    ops.add(
        Operation(
            "view.history-pictures", "Pictures in the history", _toggle, "View",
            checked=lambda s: s.preferences.history_pictures,
            doc="The viewport after each edit, small; the pointer over one shows it larger",
        )
    )  # fmt: skip


def go_to(session: Session, entries: int) -> None:
    """Undo or redo until so many entries are done."""
    session.go_to(entries)


def _go(session: Session, entries: int) -> None:
    go_to(session, entries)


def _toggle(session: Session) -> None:
    session.preferences.history_pictures = not session.preferences.history_pictures
    session.remember()


def _has_history(session: Session) -> bool:
    return session.document is not None and bool(session.document.history.entries or session.document.history.undone)


def _sample(session: Session, dice: random.Random) -> dict[str, Any]:
    assert session.document is not None
    history = session.document.history
    return {"entries": dice.randint(0, len(history.entries) + len(history.undone))}
