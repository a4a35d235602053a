"""The experiments on vertex storage and key reduction: they run, keep their bounds, and show what they should."""

from __future__ import annotations

import math

import pytest

from engine.experiments.harness import registry, sweep
from engine.experiments.harness.context import Context
from engine.report.records import Result


def _run(name: str, monkeypatch: pytest.MonkeyPatch) -> Result:
    monkeypatch.setattr(sweep, "REPEATS", (3, 3))
    monkeypatch.setattr(sweep, "BUDGET_S", (0.05, 0.05))
    registry.include("importers.experiments")
    experiment = registry.get(name)
    result = sweep.run_experiment(name, experiment, Context(device=None, quick=True))
    assert all(extreme.ok for extreme in result.extremes), result.extremes
    assert sweep.find(result.points, experiment.default) is not None
    return result


def test_vertex_storage(monkeypatch: pytest.MonkeyPatch) -> None:
    result = _run("vertex_storage", monkeypatch)
    assert all(order.met for order in result.orders)
    assert result.orders
    worst = {tuple(p.knobs.values()): p.error["max_mm"] for p in result.points}
    # half a step of a box of 1 x 2 x 0.5 m; a half between 1 and 2 m is off by up to 2^-11 m
    bound = 1000 * math.hypot(1.0, 2.0, 0.5) / 2
    assert 0.8 * bound / 65535 < worst["at the origin", "box", 16] < bound / 65535 * 1.02
    assert 0.8 * bound / 1023 < worst["100 m away", "box", 10] < bound / 1023 * 1.02
    assert 0.4 < worst["at the origin", "float", 16] < 1000 * 2**-11 * 3**0.5
    assert worst["100 m away", "float", 16] > 50


def test_key_reduction(monkeypatch: pytest.MonkeyPatch) -> None:
    result = _run("key_reduction", monkeypatch)
    for motion in ("smooth", "noisy"):
        points = [p for p in result.points if p.knobs["motion"] == motion]
        points.sort(key=lambda p: float(p.knobs["allowed_mm"]))
        keys = [int(p.extra["keys"]) for p in points]
        assert keys == sorted(keys, reverse=True)
        assert keys[-1] < 0.6 * keys[0]
        for point in points:
            assert point.error["skin_mm"] <= point.knobs["allowed_mm"]
