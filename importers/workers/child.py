"""The worker's side: `python -m importers.workers.child FOLDER` does what FOLDER/request.json asks and leaves at once.

It leaves by os._exit: native libraries may crash while Python tidies up, when the result is long written.
"""

from __future__ import annotations

import importlib
import json
import os
import sys
from pathlib import Path

from importers.workers.limits import follow_parent, set_limits
from importers.workers.runner import FAILURE, REQUEST, RESULT, SCHEMA


def main(folder: Path) -> int:
    """Exit code: 0 with a result or a failure file written, 1 otherwise."""
    follow_parent()
    return work(folder)


def work(folder: Path) -> int:
    """The same, where somebody else sees to it that we end with our parent."""
    order = json.loads((folder / REQUEST).read_text(encoding="utf-8"))
    set_limits(float(order["seconds"]), int(order["memory_bytes"]))
    from engine.assets.container import write_container
    from engine.core.atomic import relaxed
    from engine.core.errors import FormatError, InputError

    try:
        module, function = str(order["task"]).split(":")
        data, arrays = getattr(importlib.import_module(module), function)(order["request"])
        with relaxed(folder):
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
