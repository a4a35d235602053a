from __future__ import annotations

from engine.report.interleave import LEAST, interleaved, one_by_one, wall_clock


def test_every_round_runs_each_once_and_starts_elsewhere() -> None:
    calls: list[str] = []
    runs = [lambda name=name: calls.append(name) for name in "abc"]
    samples = interleaved(runs, repeats=6, warm_up=1)
    assert [len(s) for s in samples] == [6, 6, 6]
    rounds = ["".join(calls[i : i + 3]) for i in range(0, 21, 3)]
    assert all(sorted(r) == ["a", "b", "c"] for r in rounds)
    assert len(set(rounds)) == 3


def test_a_spent_budget_still_gives_enough_repeats() -> None:
    samples = interleaved([lambda: None], repeats=1000, budget_s=0.0)
    assert len(samples[0]) == LEAST


def test_each_run_has_its_clock() -> None:
    samples = interleaved([lambda: None] * 2, repeats=5, clocks=[lambda run: 7.0, wall_clock])
    assert samples[0] == [7.0] * 5
    assert all(0.0 <= s < 1000.0 for s in samples[1])


def test_pauses_after_every_run_do_not_count() -> None:
    samples: list[list[float]] = [[], []]
    done = list(one_by_one([lambda: None] * 2, samples, repeats=6, warm_up=1, clocks=[lambda run: 7.0] * 2))
    assert [len(s) for s in samples] == [6, 6]
    assert len(done) == 14
    assert done == sorted(done)
    assert done[-1] == 1.0
