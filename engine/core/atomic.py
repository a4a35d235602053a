"""Atomic writes: a reader sees the old file or the whole new one, never a part of it."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

from engine.core.errors import OutputError

#: folders (with a separator at the end) whose files may be lost when the machine loses its power
_relaxed: list[str] = []


@contextlib.contextmanager
def relaxed(folder: Path) -> Iterator[None]:
    """Meanwhile files below `folder` are not forced to the disk, which takes milliseconds each: for what is checked
    before it is used, or dies with the process anyway."""
    place = str(folder) + os.sep
    _relaxed.append(place)
    try:
        yield
    finally:
        _relaxed.remove(place)


@contextlib.contextmanager
def atomic_path(path: Path) -> Iterator[Path]:
    """Yield a temporary path beside `path`; on success fsync and rename it over `path`, on failure remove it.

    Raises OutputError when the folder cannot be made or written.
    """
    path = Path(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(prefix=f".{path.name}.", suffix=".tmp", dir=path.parent)
        os.close(handle)
    except OSError as error:
        raise OutputError(
            f"cannot write: {error.strerror or error}", where=path, hint="choose a folder that you may write to"
        ) from error
    temporary = Path(name)
    try:
        yield temporary
        if not name.startswith(tuple(_relaxed)):
            with temporary.open("rb+") as file:
                os.fsync(file.fileno())
        temporary.chmod(0o666 & ~umask())
        temporary.replace(path)
    except OSError as error:
        raise OutputError(
            f"cannot write: {error.strerror or error}", where=path, hint="check the free space and the rights"
        ) from error
    finally:
        temporary.unlink(missing_ok=True)


def write_bytes(path: Path, data: bytes | memoryview) -> None:
    """Write `data` to `path` atomically. Raises OutputError."""
    with atomic_path(path) as temporary:
        temporary.write_bytes(data)


def write_text(path: Path, text: str) -> None:
    """Write `text` as UTF-8 with \\n line ends to `path` atomically. Raises OutputError."""
    write_bytes(path, text.encode("utf-8"))


def umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
