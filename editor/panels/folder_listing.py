"""Folders as the assets panel and the open dialog show them: sorted, and read again when they change. No imgui."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from editor.opening import SKIPPED_FOLDERS
from editor.thumbnail_maker import sort_of

ENTRY_LIMIT = 5000
#: how many files a search lists, how many it looks at, and how long what was found stands, seconds
FOUND_LIMIT, LOOK_LIMIT, STANDS = 1000, 20_000, 1.0
#: and how many times what the search took
PATIENCE = 30.0


@dataclass(frozen=True, slots=True)
class Entry:
    """`kind`: folder, project, scene, source, picture, engine (other files of ours) or file."""

    path: Path
    name: str
    kind: str
    size: int = 0


def kind_of(name: str, extensions: Sequence[str]) -> str:
    """What a file is, by its name."""
    lowered = name.lower()
    if lowered == "project.toml":
        return "project"
    if lowered.endswith(".scene.json"):
        return "scene"
    if lowered.endswith(tuple(extensions)):
        return "source"
    if lowered.endswith((".lmesh", ".lanim", ".material.toml", ".effect.toml")):
        return "engine"
    if lowered.endswith((".png", ".jpg", ".jpeg", ".dds", ".ktx", ".ktx2", ".hdr", ".exr", ".webp", ".tga")):
        return "picture"
    return "file"


class FolderListing:
    """Lists folders; a folder's listing is kept until its modification time changes."""

    def __init__(self, extensions: Sequence[str]) -> None:
        self.extensions = tuple(extensions)
        self._cache: dict[Path, tuple[int, list[Entry]]] = {}
        self._stamps: dict[Path, tuple[float, tuple[int, int]]] = {}
        self._found: tuple[object, float, list[Entry]] = (None, 0.0, [])

    def known(self) -> Iterator[Path]:
        """What was listed and looked at."""
        yield from self._cache
        yield from self._stamps

    def stamp(self, path: Path) -> tuple[int, int]:
        """(modification time in ns, size) of a file, not older than STANDS; (0, 0) where it is gone."""
        now = time.monotonic()
        known = self._stamps.get(path)
        if known is None or now - known[0] > STANDS:
            try:
                info = path.stat()
                known = (now, (info.st_mtime_ns, info.st_size))
            except OSError:
                known = (now, (0, 0))
            self._stamps[path] = known
        return known[1]

    def find(self, root: Path, needle: str, sort: str) -> list[Entry]:
        """All files under `root` whose name holds `needle` and that are of that sort ('' = any), by path."""
        key, now = (root, needle.lower(), sort), time.monotonic()
        if key != self._found[0] or now > self._found[1]:
            found: list[Entry] = []
            for looked, entry in enumerate(self._walk(root, 0)):
                if needle.lower() in entry.name.lower() and sort in ("", sort_of(entry.name)):
                    found.append(entry)
                if len(found) >= FOUND_LIMIT or looked >= LOOK_LIMIT:
                    break
            done = time.monotonic()
            self._found = (key, done + max(STANDS, PATIENCE * (done - now)), found)
        return self._found[2]

    def _walk(self, folder: Path, depth: int) -> Iterator[Entry]:
        for entry in self.entries(folder):
            if entry.kind != "folder":
                yield entry
            elif depth < 24:  # beyond is a loop of links
                yield from self._walk(entry.path, depth + 1)

    def entries(self, folder: Path) -> list[Entry]:
        """Folders first, then files, by name without case; hidden ones left out; [] where it cannot be read."""
        try:
            stamp = folder.stat().st_mtime_ns
            known = self._cache.get(folder)
            if known is None or known[0] != stamp:
                known = self._cache[folder] = (stamp, self._read(folder))
        except OSError:
            return []
        return known[1]

    def _read(self, folder: Path) -> list[Entry]:
        rows = []
        with os.scandir(folder) as entries:
            for entry in entries:
                if entry.name.startswith(".") or entry.name in SKIPPED_FOLDERS:
                    continue
                if entry.is_dir():
                    rows.append(Entry(folder / entry.name, entry.name, "folder"))
                elif entry.is_file():
                    kind = kind_of(entry.name, self.extensions)
                    rows.append(Entry(folder / entry.name, entry.name, kind, entry.stat().st_size))
                if len(rows) >= ENTRY_LIMIT:
                    break
        return sorted(rows, key=lambda e: (e.kind != "folder", e.name.lower()))


def can_open(entry: Entry) -> bool:
    return entry.kind in {"project", "scene", "source"}


def size_text(size: int) -> str:
    """Bytes, readable: 1536 -> `1.5 KB`."""
    value = float(size)
    for unit in ("B", "KB", "MB"):
        if value < 1024.0:
            return f"{value:.0f} {unit}" if unit == "B" else f"{value:.1f} {unit}"
        value /= 1024.0
    return f"{value:.1f} GB"
