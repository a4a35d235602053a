"""`--watch`: look at everything that the last run read, and run again when something changed.

Files are looked at (mtime and size), which works on network mounts, too; whether a change matters is then decided by
content, as always. A burst of changes, as of an exporter that writes ten files, is waited for.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Protocol

from engine.core.errors import LucarnaError
from engine.core.watched import Watched
from importers.farm.job import Outcome
from importers.farm.plan import Plan
from importers.farm.run import Farm
from importers.presets import PRESETS_FOLDER, PROJECT_FILE, sidecar_path

#: seconds between two looks; seconds without a change after which a burst is over
POLL, QUIET = 0.25, 0.3


class Listener(Protocol):
    def begin(self, total: int) -> None: ...
    def again(self, outcomes: Sequence[Outcome], gone: Sequence[Path]) -> None: ...
    def close(self) -> None: ...


def watch(
    replan: Callable[[], Plan], plan: Plan, outcomes: Sequence[Outcome], farm: Farm, size: int, listener: Listener,
    stopped: Callable[[], bool] = lambda: False,
) -> None:  # fmt: skip
    """Go on until Ctrl-C, or until `stopped()`. New files are found, vanished ones are told of; mistakes in sidecars
    and presets are printed and waited out."""
    try:
        while not stopped():
            watched = Watched()
            watched.add(_everything(plan, outcomes))
            while not watched.changed():
                if stopped():
                    return
                time.sleep(POLL)
            _settle(watched)
            before = {job.source for job in plan.jobs}
            try:
                plan = replan()
                listener.begin(len(plan.jobs))
                outcomes = [*plan.refused, *farm.run(plan.jobs, size)]
            except LucarnaError as error:
                print(f"lucarna: error: {error}", file=sys.stderr, flush=True)
                continue
            finally:
                listener.close()
            for refused in plan.refused:
                farm.on_done(refused)
            gone = sorted(before - {job.source for job in plan.jobs} - {o.job.source for o in plan.refused})
            listener.again([o for o in outcomes if o.reasons], gone)
    except KeyboardInterrupt:
        print("stopped", file=sys.stderr)


def _settle(watched: Watched) -> None:
    """Wait until nothing has changed for a while."""
    watched.take()
    quiet_since = time.monotonic()
    while time.monotonic() - quiet_since < QUIET:
        time.sleep(POLL / 5)
        if watched.take():
            quiet_since = time.monotonic()


def _everything(plan: Plan, outcomes: Sequence[Outcome]) -> list[Path]:
    """The files that were read, their sidecars, the folders that were searched, and the projects around them."""
    paths: dict[Path, None] = dict.fromkeys(plan.folders)
    parents: set[Path] = set()
    for outcome in outcomes:
        source = outcome.job.source
        read = (source.parent / path for path in (*outcome.inputs, *outcome.folders))
        paths |= dict.fromkeys([source, sidecar_path(source), *read])
        parents.add(source.parent.absolute())
    for folder in {above for parent in parents for above in (parent, *parent.parents)}:
        project = folder / PROJECT_FILE
        paths[project] = None
        if project.is_file():
            presets = folder / PRESETS_FOLDER
            paths |= dict.fromkeys([presets, *presets.glob("*.toml")])
    return list(paths)
