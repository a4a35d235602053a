"""From the cache into the output folder: each file whole by a rename, the scene last, the record at the very end."""

from __future__ import annotations

import hashlib
import os
import shutil
import tempfile
from pathlib import Path

from engine.core.atomic import relaxed, umask
from engine.core.errors import OutputError
from importers.cache import owner
from importers.farm.job import Job, Output
from importers.farm.record import FOLDER, Record, record_path, write_record
from importers.fingerprint import digest_or_missing


class EntryLost(Exception):
    """The cache entry went away while it was copied (somebody pruned the cache), or is damaged: make it again."""


def publish(entry: Path, record: Record, old: Record | None, job: Job) -> tuple[list[Output], list[str]]:
    """Copy the files of `entry` that are not in the job's folder yet, remove those that `old` made and `record` does
    not, and write the record. Returns the outputs, and the names that were removed.

    A file that somebody changed by hand is never removed. Raises OutputError, EntryLost.
    """
    try:
        hidden = job.folder / FOLDER
        hidden.mkdir(parents=True, exist_ok=True)
        for item in record.outputs:
            if (job.folder / item["name"]).is_dir():
                raise OutputError("a folder has the name of an output file", where=job.folder / item["name"],
                                  hint="move it away")  # fmt: skip
        before = {item["name"]: item["digest"] for item in old.outputs} if old is not None else {}
        outputs = []
        ready: list[tuple[Path, Path]] = []
        try:
            for item in record.outputs:
                target = job.folder / item["name"]
                same = target.is_file() and digest_or_missing(target) == item["digest"]
                if not same:
                    ready.append((_copy(entry / item["name"], hidden, item["digest"]), target))
                outputs.append(Output(item["name"], item["size"], item["digest"], not same))
            # only now, when there was room for all of them
            for temporary, target in ready:
                temporary.replace(target)
        finally:
            for temporary, _ in ready:
                temporary.unlink(missing_ok=True)
        gone = [name for name in before if name not in {o.name for o in outputs}]
        removed = []
        for name in sorted(gone):
            if digest_or_missing(job.folder / name) == before[name]:
                (job.folder / name).unlink(missing_ok=True)
                removed.append(name)
        record.stamps = [(job.folder / o.name).stat().st_mtime_ns for o in outputs]
    except OSError as error:
        raise OutputError(
            f"cannot write: {error.strerror or error}", where=error.filename2 or error.filename or job.folder,
            hint="check the free space and the rights",
        ) from error  # fmt: skip
    with relaxed(hidden):  # one that is lost is written anew from the cache
        write_record(record_path(job), record, job.source)
    return outputs, removed


def _copy(source: Path, hidden: Path, digest: str) -> Path:
    """A temporary file in `hidden` with the bytes of `source`, forced to the disk. Raises EntryLost where the entry's
    file is not there, or not the bytes that the digest is of."""
    handle, name = tempfile.mkstemp(prefix=f".{owner()}.", suffix=".tmp", dir=hidden)
    temporary = Path(name)
    try:
        state = hashlib.blake2b(digest_size=16)
        with os.fdopen(handle, "wb") as file, source.open("rb") as original:
            while block := original.read(1 << 20):
                state.update(block)
                file.write(block)
            if state.hexdigest() != digest:
                shutil.rmtree(source.parent, ignore_errors=True)
                raise EntryLost
            file.flush()
            os.fsync(file.fileno())
        temporary.chmod(0o666 & ~umask())
    except FileNotFoundError as error:
        temporary.unlink(missing_ok=True)
        raise EntryLost from error
    except (OSError, EntryLost):
        temporary.unlink(missing_ok=True)
        raise
    return temporary


def sweep(folder: Path) -> int:
    """Remove temporary files and folders that dead processes of this machine left in `folder`; returns how many.

    Those of other machines, and where the system cannot tell, go when they are a day old."""
    import time

    machine = owner().split("-")[0]
    removed = 0
    try:
        names = [n for n in os.listdir(folder) if n.startswith(".") and n.endswith(".tmp")]  # noqa: PTH208  (names)
    except OSError:
        return 0
    for name in names:
        path = folder / name
        who = next((part for part in name.split(".") if "-" in part and part.split("-")[0] == machine), "")
        try:
            stale = time.time() - path.stat().st_mtime > 86_400
            if (who and os.name == "posix" and not _alive(int(who.split("-")[1]))) or stale:
                shutil.rmtree(path, ignore_errors=True) if path.is_dir() else path.unlink(missing_ok=True)
                removed += 1
        except (OSError, ValueError):
            continue
    return removed


def _alive(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    try:  # a zombie that nobody collects is as dead
        return Path(f"/proc/{process}/stat").read_text(encoding="utf-8").rsplit(")", 1)[1].split()[0] != "Z"
    except (OSError, IndexError):
        return True
