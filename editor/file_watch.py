"""FileWatch: files that frames look at themselves, looked at by a thread while there are no frames. No imgui.

texts, prefabs, plug-ins, listed folders ──follow──► thread: stamps, four times a second ──a change──► wake()
the frame that it brings looks as it always did, and finds what has changed
"""

from __future__ import annotations

import threading
from collections.abc import Iterable
from pathlib import Path

from editor.waking import wake
from engine.core.watched import Watched

#: seconds between two looks
LOOK = 0.25
#: more are not followed: their folders are
LIMIT = 2000


class FileWatch:
    """The thread runs while there is something to follow."""

    def __init__(self) -> None:
        self._paths: frozenset[Path] = frozenset()
        self._watched = Watched()
        self._more = threading.Condition()
        self._stopped = False
        self._thread: threading.Thread | None = None

    def follow(self, paths: Iterable[Path]) -> bool:
        """Look at these from now on, and at no others; whether there are new ones, which may have changed since a frame
        last looked."""
        wanted = frozenset(path for path, _ in zip(paths, range(LIMIT), strict=False))
        if wanted == self._paths:
            return False
        new = wanted - self._paths
        self._watched.keep(wanted)
        self._watched.add(new)
        with self._more:
            self._paths = wanted
            self._more.notify()
        if self._thread is None and wanted:
            self._thread = threading.Thread(target=self._run, name="file watch", daemon=True)
            self._thread.start()
        return bool(new)

    def stop(self) -> None:
        """End the thread."""
        with self._more:
            self._stopped = True
            self._more.notify()

    def _run(self) -> None:
        while True:
            with self._more:
                self._more.wait(LOOK if self._paths else None)
                if self._stopped:
                    return
            if self._watched.take():
                wake()
