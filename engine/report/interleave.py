"""Interleaved timing: A B C A B C …, so that a machine that warms up or is disturbed treats all alike."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

#: measures one call in ms
Clock = Callable[[Callable[[], object]], float]

#: least repeats, however slow: a median of fewer says nothing
LEAST = 5


def wall_clock(run: Callable[[], object]) -> float:
    """Milliseconds of one call by the CPU's clock."""
    start = time.perf_counter_ns()
    run()
    return (time.perf_counter_ns() - start) / 1e6


def interleaved(
    runs: Sequence[Callable[[], object]], *, repeats: int = 30, warm_up: int = 2, budget_s: float = 20.0,
    clocks: Sequence[Clock] | None = None,
) -> list[list[float]]:  # fmt: skip
    """Milliseconds of each run, `repeats` each (fewer, but at least LEAST, once `budget_s` seconds are spent).

    Every round runs all of them once, in an order that rotates, so that none always follows the same other.
    `clocks[i]` times run i (default: the wall clock).
    """
    clocks = clocks or [wall_clock] * len(runs)
    samples: list[list[float]] = [[] for _ in runs]
    started = time.perf_counter()
    for round_number in range(-warm_up, repeats):
        spent = time.perf_counter() - started
        if round_number >= LEAST and spent > budget_s:
            break
        if round_number < -1 and spent > budget_s / 4.0:
            continue  # too slow for another warm-up round
        for i in range(len(runs)):
            at = (i + round_number) % len(runs)
            ms = clocks[at](runs[at])
            if round_number >= 0:
                samples[at].append(ms)
    return samples
