"""Map a file read-only: the first step of every reader here."""

from __future__ import annotations

import mmap
import stat
from pathlib import Path

from engine.core.errors import InputError


def map_file(path: Path) -> memoryview:
    """The bytes of a regular file as a read-only memory map; the views keep the map alive.

    Our writers replace files whole, so a mapped file keeps its old content when it is written anew.
    Raises InputError when it cannot be read.
    """
    path = Path(path)
    try:
        # checked before open: opening a FIFO would wait for ever
        if not stat.S_ISREG(path.stat().st_mode):
            raise InputError("is not a regular file", where=path)
        with path.open("rb") as file:
            if path.stat().st_size == 0:
                return memoryview(b"")
            return memoryview(mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ))
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise InputError(f"cannot read: {reason or error}", where=path, hint="check the path") from error
