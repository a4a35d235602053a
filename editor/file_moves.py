"""Renaming and moving files of the project from the editor, as `lucarna mv` does, in one undoable entry. No imgui."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from editor import replacing, tabs
from editor.commands.replacement import FileStep
from engine.core.errors import InputError, LucarnaError
from importers.project.move_log import recover_around, told
from importers.project.moving import Move, plan
from importers.project.references import Reference, all_references

if TYPE_CHECKING:
    from editor.document import Document
    from editor.session import Session

Steps = tuple[Callable[[], None], Callable[[], None]]


def move(session: Session, old: Path, new: Path, root: Path | None = None) -> bool:
    """Move `old` to `new`, and what refers to it with it; False when it was refused, and why is in the error bar.

    Open documents that are concerned must have been saved; they are read anew from where their files are then."""
    try:
        put_back(session, old)
        planned = plan(old, new, root=root)
        label = f"Rename {old.name} to {planned.new.name}" if old.parent == planned.new.parent else f"Move {old.name}"
        moved = Moved(session, planned, label)
        moved.go(True)
    except LucarnaError as error:
        session.fail(error)
        return False
    count = len(planned.references)
    session.ui.notice = f"{label}: {count} reference{'s follow' if count != 1 else ' follows'}"
    rewritten = [p.relative_to(planned.root).as_posix() for p in planned.rewritten]
    more = f"; rewritten: {', '.join(rewritten)}" if rewritten else "; nothing refers to it"
    if session.document is None:
        more += "; no document is open that could undo it: move it back by its new name"
    session.messages.info(f"{label}{more}", where=str(planned.new))
    return True


def put_back(session: Session, path: Path) -> None:
    """Put back what a process that died had begun to move around `path`, and say so in the log."""
    names = recover_around(path)
    if names:
        session.messages.warn(f"Note: {told(names)}", where=str(path))


class Moved:
    """Files that are at their new places or their old ones. Every document that they concern has an entry that brings
    them to the one or the other, so that each can undo the move, and the others follow."""

    def __init__(self, session: Session, planned: Move, label: str) -> None:
        self.session, self.planned, self.label = session, planned, label
        self.there = self._undone = False

    def go(self, there: bool, by: Document | None = None) -> None:
        """Bring the files to their new places (`there`) or the old ones. `by`: the document whose history does it, and
        which follows by itself. Raises LucarnaError; then nothing has changed."""
        if there == self.there:
            return
        session = self.session
        step = self.planned.reverse() if not there else self.planned.again() if self._undone else self.planned
        lies = {new: old for old, new in step.files.items()}
        touched = set(step.files) | {lies.get(path, path) for path in step.rewritten}
        found = all_references(step.root)
        others = [d for d in tabs.documents(session) if d is not by and _concerns(d, touched, found)]
        self._refuse_unsaved(others, touched)
        step.apply()
        if there:
            self.planned = step
        self.there, self._undone = there, self._undone or not there
        followed: list[Document] = []
        try:
            for document in others:
                self._follow(document, step.files)
                followed.append(document)
            front = session.document
            if by is None and front is not None and front not in others:
                front.history.do(FileStep(self.label, self._steps(front)))
        except LucarnaError:
            step.undo()
            self.there = not there
            for document in followed:
                document.history.undo()
            raise

    def _steps(self, document: Document) -> Steps:
        """What an entry of that document does to the files when it is done (as they are now), and undone."""
        there = self.there
        return lambda: self.go(there, document), lambda: self.go(not there, document)

    def _refuse_unsaved(self, documents: list[Document], touched: set[Path]) -> None:
        for document in documents:
            if document.dirty:
                raise InputError(
                    f"{document.name} has unsaved changes and uses it", where=self.planned.old,
                    hint="save it first, then move",
                )  # fmt: skip
        for text in self.session.code.dirty:
            if text.path in touched:
                raise InputError(f"{text.name} has unsaved changes", where=text.path, hint="save it first, then move")

    def _follow(self, document: Document, files: Mapping[Path, Path]) -> None:
        """Read a document anew from where its files are now: an entry in its own history."""

        def here(path: Path) -> Path:
            return files.get(path, path)

        source = here(document.source)
        replacing.replace_scene(
            self.session, document, here(document.scene_path), self.label if self.there else f"Undo: {self.label}",
            findings=document.findings, of_view=True, steps=self._steps(document), source=source,
            saved_to=here(document.saved_to) if document.saved_to is not None else None,
            imported_from=here(document.imported_from) if document.imported_from is not None else None,
            name=source.name if document.name == document.source.name else document.name,
        )  # fmt: skip


def _concerns(document: Document, touched: set[Path], found: list[Reference]) -> bool:
    """Whether anything that the document's scene leads to moves or is rewritten."""
    by_file: dict[Path, list[Path]] = {}
    for ref in found:
        by_file.setdefault(ref.file, []).append(ref.target)
    waiting, seen = [document.scene_path.resolve(), document.source.resolve()], set()
    while waiting:
        path = waiting.pop()
        if path in touched or path.resolve() in touched:
            return True
        if path not in seen:
            seen.add(path)
            waiting += by_file.get(path, [])
    return False
