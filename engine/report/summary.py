"""Summaries of repeated runs: median, quartiles, count. Means are left out: one hiccup of the machine moves them."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from engine.core.errors import UsageError


@dataclass(frozen=True, slots=True)
class Summary:
    """Of `n` samples: median, interquartile range, least and greatest, in the samples' unit."""

    n: int
    median: float
    iqr: float
    minimum: float
    maximum: float

    def to_json(self) -> dict[str, float | int]:
        return {
            "n": self.n, "median": self.median, "iqr": self.iqr, "minimum": self.minimum, "maximum": self.maximum,
        }  # fmt: skip


def summarise(samples: Sequence[float]) -> Summary:
    """Return the summary of at least one sample. Raises UsageError for none."""
    if len(samples) == 0:
        raise UsageError("no samples to summarise")
    low, median, high = np.percentile(np.asarray(samples, np.float64), [25.0, 50.0, 75.0])
    return Summary(len(samples), float(median), float(high - low), float(min(samples)), float(max(samples)))


def measure(
    run: Callable[[], object], *, repeats: int = 30, warm_up: int = 5, before: Callable[[], object] | None = None
) -> Summary:
    """Call `run` `warm_up` + `repeats` times, summarise the last `repeats` in ms; `before` runs untimed each time."""
    samples = []
    for i in range(warm_up + repeats):
        if before is not None:
            before()
        start = time.perf_counter_ns()
        run()
        stop = time.perf_counter_ns()
        if i >= warm_up:
            samples.append((stop - start) / 1e6)
    return summarise(samples)
