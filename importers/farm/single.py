"""One source, wanted now: what `lucarna render`, `play` and the editor open.

Its record lies in <user cache>/opened/, so that opening a file again costs the hashing of what it reads.
"""

from __future__ import annotations

import contextlib
import os
from pathlib import Path
from typing import Any

from engine.core.atomic import relaxed
from engine.core.errors import LucarnaError
from engine.core.paths import user_cache_dir
from importers.cache import Cache, Entry, Progress
from importers.farm.job import Job
from importers.farm.plan import parts_of, stem_of
from importers.farm.publish import sweep
from importers.farm.record import Record, judge, read_record, write_record
from importers.farm.task import TASK, error_from, request_for
from importers.fingerprint import Digests, digest_of
from importers.naming import safe_name
from importers.presets import resolve
from importers.registry import find_importer
from importers.settings import ImportSettings
from importers.workers.pool import WorkerPool, in_process
from importers.workers.process import WorkerLimits


def works_in_process() -> bool:
    """Whether the user wants no worker processes (LUCARNA_IN_PROCESS=1): to debug an importer, or in tests of what
    comes after the import. A crash of a parser then ends the program."""
    return os.environ.get("LUCARNA_IN_PROCESS", "") not in ("", "0")


def obtain(source: Path, settings: ImportSettings, progress: Progress | None = None, force: bool = False) -> Entry:
    """The cache entry of `source`, made now if need be, in a worker. Raises InputError, FormatError, OutputError."""
    resolved = resolve(source, settings)
    job = Job(source, source.parent, safe_name(stem_of(source, parts_of(source, resolved.settings))), resolved.settings)
    entry = None if force else remembered(job)
    for _ in range(2):  # somebody may prune the cache just now
        if entry is not None:
            return entry
        request = request_for(source, job.name, job.settings, force=force)
        reply = run_one(request, source, job.settings, progress)
        if reply["error"]:
            raise error_from(reply["refusal"])
        record = record_from(reply)
        remember(job, record)
        entry = Cache().recall(record.key, source)
    if entry is None:
        raise LucarnaError("the cache lost what was just converted", where=source, hint="try again")
    return entry


def memo_path(job: Job) -> Path:
    """Where the record of a source is kept whatever folder its files went to."""
    identity = digest_of(str(job.source.absolute()), job.name, job.settings.key())
    return user_cache_dir() / "opened" / f"{identity}.json"


def remember(job: Job, record: Record) -> None:
    """Keep the record of a conversion, so that the next one needs no worker to know the key. It saves time only."""
    path = memo_path(job)
    with contextlib.suppress(LucarnaError), relaxed(path.parent):
        write_record(path, record, job.source)


def remembered(job: Job, digests: Digests | None = None) -> Entry | None:
    """The cache entry that the memo tells of, if it still holds."""
    record = remembered_record(job, digests or Digests())
    return Cache().recall(record.key, job.source) if record is not None else None


def remembered_record(job: Job, digests: Digests) -> Record | None:
    """The record of an earlier conversion of the same bytes, wherever its files went."""
    record = read_record(memo_path(job))
    if record is None or record.error:
        return None
    made, record.outputs = record.outputs, []
    if not judge(record, job, find_importer(job.source), digests, hash_outputs=False).fresh:
        return None
    record.outputs = made
    return record


def run_one(
    request: dict[str, Any], source: Path, settings: ImportSettings, progress: Progress | None
) -> dict[str, Any]:
    """`task.perform` in a worker of its own."""
    if works_in_process():
        return in_process(TASK, request, progress)
    try:
        with WorkerPool(1) as pool:
            return pool.run(TASK, request, source, limits_for(settings), progress=progress)
    except BaseException:  # stopped in the middle: by a limit, or because the user does not want it any more
        sweep(user_cache_dir() / "converted")
        raise


def limits_for(settings: ImportSettings) -> WorkerLimits:
    return WorkerLimits(settings.max_worker_seconds, settings.max_worker_bytes)


def record_from(reply: dict[str, Any]) -> Record:
    """The record of what `task.perform` returned."""
    names = ("key", "importer", "version", "settings", "inputs", "listed", "outputs", "findings", "scene", "error",
             "exit_code", "limits", "convert_version")  # fmt: skip
    return Record(**{name: reply[name] for name in names})
