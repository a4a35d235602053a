"""Jobs -> outcomes: what is up to date is left alone, the rest goes to the workers, several at a time."""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

from engine.core.errors import InputError, LucarnaError, OutputError
from engine.core.paths import user_cache_dir
from importers.cache import Cache
from importers.farm.job import Job, Outcome
from importers.farm.plan import refusal
from importers.farm.publish import EntryLost, publish, sweep
from importers.farm.record import FOLDER, Record, Verdict, judge, read_record, record_path, refusal_path, write_record
from importers.farm.single import limits_for, record_from, remember, remembered_record, works_in_process
from importers.farm.task import TASK, request_for
from importers.fingerprint import Digests
from importers.registry import find_importer
from importers.workers.pool import WorkerPool, in_process
from importers.workers.process import usable_cores

#: jobs under way for each worker: one is worked on while the others are written
AHEAD = 4


class Workers(Protocol):
    """Who performs requests: this machine's processes, or a cluster. May be called from several threads."""

    size: int

    def perform(self, request: dict[str, Any], job: Job) -> tuple[dict[str, Any], Path]:
        """The reply of task.perform, and the folder that holds the entry's files here. Raises LucarnaError."""

    def close(self) -> None: ...


class LocalWorkers:
    """`size` warm processes of this machine, or none (see single.works_in_process)."""

    def __init__(self, size: int) -> None:
        self._pool = None if works_in_process() else WorkerPool(size)
        self.size = 1 if self._pool is None else size

    def perform(self, request: dict[str, Any], job: Job) -> tuple[dict[str, Any], Path]:
        # each of several workers has its share of the cores for its texture threads; the bytes are the same
        threads = max(1, usable_cores() // self.size)
        request = request | {"settings": {"jobs": threads} | request["settings"]}
        if self._pool is None:
            reply = in_process(TASK, request)
        else:
            reply = self._pool.run(TASK, request, job.source, limits_for(job.settings))
        return reply, user_cache_dir() / "converted" / str(reply["key"])

    def close(self) -> None:
        if self._pool is not None:
            self._pool.close()


@dataclass(slots=True)
class Options:
    """`force`: do all anew; `verify`: compare outputs by their bytes; `store`: URL of a shared cache; `out`: the root
    of all outputs, which does not count as a source's surroundings."""

    out: Path
    force: bool = False
    verify: bool = False
    store: str = ""


@dataclass(slots=True)
class Farm:
    """A run over jobs. `on_start`, `on_done`: told of each job that goes to a worker, and of each outcome."""

    options: Options
    make_workers: Callable[[int], Workers]
    on_start: Callable[[Job], None] = lambda job: None
    on_done: Callable[[Outcome], None] = lambda outcome: None
    _stop: threading.Event = field(default_factory=threading.Event)
    _slots: threading.Semaphore = field(default_factory=threading.Semaphore)

    def look(self, jobs: Sequence[Job]) -> Iterator[tuple[Job, Record | None, Verdict]]:
        """What would have to be done, and why; nothing is written."""
        digests = self._digests()
        for job in jobs:
            record = read_record(record_path(job))
            try:
                importer = find_importer(job.source)
                verdict = judge(record, job, importer, digests, hash_outputs=self.options.verify)
                refused = read_record(refusal_path(job)) if not verdict.fresh else None
                if refused is not None and judge(refused, job, importer, digests, hash_outputs=False).fresh:
                    record, verdict = refused, Verdict()
            except (InputError, OSError):
                verdict = Verdict(["it cannot be read"])  # a worker will say it at length
            if self.options.force:
                verdict = Verdict(["it is forced", *verdict.reasons])
            yield job, record, verdict

    def run(self, jobs: Sequence[Job], size: int) -> list[Outcome]:
        """The outcomes in the order of `jobs`. KeyboardInterrupt stops the workers and goes through.

        Raises OutputError where the output folder can be none."""
        if self.options.out.exists() and not self.options.out.is_dir():
            hint = "choose another --out"
            raise OutputError("the output must be a folder; a file has that name", where=self.options.out, hint=hint)
        self._sweep(jobs)
        outcomes: dict[int, Outcome] = {}
        waiting: list[tuple[int, Job, Record | None, Verdict]] = []
        for number, (job, record, verdict) in enumerate(self.look(jobs)):
            if verdict.fresh and record is not None:
                outcomes[number] = _known(job, record)
                self.on_done(outcomes[number])
            else:
                waiting.append((number, job, record, verdict))
        if waiting:
            self._work(waiting, outcomes, min(size, len(waiting)))
            self._sweep(jobs)  # workers of a run that was killed may have outlived it until now
        return [outcomes[number] for number in sorted(outcomes)]

    def _work(
        self, waiting: list[tuple[int, Job, Record | None, Verdict]], outcomes: dict[int, Outcome], size: int
    ) -> None:
        workers = self.make_workers(size)
        # more threads than workers: while one waits for the disk, another has work for the worker
        threads = ThreadPoolExecutor(workers.size * AHEAD, thread_name_prefix="farm")
        self._slots = threading.Semaphore(workers.size)
        try:
            running: dict[Future[Outcome], int] = {}
            # the largest first: a long one that starts last would keep the others waiting
            order = sorted(waiting, key=lambda item: -_size(item[1].source))
            for number, job, record, verdict in order:
                running[threads.submit(self._one, workers, job, record, verdict)] = number
            while running:
                # with a time limit, so that Ctrl-C gets through on every system
                done, _ = wait(running, timeout=0.5, return_when=FIRST_COMPLETED)
                for future in done:
                    outcome = future.result()
                    outcomes[running.pop(future)] = outcome
                    self.on_done(outcome)
        finally:
            self._stop.set()
            threads.shutdown(wait=False, cancel_futures=True)
            workers.close()
            threads.shutdown(wait=True)
            self._stop.clear()

    def _one(self, workers: Workers, job: Job, old: Record | None, verdict: Verdict) -> Outcome:
        if self._stop.is_set():
            return refusal(job, LucarnaError("stopped", where=job.source))
        clock = _Clock()
        try:
            outcome = self._convert(workers, job, old, verdict, clock)
        except LucarnaError as error:
            outcome = refusal(job, error)
            outcome.reasons = verdict.reasons
        outcome.seconds = clock.seconds()
        return outcome

    def _convert(self, workers: Workers, job: Job, old: Record | None, verdict: Verdict, clock: _Clock) -> Outcome:
        known = self._from_cache(job, old, verdict)
        if known is not None:
            return known
        out = frozenset({str(self.options.out.absolute())})
        request = request_for(
            job.source, job.name, job.settings, force=self.options.force, ignored=out, store=self.options.store
        )
        with self._slots:
            if self._stop.is_set():
                raise LucarnaError("stopped", where=job.source)
            self.on_start(job)
            clock.start()
            reply, folder = workers.perform(request, job)
        record = record_from(reply)
        _rename_findings(record, job)
        if record.error:
            with contextlib.suppress(LucarnaError):  # it saves time only
                write_record(refusal_path(job), record, job.source)
            return _failed(job, record, verdict.reasons)
        remember(job, record)
        state = "cached" if reply["cached"] else "converted"
        if verdict.uncertain and old is not None and old.key == record.key:
            record.stamps = old.stamps
            write_record(record_path(job), record, job.source)
            return _known(job, record)
        try:
            outputs, removed = publish(folder, record, old, job)
        except EntryLost:
            with self._slots:
                reply, folder = workers.perform(request, job)
            outputs, removed = publish(folder, record, old, job)
        outcome = Outcome(
            job, state, verdict.reasons, outputs, record.findings, timings=reply["timings"], removed=removed
        )
        return _complete(outcome, record)

    def _from_cache(self, job: Job, old: Record | None, verdict: Verdict) -> Outcome | None:
        """Without a worker, where an earlier run is remembered, whatever its output folder, and the cache has it."""
        if self.options.force:
            return None
        record = remembered_record(job, self._digests())
        entry = Cache().recall(record.key, job.source) if record is not None else None
        if record is None or entry is None:
            return None
        _rename_findings(record, job)
        try:
            outputs, removed = publish(entry.folder, record, old, job)
        except EntryLost:
            return None
        outcome = Outcome(job, "cached", verdict.reasons, outputs, record.findings, removed=removed)
        return _complete(outcome, record)

    def _digests(self) -> Digests:
        return Digests(frozenset({str(self.options.out.absolute())}))

    def _sweep(self, jobs: Sequence[Job]) -> None:
        for folder in {job.folder / FOLDER for job in jobs} | {user_cache_dir() / "converted"}:
            sweep(folder)


class _Clock:
    """The time of a job from when a worker had it."""

    def __init__(self) -> None:
        self._started = 0.0

    def start(self) -> None:
        self._started = time.perf_counter()

    def seconds(self) -> float:
        return time.perf_counter() - self._started if self._started else 0.0


def _known(job: Job, record: Record) -> Outcome:
    """What the record says, which still holds."""
    _rename_findings(record, job)
    if record.error:
        return _failed(job, record, [])
    return _complete(Outcome(job, "up to date", [], record.made(), record.findings), record)


def _failed(job: Job, record: Record, reasons: list[str]) -> Outcome:
    """A refusal; without reasons, one that is known since an earlier run."""
    return _complete(Outcome(job, "failed", reasons, error=record.error, exit_code=record.exit_code), record)


def _complete(outcome: Outcome, record: Record) -> Outcome:
    outcome.scene, outcome.key = record.scene, record.key
    outcome.inputs = [path for _, path, _ in record.inputs[1:]]
    outcome.folders = [path for path, _ in record.listed]
    return outcome


def _rename_findings(record: Record, job: Job) -> None:
    """Findings name the file as it is called here, wherever they were made."""
    for finding in record.findings:
        finding["where"] = {**finding["where"], "file": str(job.source)}


def _size(path: Path) -> int:
    try:
        return path.stat().st_size
    except OSError:
        return 0
