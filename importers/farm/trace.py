"""Which files and folders an import really looked at, by Python's own audit events: no importer can forget one.

`open`, `os.listdir` and `os.scandir` are raised by the interpreter (PEP 578) whoever calls. An audit hook cannot be
taken away again, so there is one for the process, which is deaf while nothing is traced.
"""

from __future__ import annotations

import os
import sys
import sysconfig
import threading
from pathlib import Path
from types import TracebackType
from typing import Any

_WRITES = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_APPEND
_current: list[Trace] = []
_hooked: list[bool] = []


class Trace:
    """While it is entered, `files` and `folders` collect what is opened for reading and listed, as absolute paths.
    What lies below `ignored` does not count, nor do Python and Lucarna themselves. `own_thread`: what other threads do
    is none of ours (in a worker process it is: an import may have threads)."""

    def __init__(self, ignored: tuple[Path, ...] = (), *, own_thread: bool = False) -> None:
        self._thread = threading.get_ident() if own_thread else 0
        self.files: dict[str, None] = {}
        self.folders: dict[str, None] = {}
        own = [sys.prefix, sys.base_prefix, sysconfig.get_path("stdlib"), str(Path(__file__).resolve().parents[2])]
        # not all of the checkout: sources may lie in it
        own = [*own[:3], *(os.path.join(own[3], name) for name in ("engine", "importers", "shaders", "lucarna_data"))]  # noqa: PTH118  (texts)
        roots = [*own, "/proc", "/sys", "/dev", *map(str, ignored)]
        self._ignored = tuple(os.path.abspath(root).rstrip(os.sep) + os.sep for root in roots if root != os.sep)  # noqa: PTH100  (texts)

    def __enter__(self) -> Trace:
        if not _hooked:
            _hooked.append(True)
            sys.addaudithook(_hear)
        _current.append(self)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        _current.remove(self)

    def note(self, event: str, args: tuple[Any, ...]) -> None:
        if self._thread and self._thread != threading.get_ident():
            return
        if not args or not isinstance(args[0], (str, bytes, os.PathLike)):
            return
        if event == "open" and isinstance(args[2], int) and args[2] & _WRITES:
            return
        path = os.path.abspath(os.fsdecode(args[0]))  # noqa: PTH100  (called for every file of every import)
        if not path.startswith(self._ignored):
            (self.files if event == "open" else self.folders)[path] = None


def _hear(event: str, args: tuple[Any, ...]) -> None:
    if _current and event in ("open", "os.listdir", "os.scandir"):
        for trace in _current:
            trace.note(event, args)
