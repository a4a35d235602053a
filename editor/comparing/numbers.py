"""FLIP of two pictures, found by a worker process: it takes half a second, and holds whoever asks for it."""

from __future__ import annotations

import tempfile
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import LucarnaError

Pixels = NDArray[np.uint8]


def flip_of_files(request: dict[str, Any], _progress: object = None) -> dict[str, Any]:
    """The worker's task: mean FLIP of the PNGs `a` and `b`."""
    from engine.report.image import load_png
    from engine.report.perceptual import flip

    return {"flip": flip(load_png(Path(request["a"]))[:, :, :3], load_png(Path(request["b"]))[:, :, :3])[0]}


def flip_apart(a: Pixels, b: Pixels) -> float:
    """Mean FLIP by a process of its own. Raises LucarnaError."""
    from engine.report.image import save_png
    from importers.workers.pool import WorkerPool
    from importers.workers.process import WorkerLimits

    with tempfile.TemporaryDirectory(prefix="lucarna-compare-") as folder, WorkerPool(1) as pool:
        files = {"a": str(Path(folder) / "a.png"), "b": str(Path(folder) / "b.png")}
        save_png(Path(files["a"]), np.ascontiguousarray(a[:, :, :3]))
        save_png(Path(files["b"]), np.ascontiguousarray(b[:, :, :3]))
        limits = WorkerLimits(seconds=60.0, memory_bytes=0)
        found = pool.run("editor.comparing.numbers:flip_of_files", files, Path(files["a"]), limits, "FLIP")
        return float(found["flip"])


class FlipAside:
    """`ask` for two pictures; `answer` (about which two, FLIP or what went wrong) when it is there.

    One at a time: while one is worked on, only the last that was asked for waits."""

    def __init__(self, find: Callable[[Pixels, Pixels], float] = flip_apart) -> None:
        self._find = find
        self._lock = threading.Lock()
        self._waiting: tuple[object, Pixels, Pixels] | None = None
        self._running = False
        self.answer: tuple[object, float | str] | None = None

    def ask(self, about: object, a: Pixels, b: Pixels) -> None:
        with self._lock:
            self._waiting = (about, a, b)
            if self._running:
                return
            self._running = True
        threading.Thread(target=self._run, name="flip", daemon=True).start()

    def _run(self) -> None:
        while True:
            with self._lock:
                if self._waiting is None:
                    self._running = False
                    return
                about, a, b = self._waiting
                self._waiting = None
            try:
                found: float | str = self._find(a, b)
            except (LucarnaError, OSError) as error:
                found = str(error)
            self.answer = (about, found)
