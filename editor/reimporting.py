"""Sources that change while they are open: watched, imported again in a thread, merged with what the user did, and put
under the document as one undoable entry. Nothing is lost on a failure: what is open stays. No imgui.

    SourceWatch ── a file changed ──┐
    import card: a fix, a setting ──┼─> ImportJob (thread) -> merge_import -> replacing.replace_scene -> ImportNews
    "Import again" ─────────────────┘
"""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from editor import replacing, saving
from editor.host import Progress
from editor.opening import Job
from engine.core.errors import LucarnaError
from engine.core.findings import Findings
from engine.core.paths import user_cache_dir
from engine.scene.convert import parents_first
from importers.reimport.merge import Report
from importers.reimport.record import Imported, of_import, read_record, write_record

if TYPE_CHECKING:
    from editor.document import Document
    from editor.session import Session

#: seconds between two looks at the files, and for how long one must have been left alone
LOOK, REST = 0.4, 0.3

Steps = tuple[Callable[[], None], Callable[[], None]]


def _nothing() -> None:
    pass


@dataclass(slots=True)
class ImportNews:
    """What the import card shows of the last import of a document. `report`: of the merge, where there was one."""

    source: Path
    findings: Findings = field(default_factory=Findings)
    report: Report | None = None
    orphans: list[str] = field(default_factory=list)


def last_import(document: Document) -> Imported | None:
    """What the document was imported from and as; None for a scene that nobody imported."""
    beside = document.base_path or document.scene_path
    record = read_record(document.scene_path)
    if record is not None:
        return record
    source = document.imported_from
    if source is None or not _cached(document.scene_path) or not beside.is_file():
        return None
    from engine.assets.scene_json import read_scene

    return of_import(source, document.scene_path, read_scene(beside))


def origin_of(document: Document, last: Imported) -> list[int]:
    """For each node of the edited scene, as `saving.edited_scene` gives it, the node of the last import, or -1."""
    scene = document.runtime.scene
    rows = scene.row_of_node.tolist()
    key_of = {row: last.keys[f] for f, row in enumerate(rows) if row >= 0 and f < len(last.keys)}
    order = parents_first(scene) if saving.is_restructured(scene, document.runtime.asset) else rows
    return [key_of.get(row, -1) for row in order]


def save_record(document: Document, target: Path) -> list[Path]:
    """Write down beside a saved scene what it was imported from; the files written. Materials that the source no longer
    has go along."""
    last = last_import(document)
    if last is None:
        return []
    keys = origin_of(document, last)
    written = [write_record(target, Imported(last.source, last.digest, last.scene, last.materials, keys, last.orphans))]
    for path in document.scene_path.parent.glob("*.material.toml"):
        if path.name not in last.materials and any(path.name in line for line in last.orphans):
            out = target.parent / path.name
            if not out.exists():
                out.write_bytes(path.read_bytes())
                written.append(out)
    return written


class ImportJob(Job[tuple[Path, Findings]]):
    """Imports a source in a thread. `steps`: what happened beside it already; `asked`: by the user."""

    def __init__(self, document: Document, source: Path, label: str, steps: Steps, *, asked: bool) -> None:
        self.document, self.label, self.steps, self.asked = document, label, steps, asked
        super().__init__(source, f"Importing {source.name}", lambda progress: _import(source, progress))


def _import(source: Path, progress: Progress) -> tuple[Path, Findings]:
    from importers.cache import scene_for
    from importers.settings import ImportSettings

    return scene_for(source, settings=ImportSettings(), progress=progress)


def welcome(session: Session, document: Document) -> None:
    """Show the card of a source that has just been imported."""
    session.ui.import_card = False
    if document.imported_from is not None and _cached(document.scene_path):
        document.news = ImportNews(document.imported_from, document.findings)
        session.ui.import_card = session.preferences.import_card


def start(session: Session, label: str = "", steps: Steps = (_nothing, _nothing), *, asked: bool = True) -> bool:
    """Import the source of the document in front again; False where it has none. `steps` have happened already, and are
    part of the entry. `asked`: say so even when nothing differs."""
    document = session.document
    last = last_import(document) if document is not None else None
    if document is None or last is None:
        return False
    if session.importing is not None:
        session.importing.cancel()
    session.importing = ImportJob(
        document, last.source, label or f"Import {last.source.name} again", steps, asked=asked
    )
    return True


def poll(session: Session) -> None:
    """Once a frame: begin to import what has changed, take over what was imported."""
    job = session.importing
    if job is None:
        if session.document is not None and session.preferences.reimport and session.sources.changed(session.document):
            start(session, asked=False)
        return
    if not job.done:
        return
    session.importing = None
    if job.error is not None:
        session.messages.warn(f"{job.path.name} was not imported again; what is open stays as it was")
        _back(session, job)
        session.fail(job.error)
    elif job.result is not None and job.document is session.document:
        _take(session, job, job.document, *job.result)
    else:
        _back(session, job)


def _take(session: Session, job: ImportJob, document: Document, new_scene: Path, findings: Findings) -> None:
    from importers.reimport.merging import merge_import

    last = last_import(document)
    if last is None:
        return
    try:
        if _same_import(last, new_scene):
            if job.steps != (_nothing, _nothing):
                _back(session, job)
            if job.asked:
                session.ui.notice = f"{job.path.name}: nothing has changed"
            return
        ours = saving.current_scene(document)
        unsaved = saving.edited_materials(document.runtime.residency, document.overrides)
        session.end_gesture()
        folder = document.scene_path.resolve().parent
        scene, report = merge_import(last, new_scene, ours, origin_of(document, last), folder, unsaved)
        saved_to = document.saved_to or (None if _cached(document.scene_path) else document.scene_path)
        replacing.replace_scene(
            session, document, scene, job.label, findings=findings, steps=once(job.steps), saved_to=saved_to,
            imported_from=last.source,
        )  # fmt: skip
    except LucarnaError as error:
        _back(session, job)
        session.messages.warn(f"{job.path.name} was not imported again; what is open stays as it was")
        session.fail(error)
        return
    document.news = ImportNews(last.source, findings, report, list(report.orphans))
    _tell(session, job, report, findings)


def _tell(session: Session, job: ImportJob, report: Report, findings: Findings) -> None:
    """Every decision is in the log; what found no place, as a warning each."""
    session.messages.findings(findings)
    where = str(job.path)
    for line in report.orphans:
        session.messages.warn(f"Orphan: {line}", where=where, code="import.orphan")
    for line in report.conflicts:
        session.messages.warn(f"Both changed {line}", where=where, code="import.conflict")
    for what, lines in (("kept yours", report.kept), ("took over", report.taken)):
        for line in lines[:50]:
            session.messages.info(f"Import {what}: {line}", where=where)
        if len(lines) > 50:
            session.messages.info(f"Import {what}: and {len(lines) - 50} more", where=where)
    session.ui.notice = f"{job.label}: {report.summary}"
    if session.preferences.import_card:
        session.ui.import_card = True


def once(steps: Steps) -> Steps:
    """The first time around, the step forth has been taken already."""
    first = [True]

    def forth() -> None:
        if first:
            first.clear()
        else:
            steps[0]()

    return forth, steps[1]


def _back(session: Session, job: ImportJob) -> None:
    try:
        job.steps[1]()
    except LucarnaError as error:
        session.messages.error(error)


def _same_import(last: Imported, new_scene: Path) -> bool:
    """Whether the new import gives what the last one gave, file by file."""
    from engine.assets.scene_json import read_scene
    from importers.reimport.record import digest_of_import

    return digest_of_import(new_scene, read_scene(new_scene)) == last.digest


def _cached(path: Path) -> bool:
    return path.resolve().is_relative_to(user_cache_dir().resolve())


class SourceWatch:
    """Looks at the files that the document in front was imported from, in a thread."""

    def __init__(self) -> None:
        self.wake: Callable[[], None] = lambda: None
        self._document: Any = None
        self._source: Path | None = None
        #: source -> how the files that it is made of were, also of documents behind
        self._stamps: dict[Path, dict[Path, tuple[int, int]]] = {}
        #: of the last import of the present source
        self._hash = ""
        self._due = threading.Event()
        self._stop = False
        self._thread: threading.Thread | None = None
        #: what `watched` said of which source
        self._watched: tuple[Path | None, list[Path]] = (None, [])

    def changed(self, document: Document) -> bool:
        """Whether the source of `document`, or what it names, changed since it was asked the last time."""
        source = document.imported_from
        if document is not self._document or source != self._source:
            self._document, self._source = document, source
            last = last_import(document) if source is not None and source not in self._stamps else None
            self._hash = last.scene.provenance.get("source_hash", "") if last is not None else ""
            self._due.clear()
        if source is None:
            return False
        if self._thread is None:
            self._stop = False
            self._thread = threading.Thread(target=self._run, name="source watch", daemon=True)
            self._thread.start()
        if self._due.is_set():
            self._due.clear()
            return True
        return False

    def stop(self) -> None:
        """End the thread."""
        self._stop, self._document, self._source = True, None, None

    def look(self) -> bool:
        """Compare the files with how they were; at the first look, the source with what was imported."""
        source = self._source
        if source is None:
            return False
        before = self._stamps.get(source)
        files = self._watched[1] if self._watched[0] == source else []
        now = {path: stamp_of(path) for path in files}
        if not files or now != before:  # it may name others now
            self._watched = source, watched(source)
            now = {path: stamp_of(path) for path in self._watched[1]}
        self._stamps[source] = now
        if before is None:
            from importers.fingerprint import digest_or_missing

            other = bool(self._hash) and digest_or_missing(source) != self._hash
        else:
            other = before != now
        return other and source == self._source and source.is_file()

    def _run(self) -> None:
        while not self._stop:
            time.sleep(LOOK)
            if self.look():
                quiet = False
                while not quiet and not self._stop:  # whoever writes may not be done
                    time.sleep(REST)
                    quiet = not self.look()
                self._due.set()
                self.wake()
        self._thread = None


def watched(source: Path) -> list[Path]:
    """The files whose change asks for another import: the source, its sidecar, and what it names."""
    from importers.registry import find_importer
    from importers.settings import ImportSettings

    files = [source, source.with_name(f"{source.name}.import")]
    with contextlib.suppress(LucarnaError, OSError, ValueError):  # it is being written
        files += [path for _name, path in find_importer(source).dependencies(source, ImportSettings())]
    return files


def stamp_of(path: Path) -> tuple[int, int]:
    """(modification time in ns, size), or (0, 0) where it is gone."""
    try:
        info = path.stat()
        return info.st_mtime_ns, info.st_size
    except OSError:
        return 0, 0
