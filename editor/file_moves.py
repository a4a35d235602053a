"""Renaming and moving files of the project from the editor, as `lucarna mv` does, in one undoable entry. No imgui."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from editor import replacing, tabs
from editor.commands.replacement import FileStep
from engine.core.errors import InputError, LucarnaError
from importers.project.moving import Move, plan
from importers.project.references import Reference, all_references

if TYPE_CHECKING:
    from editor.document import Document
    from editor.session import Session


def move(session: Session, old: Path, new: Path, root: Path | None = None) -> bool:
    """Move `old` to `new`, and what refers to it with it; False when it was refused, and why is in the error bar.

    Open documents that are concerned must have been saved; they are read anew from where their files are then."""
    try:
        planned = plan(old, new, root=root)
        before = all_references(planned.root)
        concerned = [d for d in tabs.documents(session) if _concerns(d, planned, before)]
        for document in concerned:
            if document.dirty:
                raise InputError(
                    f"{document.name} has unsaved changes and uses it", where=old, hint="save it first, then move"
                )
        for text in session.code.dirty:
            if text.path in planned.files or text.path in planned.rewritten:
                raise InputError(f"{text.name} has unsaved changes", where=text.path, hint="save it first, then move")
        label = f"Rename {old.name} to {planned.new.name}" if old.parent == planned.new.parent else f"Move {old.name}"
        planned.apply()
        back = {new_place: old_place for old_place, new_place in planned.files.items()}
        forth = _again(planned.apply, lambda: _retarget(session, concerned, planned.files, label))
        undo = _both(planned.undo, lambda: _retarget(session, concerned, back, f"Undo: {label}"))
        try:
            _take(session, concerned, planned, label, forth, undo)
        except LucarnaError:
            planned.undo()
            raise
    except LucarnaError as error:
        session.fail(error)
        return False
    count = len(planned.references)
    session.ui.notice = f"{label}: {count} reference{'s follow' if count != 1 else ' follows'}"
    rewritten = [p.relative_to(planned.root).as_posix() for p in planned.rewritten]
    more = f"; rewritten: {', '.join(rewritten)}" if rewritten else "; nothing refers to it"
    session.messages.info(f"{label}{more}", where=str(planned.new))
    return True


def _take(
    session: Session,
    concerned: list[Document],
    planned: Move,
    label: str,
    forth: Callable[[], None],
    back: Callable[[], None],
) -> None:
    """Let the open documents follow, the one in front with an entry that can be undone."""
    front = session.document
    for document in concerned:
        if document is not front:
            _read_anew(session, document, planned.files, label)
    if front is None:
        return
    if front in concerned:
        source, scene = (planned.files.get(p, p) for p in (front.source, front.scene_path))
        saved = planned.files.get(front.saved_to, front.saved_to) if front.saved_to is not None else None
        name = source.name if front.name == front.source.name else front.name
        replacing.replace_scene(
            session, front, scene, label, findings=front.findings, of_view=True, steps=(forth, back), source=source,
            saved_to=saved, imported_from=_moved(front.imported_from, planned.files), name=name,
        )  # fmt: skip
    else:
        front.history.do(FileStep(label, (forth, back)))


def _again(apply: Callable[[], None], then: Callable[[], None]) -> Callable[[], None]:
    """The move itself is done already when its entry is made; only redo does it again."""
    first = [True]

    def run() -> None:
        if first:
            first.clear()
            return
        apply()
        then()

    return run


def _both(one: Callable[[], None], other: Callable[[], None]) -> Callable[[], None]:
    def run() -> None:
        one()
        other()

    return run


def _retarget(session: Session, concerned: list[Document], files: Mapping[Path, Path], label: str) -> None:
    for document in tabs.documents(session):
        if document in concerned and document is not session.document:
            _read_anew(session, document, files, label)


def _read_anew(session: Session, document: Document, files: Mapping[Path, Path], label: str) -> None:
    """A document that is not in front: an entry in its own history."""
    replacing.replace_scene(
        session, document, files.get(document.scene_path, document.scene_path), label, findings=document.findings,
        of_view=True, source=files.get(document.source, document.source),
        imported_from=_moved(document.imported_from, files),
    )  # fmt: skip


def _moved(path: Path | None, files: Mapping[Path, Path]) -> Path | None:
    return files.get(path, path) if path is not None else None


def _concerns(document: Document, planned: Move, found: list[Reference]) -> bool:
    """Whether anything that the document's scene leads to moves or is rewritten."""
    old_place = {new: old for old, new in planned.files.items()}
    touched = set(planned.files) | {old_place.get(p, p) for p in planned.rewritten}
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
