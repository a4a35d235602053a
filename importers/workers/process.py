"""What both ways of running a worker share: its limits, its environment, and words for how it ended."""

from __future__ import annotations

import os
import signal
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True)
class WorkerLimits:
    """`seconds` of wall-clock time; `memory_bytes` of address space (0 = none; not enforced on Windows)."""

    seconds: float = 300.0
    memory_bytes: int = 4 << 30


def environment() -> dict[str, str]:
    """Our packages importable, and one thread per numerical library: they reserve address space for each."""
    values = dict(os.environ)
    packages = str(Path(__file__).resolve().parents[2])
    values["PYTHONPATH"] = os.pathsep.join(p for p in (packages, values.get("PYTHONPATH")) if p)
    return values | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}


def usable_cores() -> int:
    """Cores that this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # not on Windows and macOS
        return os.cpu_count() or 1


def memory_text(limits: WorkerLimits) -> str:
    return f"{limits.memory_bytes / 2**30:.3g} GiB" if limits.memory_bytes else "what the machine has"


def spell_ending(code: int) -> str:
    """What an exit code says: `crashed (SIGSEGV)`."""
    if code < 0:
        try:
            name = signal.Signals(-code).name
        except ValueError:
            name = f"signal {-code}"
        if name == "SIGXCPU":
            return "used up its processor time"
        if name == "SIGKILL":
            return "was killed (SIGKILL), perhaps because the machine ran out of memory"
        return f"crashed ({name})"
    if os.name == "nt" and code & 0xC0000000 == 0xC0000000:
        return f"crashed (0x{code:08X})"
    return f"ended with code {code} and left no result"


def last_line(log: bytes) -> str:
    """The last line that a worker printed, for bug reports."""
    lines = log.decode("utf-8", "replace").strip().splitlines()
    return lines[-1][:200] if lines else ""
