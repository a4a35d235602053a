"""Journal: every edit as a line in a file, so that a crash loses none. No imgui.

    <settings folder>/recovery/<id>.journal         header line, then one JSON line per do, undo, redo, end, saved
                              <id>.base.json        the scene as it was when it was opened
                              <id>.N.base.json      the Nth one that came in its place, by a new import or prefab
                              <id>.snapshot.scene.json   the edited scene, now and then: readable by itself

A line is handed to the system before the edit's frame ends, so killing the process loses nothing; every snapshot also
waits for the disk. A journal whose process lives is locked. Closing a document in good order removes its files; what is
left belongs to a run that died, and replaying it on the base gives document and undo history back.

Undoing a replacement goes on with the scene that was there before it, whose rows are what they were: "rebased" names
the base that the lines after it are about, and a replay does those of the last one, wherever they stand. What the
prefabs of a scene's instances held is written down too: their files may be others when it is recovered.
"""

from __future__ import annotations

import json
import os
import shutil
import sys
import time
import uuid
import weakref
from collections.abc import Hashable, Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

from editor.commands.command import Command, Edit
from editor.commands.replacement import FileStep, Replacement
from editor.commands.structure import StructureCommand, load
from editor.recovered_numbers import in_place, meant
from editor.saving import note_saved, said_and_saved
from engine.core.errors import InputError, LucarnaError
from engine.core.findings import Findings
from engine.core.paths import user_config_dir
from engine.scene.patch import ScenePatch, node_from_plain, side_from_plain, side_to_plain

if TYPE_CHECKING:
    from editor.document import Document
    from editor.host import Resolved

VERSION = 1
#: seconds between snapshots, and how many times its own cost a snapshot waits for the next
SNAPSHOT_SECONDS, SNAPSHOT_PATIENCE = 15.0, 100.0


def recovery_dir() -> Path:
    return user_config_dir() / "recovery"


class Journal:
    """Writes down what `document.history` does from now on. Raises OSError when the folder cannot be written."""

    def __init__(self, document: Document, folder: Path) -> None:
        self.document = document
        #: which base each scene that stood under the document has, and which one stands now
        self._bases = weakref.WeakKeyDictionary({document.runtime: 0})
        self._base = self._rebased = 0
        self._prefabs: dict[tuple[int, Path], list[Any]] = {}
        self._saved_to = document.saved_to
        folder.mkdir(parents=True, exist_ok=True)
        stem = f"{time.strftime('%Y%m%d-%H%M%S')}-{os.getpid()}-{uuid.uuid4().hex[:6]}"
        self.path = folder / f"{stem}.journal"
        if document.scene_path.is_file():
            self._write_base(base_of(self.path))
        self._file: IO[str] = self.path.open("x", encoding="utf-8")
        _lock(self._file)
        self.problem = ""
        self._changed = False
        self._snapshot_after = time.monotonic() + SNAPSHOT_SECONDS
        self._line({"lucarna-journal": VERSION, **self._place(), "started": time.time()})
        self._note_prefabs()
        document.history.listener = self.record

    def record(self, what: str, edit: Edit | None, gesture: Hashable | None) -> None:
        """One event of the history. A disk that is full stops the journal, not the user: see `problem`."""
        history = self.document.history
        concerned = {"undo": history.undone[:1], "redo": history.entries[-1:]}.get(what, (edit,))
        try:
            if self._bases.get(self.document.runtime) != self._base:
                self._rebase()
            self._note_prefabs()
            line: dict[str, Any] = {"e": what, "n": len(history.entries), "dirty": history.dirty}
            if concerned and isinstance(concerned[0], (Replacement, FileStep)):
                # what stands now is written down; files are no part of a replay
                self._line({**line, "e": "files", "what": what, "label": concerned[0].describe()})
                return
            if edit is not None:
                line["c"] = edit_to_plain(edit)
                line |= self._meaning(edit)
                if gesture is not None:
                    line["g"] = repr(gesture)
            if what == "saved" or self.document.saved_to != self._saved_to:
                line["to"] = str(self.document.saved_to or "")
                self._saved_to = self.document.saved_to
            self._line(line)
        except (OSError, ValueError, LucarnaError) as error:
            self.problem = self.problem or str(error)
        self._changed = True

    def _rebase(self) -> None:
        """Another scene stands under the document: the lines that follow are about that one."""
        document, history = self.document, self.document.history
        base = self._bases.get(document.runtime)
        new = base is None
        if base is None:
            base = self._rebased = self._rebased + 1
            self._bases[document.runtime] = base
            self._write_base(base_of(self.path, base))
        self._base, self._saved_to = base, document.saved_to
        stands: dict[str, Any] = {"n": len(history.entries), "dirty": history.dirty}
        self._line({"e": "rebased", "base": base, **self._place(), **stands, "to": str(document.saved_to or "")})
        said = said_and_saved(document)
        for key in said.keys() - document.overrides.keys():  # their files say something else, and no entry tells
            self._line({"put": [*key, said[key]], **self._meaning(Command(key[0], key[1], key[2:], (0,), (0,)))})
        for (table, column, row), value in document.overrides.items() if new else ():
            edit = Command(table, column, (row,), (None,), (value,), "Recovered")
            self._line({"e": "do", "over": "base", "c": edit_to_plain(edit), **self._meaning(edit), **stands})

    def _meaning(self, edit: Edit) -> dict[str, Any]:
        """What an edit's numbers of meshes and materials are those of (editor.recovered_numbers)."""
        said = meant(edit, getattr(self.document.runtime, "residency", None))
        return {"of": said} if said else {}

    def _write_base(self, path: Path) -> None:
        """What a replay begins with; with instances as their prefabs were when the scene was read."""
        from engine.assets.prefab import has_instances
        from engine.assets.scene_json import write_scene

        document = self.document
        asset = getattr(document.runtime, "asset", None)
        if asset is not None and (self._rebased or has_instances(asset)):
            write_scene(path, asset)
        else:
            shutil.copyfile(document.base_path or document.scene_path, path)

    def _note_prefabs(self) -> None:
        """Write down what the prefabs of the document held when it took them up."""
        for path, nodes in self.document.prefabs.items():
            if self._prefabs.get((self._base, path)) is not nodes:
                self._prefabs[self._base, path] = nodes
                self._line({"prefab": str(path), "nodes": [asdict(node) for node in nodes]})

    @property
    def due(self) -> float | None:
        """Seconds until the next snapshot; None: nothing has changed since the last."""
        return max(self._snapshot_after - time.monotonic(), 0.0) if self._changed else None

    def tick(self) -> None:
        """Now and then, while nothing is dragged: a snapshot, if anything changed."""
        try:
            self._note_prefabs()
        except (OSError, ValueError) as error:
            self.problem = self.problem or str(error)
        now = time.monotonic()
        if not self._changed or now < self._snapshot_after:
            return
        try:
            self.snapshot()
        except (OSError, LucarnaError) as error:
            self.problem = self.problem or str(error)
        cost = time.monotonic() - now
        self._snapshot_after = now + max(SNAPSHOT_SECONDS, SNAPSHOT_PATIENCE * cost)

    def snapshot(self) -> Path:
        """Write the edited scene beside the journal, and the journal to the disk."""
        from editor.saving import current_scene
        from engine.assets.scene_json import write_scene

        path = snapshot_of(self.path)
        write_scene(path, current_scene(self.document))
        os.fsync(self._file.fileno())
        self._changed = False
        return path

    def finish(self) -> None:
        """The document was closed in good order: nothing to recover."""
        self.leave()
        discard(self.path)

    def leave(self) -> None:
        """Stop writing, and keep the files for the next start."""
        if self.document.history.listener == self.record:
            self.document.history.listener = None
        self._file.close()

    def _place(self) -> dict[str, str]:
        document = self.document
        return {
            "source": str(document.source),
            "scene": str(document.scene_path),
            "root": str(document.project_root or ""),
            "name": document.name,
        }

    def _line(self, data: Mapping[str, Any]) -> None:
        self._file.write(json.dumps(data, separators=(",", ":")) + "\n")
        self._file.flush()


@dataclass(frozen=True, slots=True)
class Recovery:
    """What a run that died has left. `edits`: how many entries its undo history had; `dirty`: some were not saved."""

    path: Path
    name: str
    source: Path
    scene: Path
    root: Path | None
    modified: float
    edits: int
    dirty: bool
    #: the number of the base that stood under the document last
    rebased: int = 0

    @property
    def base(self) -> Path | None:
        path = base_of(self.path, self.rebased)
        return path if path.is_file() else None

    def resolved(self) -> Resolved:
        """What to open for it. Raises InputError where the scene is gone."""
        from editor.host import Resolved

        if not self.scene.is_file() and not self.scene.parent.is_dir():
            raise InputError(
                "the scene of the unsaved edits is gone", where=self.scene, hint=f"its last state: {self.fallback}"
            )
        return Resolved(self.source, self.scene, self.root, self.name if self.root else "", Findings(str(self.source)))

    @property
    def fallback(self) -> Path:
        path = snapshot_of(self.path)
        return path if path.is_file() else self.path


def pending(folder: Path | None = None) -> list[Recovery]:
    """Journals of runs that died with unsaved edits, the newest first. Those without any are removed."""
    found = []
    for path in sorted((folder or recovery_dir()).glob("*.journal")):
        if _in_use(path):
            continue
        recovery = _summary(path)
        if recovery is None or not recovery.dirty:
            discard(path)
        else:
            found.append(recovery)
    return sorted(found, key=lambda r: -r.modified)


def replay(document: Document, path: Path) -> int:
    """Do again what the journal says; returns how many of its events were done.

    An event that no longer fits (its files changed) ends the replay: raises InputError, and what came before stays."""
    history = document.history
    done = 0
    lines = list(_lines(path))
    moves = [int(line["base"]) for _, line in lines if line.get("e") == "rebased"]
    last, here = moves[-1] if moves else 0, 0
    for number, line in lines:
        what = line.get("e")
        here = int(line["base"]) if what == "rebased" else here
        if here != last:
            if what == "saved":
                history.mark_unsaved()  # what is in the file is another scene than this
            continue
        try:
            if "to" in line:
                document.saved_to = Path(line["to"]) if line["to"] else None
            if "prefab" in line:
                document.prefabs[Path(line["prefab"])] = [node_from_plain(node) for node in line["nodes"]]
            if "put" in line:
                _put(document, line)
            if what == "do":
                plain = in_place(line["c"], line.get("of", {}), document.runtime.residency)
                if "over" in line:  # what it was before is in the base alone
                    plain["before"] = list(document.tables[plain["table"]].read(plain["column"], plain["rows"]))
                history.do(edit_from_plain(plain, document), line.get("g"))
            elif what == "saved":
                note_saved(document)
                history.mark_saved()
            elif what in {"unsaved", "rebased"}:
                if line.get("dirty", True) and not history.dirty:
                    history.mark_unsaved()
                continue
            elif what in {"undo", "redo", "end"}:
                {"undo": history.undo, "redo": history.redo, "end": history.end_gesture}[what]()
            else:
                continue
        except (LucarnaError, KeyError, ValueError, TypeError, IndexError, AttributeError) as error:
            raise InputError(
                f"edit {done + 1} of the recovered session no longer fits the scene: {error}",
                where=f"{path}:{number}", hint=f"what came before is restored; its last state: {snapshot_of(path)}",
            ) from error  # fmt: skip
        done += 1
    history.end_gesture()
    if moves and not history.dirty and any(line.get("dirty") for _, line in lines[-1:]):
        history.mark_unsaved()
    return done


def _put(document: Document, line: Mapping[str, Any]) -> None:
    """Write a value that an entry before the base had saved and undoing brought back."""
    table, column, row, value = line["put"]
    (row,) = in_place({"table": table, "rows": [row]}, line.get("of", {}), document.runtime.residency)["rows"]
    document.tables[table].write(column, (row,), (_tuples(value),))
    file = str(Path(document.runtime.residency.material(row).path).resolve()) if table == "materials" else ""
    document.saved_values.add((table, column, file))


def file_changes(path: Path) -> list[str]:
    """What the journal says of changes of files that were done and not undone: they stay, and no replay has them."""
    found: list[str] = []
    for _, line in _lines(path):
        if line.get("e") == "files" and line.get("what") == "undo":
            found = found[:-1]
        elif line.get("e") == "files":
            found.append(str(line.get("label", "")))
    return found


def discard(path: Path) -> None:
    """Remove a journal and what lies beside it."""
    for file in (path, *path.parent.glob(f"{path.stem}*.base.json"), snapshot_of(path)):
        file.unlink(missing_ok=True)


def base_of(path: Path, rebased: int = 0) -> Path:
    return path.with_name(f"{path.stem}{f'.{rebased}' if rebased else ''}.base.json")


def snapshot_of(path: Path) -> Path:
    return path.with_name(f"{path.stem}.snapshot.scene.json")


def edit_to_plain(edit: Edit) -> dict[str, Any]:
    """An edit as JSON-able values."""
    if isinstance(edit, StructureCommand):
        return {
            "before": side_to_plain(edit.patch.before),
            "after": side_to_plain(edit.patch.after),
            "selection": edit.selection,
            "overrides": [[[*key, value] for key, value in side.items()] for side in edit.overrides],
            "label": edit.label,
            "line": edit.line,
            "loads": edit.loads,
        }
    assert isinstance(edit, Command)
    return {
        "table": edit.table, "column": edit.column, "rows": edit.rows, "before": edit.before, "after": edit.after,
        "label": edit.label, "said": edit.said,
    }  # fmt: skip


def edit_from_plain(data: Mapping[str, Any], document: Document) -> Edit:
    """The edit that `edit_to_plain` wrote. Raises KeyError, TypeError or ValueError for anything else."""
    if "selection" in data:
        scene, loads = document.runtime.scene, tuple(str(f) for f in data.get("loads", ()))
        load(document, loads)
        before, after = (side_from_plain(data[side], scene) for side in ("before", "after"))
        old, new = ({(t, c, int(r)): _tuples(v) for t, c, r, v in side} for side in data["overrides"])
        first, second = (tuple(int(r) for r in rows) for rows in data["selection"])
        label, made_by = str(data["label"]), str(data.get("line", ""))
        return StructureCommand(ScenePatch(before, after), (first, second), (old, new), label, made_by, loads)
    rows = tuple(int(r) for r in data["rows"])
    return Command(
        str(data["table"]),
        str(data["column"]),
        rows,
        _tuples(data["before"]),
        _tuples(data["after"]),
        data["label"],
        _tuples(data.get("said", [[], []])),
    )


def _tuples(value: Any) -> Any:
    return tuple(_tuples(v) for v in value) if isinstance(value, list) else value


def _lines(path: Path) -> Iterator[tuple[int, dict[str, Any]]]:
    """(line number, value) of each whole line; a torn last one is left out."""
    with path.open(encoding="utf-8", errors="replace") as file:
        for number, line in enumerate(file, 1):
            try:
                data = json.loads(line)
            except ValueError:
                return
            if isinstance(data, dict):
                yield number, data


def _summary(path: Path) -> Recovery | None:
    """What the prompt says of a journal, by its last whole line; None for a file that is none."""
    header: dict[str, Any] | None = None
    edits, dirty, rebased = 0, False, 0
    try:
        for _, line in _lines(path):
            if header is None:
                if line.get("lucarna-journal") != VERSION:
                    return None
                header = line
            elif line.get("e") == "rebased":
                header, rebased, dirty = {**header, **line}, int(line["base"]), bool(line.get("dirty", True))
            elif "e" in line:
                edits, dirty = int(line.get("n", edits + 1)), bool(line.get("dirty", True))
        if header is None:
            return None
        return Recovery(
            path, str(header["name"]), Path(header["source"]), Path(header["scene"]),
            Path(header["root"]) if header["root"] else None, path.stat().st_mtime, edits, dirty, rebased,
        )  # fmt: skip
    except (OSError, KeyError, TypeError, ValueError):
        return None


def _lock(file: IO[str]) -> None:
    if sys.platform == "win32":
        return  # an open file cannot be renamed there: see _in_use
    import fcntl

    fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


def _in_use(path: Path) -> bool:
    """Whether the process that writes the journal lives. The system drops its lock when it dies, however it dies."""
    try:
        if sys.platform == "win32":
            path.rename(path)
            return False
        import fcntl

        with path.open("r", encoding="utf-8") as file:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        return False
    except OSError:
        return True
