"""How far a run is: one line of a terminal that is written over again, nothing where stderr is no terminal."""

from __future__ import annotations

import sys
import threading
import time
from pathlib import Path
from typing import TextIO

from importers.farm.job import Job, Outcome

#: seconds between two lines; seconds after which a file at work is called slow
EVERY, SLOW = 0.1, 2.0


class ProgressLine:
    """`[12/333] 4.1/s  8 converted, 3 up to date, 1 failed  0:42 left  slow: barn.fbx 6 s`."""

    def __init__(self, total: int, stream: TextIO | None = None) -> None:
        self._stream = stream or sys.stderr
        self.shown = self._stream.isatty()
        self._total, self._done = total, 0
        self._states: dict[str, int] = {}
        self._running: dict[Path, float] = {}
        self._started, self._last = time.monotonic(), 0.0
        self._worked = 0
        self._lock = threading.Lock()
        self._over = threading.Event()
        if self.shown:
            threading.Thread(target=self._tick, daemon=True).start()

    def start(self, job: Job) -> None:
        with self._lock:
            self._running[job.source] = time.monotonic()

    def done(self, outcome: Outcome) -> None:
        with self._lock:
            self._worked += self._running.pop(outcome.job.source, None) is not None
            self._done += 1
            self._states[outcome.state] = self._states.get(outcome.state, 0) + 1

    def text(self, now: float) -> str:
        """The line at the monotonic time `now`."""
        with self._lock:
            spent = max(now - self._started, 1e-6)
            rate = self._done / spent
            counts = ", ".join(f"{count} {state}" for state, count in self._states.items())
            parts = [f"[{self._done}/{self._total}]", f"{rate:.1f}/s" if self._done else "", counts]
            left = self._total - self._done
            if self._worked and left:
                seconds = int(left * spent / max(self._worked, 1))
                parts.append(f"{seconds // 60}:{seconds % 60:02d} left")
            slow = sorted(self._running.items(), key=lambda item: item[1])
            named = [f"{path.name} {now - since:.0f} s" for path, since in slow[:2] if now - since > SLOW]
            if named:
                parts.append("slow: " + ", ".join(named))
        return "  ".join(part for part in parts if part)

    def clear(self) -> None:
        """Take the line away, so that something else can be printed."""
        if self.shown:
            print("\r\033[K", end="", file=self._stream, flush=True)

    def close(self) -> None:
        self._over.set()
        self.clear()

    def _tick(self) -> None:
        import shutil

        while not self._over.wait(EVERY):
            width = shutil.get_terminal_size().columns - 1
            print(f"\r\033[K{self.text(time.monotonic())[:width]}", end="", file=self._stream, flush=True)
