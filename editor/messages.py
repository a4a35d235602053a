"""The message log of a session: bounded, ordered, written from any thread."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass

from engine.core.errors import LucarnaError
from engine.core.findings import Finding, Severity


@dataclass(frozen=True, slots=True)
class Message:
    """`where`: file, line or object path; `hint`: what to do next. `clock` is local wall time, HH:MM:SS."""

    severity: Severity
    text: str
    where: str = ""
    hint: str = ""
    code: str = ""
    clock: str = ""

    def line(self) -> str:
        """One line of plain text, for the clipboard."""
        place = f"{self.where}: " if self.where else ""
        hint = f" ({self.hint})" if self.hint else ""
        return f"{self.clock} {self.severity.value}: {place}{self.text}{hint}"


class Messages:
    """Keeps the newest `limit` messages. `revision` grows with each one."""

    def __init__(self, limit: int = 5000) -> None:
        self._items: deque[Message] = deque(maxlen=limit)
        self._lock = threading.Lock()
        self.revision = 0

    def add(self, severity: Severity, text: str, *, where: str = "", hint: str = "", code: str = "") -> None:
        message = Message(severity, text, where, hint, code, time.strftime("%H:%M:%S"))
        with self._lock:
            self._items.append(message)
            self.revision += 1

    def info(self, text: str, **more: str) -> None:
        self.add(Severity.INFO, text, **more)

    def warn(self, text: str, **more: str) -> None:
        self.add(Severity.WARNING, text, **more)

    def error(self, problem: str | LucarnaError) -> None:
        if isinstance(problem, LucarnaError):
            self.add(Severity.ERROR, problem.message, where=str(problem.where), hint=problem.hint)
        else:
            self.add(Severity.ERROR, problem)

    def findings(self, findings: Iterable[Finding]) -> None:
        for f in findings:
            self.add(f.severity, f.message, where=str(f.where), hint=f.hint, code=f.code)

    def clear(self) -> None:
        with self._lock:
            self._items.clear()
            self.revision += 1

    def snapshot(self) -> list[Message]:
        with self._lock:
            return list(self._items)

    def counts(self) -> dict[Severity, int]:
        counts = dict.fromkeys(Severity, 0)
        for message in self.snapshot():
            counts[message.severity] += 1
        return counts
