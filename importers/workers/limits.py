"""Limits that a worker sets on itself, so that they hold even where its host is gone. There are none on Windows.

Memory is limited as address space (RLIMIT_AS, Linux; macOS refuses it), time as processor seconds (RLIMIT_CPU, POSIX).
On Windows only the host's clock stops a worker; memory is then bounded by the readers' own limits alone.
"""

from __future__ import annotations

import os
import sys
import threading
from pathlib import Path


def follow_parent() -> None:
    """End when the parent does: its end of our standard input closes."""

    def watch() -> None:
        sys.stdin.buffer.read()
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def set_limits(seconds: float, memory_bytes: int) -> None:
    """From now on at most so many seconds of processor time per core, and so much address space (0 = no limit).

    May be called again, with other limits, before each piece of work."""
    try:
        import resource
    except ImportError:
        return
    used = resource.getrusage(resource.RUSAGE_SELF)
    processor = int(used.ru_utime + used.ru_stime + seconds * (os.cpu_count() or 1)) + 5
    wanted = [(resource.RLIMIT_CPU, processor), (resource.RLIMIT_AS, memory_bytes or resource.RLIM_INFINITY)]
    for kind, amount in (*wanted, (resource.RLIMIT_CORE, 0)):
        hard = resource.getrlimit(kind)[1]
        if hard != resource.RLIM_INFINITY and (amount == resource.RLIM_INFINITY or amount > hard):
            amount = hard
        try:
            resource.setrlimit(kind, (amount, hard))
        except (ValueError, OSError):
            continue  # macOS refuses RLIMIT_AS; the time limit still holds


def resident_bytes() -> int:
    """Memory that this process holds now; 0 where the system does not say."""
    try:
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
        return pages * os.sysconf("SC_PAGE_SIZE")
    except (OSError, ValueError, IndexError, AttributeError):
        return 0
