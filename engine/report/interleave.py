"""Interleaved timing: A B C A B C …, so that a machine that warms up or is disturbed treats all alike."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence

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
    samples: list[list[float]] = [[] for _ in runs]
    for _ in one_by_one(runs, samples, repeats=repeats, warm_up=warm_up, budget_s=budget_s, clocks=clocks):
        pass
    return samples


def one_by_one(
    runs: Sequence[Callable[[], object]], samples: list[list[float]], *, repeats: int = 30, warm_up: int = 2,
    budget_s: float = 20.0, clocks: Sequence[Clock] | None = None,
) -> Iterator[float]:  # fmt: skip
    """As `interleaved`, into `samples`, with a pause after every run for whoever has else to do: yields how much is
    done, 0 to 1. Only the runs' own time counts towards the budget."""
    clocks = clocks or [wall_clock] * len(runs)
    spent, total = 0.0, max(1, (repeats + warm_up) * len(runs))
    done = 0
    for round_number in range(-warm_up, repeats):
        if round_number >= LEAST and spent > budget_s:
            break
        if round_number < -1 and spent > budget_s / 4.0:
            continue  # too slow for another warm-up round
        for i in range(len(runs)):
            at = (i + round_number) % len(runs)
            started = time.perf_counter()
            ms = clocks[at](runs[at])
            spent += time.perf_counter() - started
            if round_number >= 0:
                samples[at].append(ms)
            done += 1
            yield min(1.0, max(done / total, spent / budget_s if round_number >= LEAST else 0.0))
