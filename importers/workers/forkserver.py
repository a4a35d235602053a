"""Linux: `python -m importers.workers.forkserver MODULE` imports MODULE once and forks a fresh child for each folder.

    in   FOLDER, a line each          out  `pid N`, then `code N` (negative: the signal)

The copy is as fresh as a new process, since this one has one thread and has only imported; it costs a millisecond
instead of a fifth of a second. Ends, with its child, when its input does.
"""

from __future__ import annotations

import importlib
import os
import select
import signal
import sys
import threading
import time
from pathlib import Path
from typing import NoReturn

#: seconds between looks at whether the parent is still there
LOOK = 0.5


def main(module: str) -> None:
    for name in (module, "importers.workers.child", "engine.assets.container", "engine.core.errors"):
        importlib.import_module(name)
    waiting = b""
    while True:
        line, _, waiting = waiting.partition(b"\n")
        if not line:
            data = os.read(0, 65536)
            if not data:
                return
            waiting = data
            continue
        _serve(Path(os.fsdecode(line)))


def _serve(folder: Path) -> None:
    ends, held = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(ends)
        _child(folder)
    os.close(held)
    os.write(1, f"pid {child}\n".encode())
    # the pipe closes with the child, our input with the host
    ready, _, _ = select.select([ends, 0], [], [])
    if ends not in ready:
        os.kill(child, signal.SIGKILL)
    _, status = os.waitpid(child, 0)
    os.close(ends)
    os.write(1, f"code {os.waitstatus_to_exitcode(status)}\n".encode())


def _child(folder: Path) -> NoReturn:
    from importers.workers import child
    from importers.workers.runner import LOG

    parent = os.getppid()
    code = 1
    try:
        log = os.open(folder / LOG, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        nothing = os.open(os.devnull, os.O_RDONLY)
        for source, target in ((nothing, 0), (log, 1), (log, 2)):
            os.dup2(source, target)
        threading.Thread(target=_follow, args=(parent,), daemon=True).start()
        code = child.work(folder)
    except BaseException:  # the process boundary: whatever it is, the host reads it from the log
        import traceback

        traceback.print_exc()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


def _follow(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(LOOK)
    os._exit(1)


if __name__ == "__main__":
    main(sys.argv[1])
    os._exit(0)
