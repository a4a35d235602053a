"""The same jobs on a Dask cluster: `dask scheduler` and `dask worker tcp://host:8786` as its documentation says.

    host ─ request ─> scheduler ─> Dask worker ─> its own pool of importer processes ─> reply
                                                  entry: shared store (--cache URL), the same cache folder, or the reply

A Dask worker that dies costs nothing: the scheduler gives its tasks to another. A parser that crashes costs one file:
it runs in a process of the worker's pool. The machines must see the sources under the same paths. Needs the extra
`farm`, and the same version of Lucarna everywhere.
"""

from __future__ import annotations

import io
import threading
import uuid
import zipfile
from pathlib import Path
from typing import Any

from engine.core.errors import FormatError, LucarnaError, OutputError, UsageError
from engine.core.paths import user_cache_dir
from importers import cache
from importers.farm.job import Job
from importers.farm.single import limits_for
from importers.farm.task import TASK
from importers.workers.pool import WorkerPool
from importers.workers.process import WorkerLimits

#: seconds to find the scheduler
CONNECT = 15.0
#: requests under way per thread of the cluster, so that none of them waits for the next
AHEAD = 2
_pool_lock = threading.Lock()


class ClusterWorkers:
    """The workers of the scheduler at `address`. Raises UsageError, LucarnaError where there is none."""

    def __init__(self, address: str, store: str = "") -> None:
        try:
            from distributed import Client
        except ImportError as error:
            raise LucarnaError("--scheduler needs Dask", hint="pip install 'lucarna[farm]'") from error
        try:
            self._client = Client(address, timeout=CONNECT, set_as_default=False)
        except (OSError, ValueError) as error:
            raise UsageError(
                f"no Dask scheduler answers at {address}: {error}", hint="start one: `dask scheduler`, then "
                f"`dask worker {address}` on each machine",
            ) from error  # fmt: skip
        self._store = store
        threads = sum(self._client.nthreads().values())
        self.size = max(1, threads) * AHEAD

    def perform(self, request: dict[str, Any], job: Job) -> tuple[dict[str, Any], Path]:
        """As run.Workers. Sources are named by their absolute path."""
        root = user_cache_dir() / "converted"
        limits = limits_for(job.settings)
        here = "" if self._store else f"{cache.owner().split('-')[0]} {root.absolute()}"
        request = request | {"source": str(job.source.absolute())}
        future = self._client.submit(
            perform_on_cluster, request, limits.seconds, limits.memory_bytes, here,
            key=f"lucarna-{uuid.uuid4().hex}", pure=False,
        )  # fmt: skip
        try:
            reply: dict[str, Any] = future.result()
        except LucarnaError:
            raise
        except Exception as error:  # the cluster's own: KilledWorker, CommClosedError, CancelledError …
            raise OutputError(
                f"the cluster gave up: {type(error).__name__}: {error}", where=job.source,
                hint="look at the workers' logs",
            ) from error  # fmt: skip
        finally:
            future.release()
        if "raised" in reply:
            kind, message = reply["raised"]
            tree = {"FormatError": FormatError, "OutputError": OutputError}.get(kind, LucarnaError)
            raise tree(message)
        if reply["error"]:
            return reply, root
        return reply, self._fetch(reply, job)

    def close(self) -> None:
        self._client.close()

    def _fetch(self, reply: dict[str, Any], job: Job) -> Path:
        """The entry's folder in our own cache."""
        local = cache.Cache(self._store)
        archive = reply.pop("archive", None)
        if archive is not None:
            local.take_in(str(reply["key"]), archive)
        entry = local.recall(str(reply["key"]), job.source)
        if entry is None:
            raise OutputError("the cluster's result did not arrive", where=job.source, hint="give a --cache URL that "
                              "all machines reach")  # fmt: skip
        return entry.folder


def perform_on_cluster(request: dict[str, Any], seconds: float, memory_bytes: int, here: str) -> dict[str, Any]:
    """What a Dask worker runs: the task in a process of its pool. `here`: the machine and cache folder that asked; the
    result is sent along as an archive if this is another one. Errors are returned, as Dask would run them again."""
    from distributed import get_worker

    worker = get_worker()
    with _pool_lock:
        pool = getattr(worker, "lucarna_pool", None)
        if pool is None:
            pool = worker.lucarna_pool = WorkerPool(worker.state.nthreads)
    source = Path(request["source"])
    try:
        reply: dict[str, Any] = pool.run(TASK, request, source, WorkerLimits(seconds, memory_bytes))
    except LucarnaError as error:
        return {"raised": [type(error).__name__, str(error)]}
    root = user_cache_dir() / "converted"
    if here and not reply["error"] and here != f"{cache.owner().split('-')[0]} {root.absolute()}":
        folder, packed = root / reply["key"], io.BytesIO()
        with zipfile.ZipFile(packed, "w") as archive:
            for name in [*(item["name"] for item in reply["outputs"]), cache.RECORD]:
                archive.write(folder / name, name)
        reply["archive"] = packed.getvalue()
    return reply
