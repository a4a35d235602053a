"""Baking surroundings in a thread, so that whoever draws goes on drawing.

get(key, bake) ──► known: its file, or what was wrong ──► not yet: None, and a thread makes it ──► `told`
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Hashable
from pathlib import Path

from engine.core.errors import InputError, LucarnaError

#: seconds to wait for one that was baked before and is only looked up
PATIENCE = 0.15


class BackgroundBakes:
    """`done` grows with each one that is finished; `told` is then called from its thread."""

    def __init__(self, told: Callable[[], None]) -> None:
        self._told = told
        self._lock = threading.Lock()
        self._threads: dict[Hashable, threading.Thread] = {}
        self._found: dict[Hashable, Path | InputError] = {}
        self.done = 0

    @property
    def waiting(self) -> int:
        """How many are being made."""
        with self._lock:
            return len(self._threads)

    def get(self, key: Hashable, bake: Callable[[], Path]) -> Path | None:
        """What `bake` makes of `key`; None while it does. Raises InputError where it cannot."""
        with self._lock:
            found, thread = self._found.pop(key, None), self._threads.get(key)
            if found is None and thread is None:
                thread = threading.Thread(target=self._run, args=(key, bake), daemon=True, name="surroundings")
                self._threads[key] = thread
                thread.start()
                patience = PATIENCE
            else:
                patience = 0.0
        if found is None and thread is not None and patience:
            thread.join(patience)
            with self._lock:
                found = self._found.pop(key, None)
        if isinstance(found, InputError):
            raise found
        return found

    def _run(self, key: Hashable, bake: Callable[[], Path]) -> None:
        found: Path | InputError
        try:
            found = bake()
        except InputError as error:
            found = error
        except (LucarnaError, OSError, ValueError, MemoryError) as error:
            found = InputError(f"the surroundings could not be baked: {error}")
        with self._lock:
            self._found[key] = found
            self._threads.pop(key, None)
            self.done += 1
        self._told()
