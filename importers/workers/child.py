"""The worker's side: `python -m importers.workers.child FOLDER` does what FOLDER/request.json asks and leaves at once.

It leaves by os._exit: native libraries may crash while Python tidies up, when the result is long written.
"""

from __future__ import annotations

import importlib
import json
import os
import sys
import threading
from pathlib import Path

from importers.workers.runner import FAILURE, REQUEST, RESULT, SCHEMA


def main(folder: Path) -> int:
    """Exit code: 0 with a result or a failure file written, 1 otherwise."""
    order = json.loads((folder / REQUEST).read_text(encoding="utf-8"))
    _follow_parent()
    _set_limits(float(order["seconds"]), int(order["memory_bytes"]))
    from engine.assets.container import write_container
    from engine.core.errors import FormatError, InputError

    try:
        module, function = str(order["task"]).split(":")
        data, arrays = getattr(importlib.import_module(module), function)(order["request"])
        write_container(folder / RESULT, {"schema": SCHEMA, "data": data}, arrays)
    except MemoryError:
        _fail(folder, "memory", "")
    except InputError as error:
        kind = "format" if isinstance(error, FormatError) else "input"
        _fail(folder, kind, error.message, error.hint, error.where.path)
    return 0


def _fail(folder: Path, kind: str, message: str, hint: str = "", path: str = "") -> None:
    text = json.dumps({"kind": kind, "message": message, "hint": hint, "path": path})
    temporary = folder / f"{FAILURE}.part"
    temporary.write_text(text, encoding="utf-8")
    temporary.replace(folder / FAILURE)


def _follow_parent() -> None:
    """End when the parent does: its end of our standard input closes."""

    def watch() -> None:
        sys.stdin.buffer.read()
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def _set_limits(seconds: float, memory_bytes: int) -> None:
    """Limits that hold even where the parent is gone or cannot stop us. There are none on Windows."""
    try:
        import resource
    except ImportError:
        return
    processor = int(seconds) + 5
    for kind, amount in (
        (resource.RLIMIT_CPU, processor),
        (resource.RLIMIT_AS, memory_bytes),
        (resource.RLIMIT_CORE, 0),
    ):
        if amount > 0 or kind == resource.RLIMIT_CORE:
            hard = resource.getrlimit(kind)[1]
            wanted = amount if hard == resource.RLIM_INFINITY else min(amount, hard)
            try:
                resource.setrlimit(kind, (wanted, hard))
            except (ValueError, OSError):
                continue  # macOS refuses RLIMIT_AS; the time limit still holds


if __name__ == "__main__":
    import traceback

    try:
        _code = main(Path(sys.argv[1]))
    except BaseException:  # the process boundary: whatever it is, the host reads it from the log
        traceback.print_exc()
        _code = 1
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(_code)
