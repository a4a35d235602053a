"""Before a command looks at files: what an interrupted move of a project left there is put back, and said."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Sequence
from pathlib import Path

#: importers.project.move_log's, which is imported only where there is something to put back
INTENT = Path(".lucarna/move.json")


def put_back(words: Sequence[str]) -> None:
    """Look around every file and folder that the command line names. Raises InputError where it cannot be put back."""
    named = [Path(word).absolute() for word in words if word and not word.startswith("-")]
    for place in sorted({place for path in named for place in (path, *path.parents)}):
        if _begun(place):
            from importers.project import move_log

            names = move_log.recover(place)
            if names or not _begun(place):  # else its process lives
                print(f"lucarna: {move_log.told(names)} in {place}", file=sys.stderr)


def _begun(place: Path) -> bool:
    with contextlib.suppress(OSError):  # no name that a file can have: a long value of an option
        return (place / INTENT).is_file()
    return False
