"""Folders as the assets panel and the open dialog show them: sorted, and read again when they change. No imgui."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from editor.opening import SKIPPED_FOLDERS

ENTRY_LIMIT = 5000


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
