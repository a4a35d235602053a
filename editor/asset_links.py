"""Who uses which file of the project, kept up in a thread: each file is read again only when it has changed."""

from __future__ import annotations

import threading
import time
from pathlib import Path

from editor.waking import wake
from importers.project.moving import used_by, uses
from importers.project.references import Reference, files_of, references

#: seconds for which what was found stands
STANDS = 2.0


class AssetLinks:
    """`refresh` begins to look; `used_by` and `uses` answer from what was found last. `ready` after the first look."""

    def __init__(self) -> None:
        self.ready = False
        self._root: Path | None = None
        self._found: list[Reference] = []
        self._cache: dict[Path, tuple[tuple[int, int], list[Reference]]] = {}
        self._names: frozenset[Path] = frozenset()
        self._thread: threading.Thread | None = None
        self._after = 0.0

    def refresh(self, root: Path, *, wait: bool = False) -> None:
        """Look again at the files below `root`, unless that was done a moment ago."""
        if root != self._root:
            self._root, self.ready, self._found, self._after = root, False, [], 0.0
            self._cache.clear()
        busy = self._thread is not None and self._thread.is_alive()
        if not busy and (wait or time.monotonic() > self._after):
            self._thread = threading.Thread(target=self._look, args=(root,), name="asset links", daemon=True)
            self._thread.start()
        if wait and self._thread is not None:
            self._thread.join()

    def used_by(self, path: Path) -> list[Path]:
        """The files that name `path` or something in it, each once."""
        return sorted({r.file for r in used_by(path, self._found) if path not in r.file.parents})

    def uses(self, path: Path) -> list[Path]:
        return sorted({r.target for r in uses(path, self._found)})

    def _look(self, root: Path) -> None:
        files = files_of(root)
        known = set(files)
        if known != self._names:  # what names a file that came or went means something else now
            self._cache.clear()
            self._names = frozenset(known)
        effects = {p.name.removesuffix(".effect.toml"): p for p in files if p.name.endswith(".effect.toml")}
        found: list[Reference] = []
        for file in files:
            try:
                info = file.stat()
            except OSError:
                continue
            stamp = info.st_mtime_ns, info.st_size
            entry = self._cache.get(file)
            if entry is None or entry[0] != stamp:
                entry = self._cache[file] = (stamp, list(references(file, root, known, effects)))
            found += entry[1]
        if root == self._root:
            fresh, self._found, self.ready = not self.ready, found, True
            if fresh:
                wake()
            self._after = time.monotonic() + STANDS
