"""A small slice of the fuzzer of operations; the whole is `python -m tests.fuzz.operations`."""

from __future__ import annotations

from tests.fuzz.operations import fuzz


def test_random_operations_undo_and_kills() -> None:
    outcome = fuzz(120, seed=7, every=40)
    assert not outcome.failures, outcome.failures[0]
    assert outcome.operations >= 120
    assert outcome.kills >= 3
    assert outcome.restored >= 1
    assert outcome.open >= 2, "one document at a time would not show what they share"
    assert sum(outcome.counts.values()) >= 90, "the walk was counted"
