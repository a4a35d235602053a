"""A worker that stays: `python -m importers.workers.server` does one task per line of its standard input.

    in   {"task": "module:function", "request": {…}, "seconds": s, "memory_bytes": n}
    out  {"progress": [what, share]} …, then {"data": {…}} or {"failure": {…}}, with "resident": bytes held

The task is called with (request, progress) and returns JSON. What libraries print goes to the log, never between our
lines. It leaves by os._exit when its input ends, also in the middle of a task: its host is gone.
"""

from __future__ import annotations

import importlib
import json
import os
import queue
import sys
import threading
import traceback
from typing import Any, BinaryIO

from importers.workers import forker
from importers.workers.limits import resident_bytes, set_limits


def main() -> int:
    replies = os.fdopen(os.dup(1), "wb", buffering=0)
    os.dup2(2, 1)
    forker.enable()
    orders: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    threading.Thread(target=_read, args=(orders,), daemon=True).start()
    while True:
        order = json.loads(orders.get())
        set_limits(float(order["seconds"]), int(order["memory_bytes"]))
        reply = _perform(order, replies)
        reply["resident"] = resident_bytes()
        _send(replies, reply)


def _read(orders: queue.SimpleQueue[bytes]) -> None:
    for line in sys.stdin.buffer:
        orders.put(line)
    os._exit(0)


def _perform(order: dict[str, Any], replies: BinaryIO) -> dict[str, Any]:
    from engine.core.errors import FormatError, InputError, LucarnaError, OutputError

    def progress(what: str, share: float) -> None:
        _send(replies, {"progress": [what, share]})

    try:
        module, function = str(order["task"]).split(":")
        return {"data": getattr(importlib.import_module(module), function)(order["request"], progress)}
    except MemoryError:
        return _failure("memory", "")
    except LucarnaError as error:
        kinds = ((FormatError, "format"), (InputError, "input"), (OutputError, "output"), (LucarnaError, "other"))
        kind = next(name for tree, name in kinds if isinstance(error, tree))
        return _failure(kind, error.message, error.hint, str(error.where.path), error.where.file)
    except Exception as error:  # the process boundary: a defect in a reader costs this file, not the run
        traceback.print_exc()
        return _failure("bug", f"{type(error).__name__}: {error}")


def _failure(kind: str, message: str, hint: str = "", path: str = "", file: str = "") -> dict[str, Any]:
    return {"failure": {"kind": kind, "message": message, "hint": hint, "path": path, "file": file}}


def _send(replies: BinaryIO, value: dict[str, Any]) -> None:
    data = memoryview(json.dumps(value).encode("ascii") + b"\n")
    while data:
        data = data[replies.write(data) :]


if __name__ == "__main__":
    try:
        main()
    except BaseException:  # the process boundary: the host reads it from the log
        traceback.print_exc()
    sys.stderr.flush()
    os._exit(1)
