"""What a move is about to do, in a file of the project: a process that dies on the way leaves nothing half done.

    begun ─► intent written (waits for the disk) ─► files renamed, texts rewritten ─► intent removed
                 '─ found later, its process gone ─► everything is put back

Going back is always possible: the bytes of every file that is rewritten are in the intent. What a file holds tells how
far the move came, so nothing is written down on the way.
"""

from __future__ import annotations

import base64
import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path

from engine.core.atomic import write_bytes, write_text
from engine.core.errors import InputError

#: hidden, so that it is no file of the project
FOLDER = ".lucarna"
NAME = "move.json"
VERSION = 1


def begin(root: Path, files: Mapping[Path, Path], contents: Mapping[Path, bytes], folders: list[Path]) -> Path:
    """Write down that `files` (old -> new) and then `contents` (file, where it lies afterwards -> bytes) are to be
    done, and `folders` to be made. Raises OutputError; then nothing has begun."""
    back = {new: old for old, new in files.items()}

    def short(path: Path) -> str:
        return os.path.relpath(path, root)

    plan = {
        "version": VERSION, "process": os.getpid(),
        "files": [[short(old), short(new)] for old, new in files.items()],
        "texts": {short(p): [_text(back.get(p, p).read_bytes()), _text(after)] for p, after in contents.items()},
        "folders": [short(folder) for folder in folders],
    }  # fmt: skip
    path = root / FOLDER / NAME
    write_text(path, json.dumps(plan, ensure_ascii=False, indent=1) + "\n")
    return path


def end(root: Path) -> None:
    """The move is whole, or undone."""
    (root / FOLDER / NAME).unlink(missing_ok=True)
    try:
        (root / FOLDER).rmdir()
    except OSError:  # something else lies there
        return


def recover(root: Path) -> list[str]:
    """Put back what a process that is gone had begun to move below `root`: the names of those files, oldest first; none
    where nothing was begun or its process lives. Raises InputError for an intent that cannot be read, OutputError."""
    path = root / FOLDER / NAME
    if not path.is_file():
        return []
    try:
        plan = json.loads(path.read_text(encoding="utf-8"))
        if plan["version"] != VERSION or (plan["process"] != os.getpid() and _lives(int(plan["process"]))):
            return []
        files = [(root / old, root / new) for old, new in plan["files"]]
        texts = {root / n: (base64.b64decode(a), base64.b64decode(b)) for n, (a, b) in plan["texts"].items()}
        folders = [root / name for name in plan["folders"]]
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(
            f"what an interrupted move left cannot be read: {error}", where=path,
            hint="look whether files are missing, then remove it",
        ) from error  # fmt: skip
    for place, (before, after) in texts.items():  # what somebody changed since stays as it is
        if place.is_file() and place.read_bytes() == after:
            write_bytes(place, before)
    undone = []
    for old, new in reversed(files):
        if new.exists() and not old.exists():
            old.parent.mkdir(parents=True, exist_ok=True)
            new.rename(old)
            undone.append(os.path.relpath(old, root))
    for folder in reversed(folders):
        if folder.is_dir() and not any(folder.iterdir()):
            folder.rmdir()
    end(root)
    return undone[::-1]


def recover_around(path: Path) -> list[str]:
    """`recover` for `path` and every folder that it lies in: where a project begins is not asked for."""
    start = Path(path).absolute()
    return [name for place in (start, *start.parents) for name in recover(place)]


def told(names: Sequence[str]) -> str:
    """What `recover` did, in words."""
    return f"an interrupted move was put back: {', '.join(names)}" if names else "an interrupted move had moved nothing"


def _text(data: bytes) -> str:
    return base64.b64encode(data).decode()


def _lives(process: int) -> bool:
    if os.name == "nt":
        return False  # there a signal would end it; who opens a project in two programs moves in one of them
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return True
