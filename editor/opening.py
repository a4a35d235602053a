"""From what the user named (project, folder, source, scene) to a scene file, in a worker thread with a cancel."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Generic, TypeVar

from editor.host import Cancelled, Host, Progress, Resolved
from editor.waking import Word, wake
from engine.core.errors import InputError, LucarnaError

Result = TypeVar("Result")

#: folders that never hold what a user means to open
SKIPPED_FOLDERS = {".git", ".cache", "__pycache__", "node_modules", ".venv"}
#: how many files of a dropped folder are looked at
FOLDER_LIMIT = 20_000


def resolve_path(path: Path, progress: Progress, extensions: Sequence[str]) -> Resolved:
    """Turn a project, folder, source or scene into a scene file, converting through the cache where needed.

    Raises InputError when nothing there can be opened, Cancelled when `progress` calls it off.
    """
    from importers.cache import scene_for
    from importers.project.move_log import recover_around, told
    from importers.settings import ImportSettings

    path = Path(path)
    put_back = recover_around(path)
    if not path.exists():
        raise InputError("there is no such file or folder", where=path)
    root, name, start = None, "", path
    if path.name == "project.toml" or (path.is_dir() and (path / "project.toml").is_file()):
        from engine.app.project import load_project

        project = load_project(path)
        root, name, start = Path(project.root), project.name, Path(project.start)
        edited = root / "scenes" / f"{scene_stem(start)}.scene.json"
        if edited.is_file():  # what the user saved goes before the source it was made from
            start = edited
    elif path.is_dir():
        progress(f"Looking through {path.name}", -1.0)
        start = pick_from_folder(path, extensions)
    progress(f"Importing {start.name}", -1.0)
    scene, findings = scene_for(start, settings=ImportSettings(), progress=progress)
    if put_back:
        findings.warn("project.interrupted-move", told(put_back), "", "move it again")
    return Resolved(path, Path(scene), root, name, findings, _source_of(start))


def _source_of(start: Path) -> Path | None:
    """The source that a scene comes from: the file itself, or what the record beside the scene says."""
    if not start.name.endswith(".scene.json"):
        return start.resolve()
    from importers.reimport.record import read_record

    record = read_record(start)
    return record.source if record is not None and record.source.is_file() else None


def scene_stem(path: Path) -> str:
    """`a/fox.glb` and `a/fox.scene.json` -> `fox`."""
    name = path.name
    return name.removesuffix(".scene.json") if name.endswith(".scene.json") else path.stem


def pick_from_folder(folder: Path, extensions: Sequence[str]) -> Path:
    """The file of a folder most likely meant: scenes before sources, shallow before deep, then the largest.

    Raises InputError when there is none."""
    best: tuple[tuple[int, int, int], Path] | None = None
    seen = 0
    for base, folders, files in os.walk(folder):
        folders[:] = sorted(f for f in folders if f not in SKIPPED_FOLDERS and not f.startswith("."))
        for name in sorted(files):
            seen += 1
            lowered = name.lower()
            is_scene = lowered.endswith(".scene.json")
            if is_scene or lowered.endswith(tuple(extensions)):
                file = Path(base) / name
                rank = (0 if is_scene else 1, len(file.relative_to(folder).parts), -file.stat().st_size)
                if best is None or rank < best[0]:
                    best = (rank, file)
        if seen > FOLDER_LIMIT:
            break
    if best is None:
        wanted = ", ".join(("project.toml", "*.scene.json", *(f"*{e}" for e in extensions)))
        raise InputError("the folder holds nothing that can be opened", where=folder, hint=f"looked for {wanted}")
    return best[1]


class Job(Generic[Result]):
    """Does `work(progress)` in a thread. Poll `done`; then either `result` or `error` is set, or neither when
    cancelled. `path`: what it is about."""

    def __init__(self, path: Path, text: str, work: Callable[[Progress], Result]) -> None:
        self.path = path
        self.text = text
        self.fraction = -1.0
        self.result: Result | None = None
        self.error: LucarnaError | None = None
        self.cancelled = False
        self._work = work
        self._ended = threading.Event()
        self._word = Word()
        self._thread = threading.Thread(target=self._run, name=text, daemon=True)
        self._thread.start()

    @property
    def done(self) -> bool:
        return self._ended.is_set()

    def cancel(self) -> None:
        """Ask the work to stop at its next step; what it made so far stays in the cache, whole."""
        self.cancelled = True

    def wait(self, seconds: float | None = None) -> None:
        self._ended.wait(seconds)

    def _progress(self, text: str, fraction: float = -1.0) -> None:
        if self.cancelled:
            raise Cancelled
        self.text, self.fraction = text, fraction
        self._word.say()

    def _run(self) -> None:
        try:
            self._do()
        finally:
            self._ended.set()
            wake()

    def _do(self) -> None:
        try:
            self.result = self._work(self._progress)
        except Cancelled:
            pass
        except LucarnaError as error:
            self.error = error
        except OSError as error:
            self.error = InputError(error.strerror or str(error), where=error.filename or self.path)
        except Exception as error:  # a defect in an importer must cost this file, not the session's unsaved work
            self.error = LucarnaError(f"internal error: {type(error).__name__}: {error}", where=self.path)
        if self.cancelled:
            self.result = self.error = None


class OpenJob(Job[Resolved]):
    """Resolves `path` in a thread."""

    def __init__(self, host: Host, path: Path) -> None:
        super().__init__(path, f"Opening {path.name}", lambda progress: host.resolve(path, progress))
