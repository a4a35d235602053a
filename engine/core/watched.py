"""Watched: files whose change is found by looking at them; no thread, no events, so network mounts work too.

What is looked at: mtime, size, and ctime, which tells a file apart that was renamed into the place of one of the same
size in the same tick of a coarse clock (FAT: 2 s). No inode: some network file systems make them up anew.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

#: of a file: (mtime in ns, size, ctime in ns); None when it is not there
Stamp = tuple[int, int, int] | None

#: no file has it: makes a file count as changed
_NEVER: Stamp = (-1, -1, -1)


def stamp(path: Path) -> Stamp:
    try:
        info = path.stat()
    except OSError:
        return None
    return info.st_mtime_ns, info.st_size, info.st_ctime_ns


class Watched:
    """A set of paths (files, folders, what is not there yet) with the stamps they had when last looked at."""

    def __init__(self) -> None:
        self._stamps: dict[Path, Stamp] = {}

    def add(self, paths: Iterable[Path]) -> None:
        """Watch these from now on; those that are watched keep their stamps."""
        for path in paths:
            if path not in self._stamps:
                self._stamps[path] = stamp(path)

    def keep(self, paths: Iterable[Path]) -> None:
        """Watch no others than these of those that are watched."""
        wanted = set(paths)
        self._stamps = {path: seen for path, seen in list(self._stamps.items()) if path in wanted}

    def changed(self) -> set[Path]:
        """The paths that are not as they were when last looked at. Any thread may ask."""
        return {path for path, seen in list(self._stamps.items()) if stamp(path) != seen}

    def take(self) -> set[Path]:
        """As `changed`, and from now on they count as looked at."""
        found = self.changed()
        for path in found:
            self._stamps[path] = stamp(path)
        return found

    def invalidate(self) -> None:
        """Take all for changed."""
        self._stamps = dict.fromkeys(self._stamps, _NEVER)
