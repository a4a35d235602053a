"""A session and its journal: one with each document, kept up; what a dead session left, restored. No imgui."""

from __future__ import annotations

from typing import TYPE_CHECKING

from editor import tabs
from editor.document import Document
from editor.journal import Journal, Recovery, discard, file_changes, replay
from engine.core.errors import LucarnaError

if TYPE_CHECKING:
    from editor.session import Session


def start(session: Session, document: Document) -> None:
    """Journal the document's edits from now on, where the session has a folder for it."""
    if session.recovery_folder is None:
        return
    try:
        session.journal = Journal(document, session.recovery_folder)
    except (OSError, LucarnaError) as error:
        session.messages.warn(f"Edits are not kept for a recovery: {error}", where=str(session.recovery_folder))


def keep(session: Session) -> None:
    """Once a frame: snapshots, and a word when a journal cannot be written."""
    if session.handling:
        return
    for journal, tab in list(tabs.journals(session)):
        journal.tick()
        if journal.problem:
            session.messages.warn(f"Edits are no longer kept for a recovery: {journal.problem}")
            journal.leave()
            if tab is None:
                session.journal = None
            else:
                tab.journal = None


def leave(session: Session) -> None:
    """The session dies of a defect: what was edited waits for the next start."""
    for journal, tab in list(tabs.journals(session)):
        journal.leave()
        if tab is not None:
            tab.journal = None
    session.journal = None


def recover(session: Session, recovery: Recovery) -> bool:
    """Open what a session that died had open and do its edits again. False when not all of it could be."""
    from editor.session import shader_root

    try:
        resolved = recovery.resolved()
        with session.device_frame():
            # edits were made to what the file held then; it may have been saved over since
            runtime = session.host.open_runtime(session.device, resolved.scene, shader_root(resolved), recovery.base)
    except LucarnaError as error:
        session.fail(error)
        return False
    document = Document(resolved, runtime)
    document.base_path = recovery.base
    open_one = tabs.find(session, document.source)
    session.adopt(document, beside=open_one >= 0 and session.tabs[open_one].document.dirty)
    try:
        with session.device_frame():
            replay(document, recovery.path)
    except LucarnaError as error:
        session.fail(error)
        return False
    document.base_path = None
    changes = file_changes(recovery.path)
    if changes:
        session.messages.info(
            f"Restored without their undo, since they are done to files: {', '.join(changes)}",
            where=str(document.source),
        )
    discard(recovery.path)
    edits = len(document.history.entries)
    session.ui.notice = f"{edits} edit{'s' if edits != 1 else ''} restored"
    return True
