"""The experiment on light between surfaces, at thumbnail size."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from engine.experiments import gi
from engine.experiments.harness import registry, sweep
from engine.experiments.harness.context import Context

pytestmark = pytest.mark.gl


@pytest.mark.usefixtures("gl_device")
def test_slices_beat_the_spiral_and_both_beat_nothing(
    quick: Callable[[], Context], monkeypatch: pytest.MonkeyPatch
) -> None:
    for package in ("flip_evaluator", "embreex"):
        pytest.importorskip(package)
    monkeypatch.setattr(sweep, "REPEATS", (5, 5))
    monkeypatch.setattr(sweep, "BUDGET_S", (0.1, 0.1))
    monkeypatch.setattr(gi, "size", lambda ctx: (48, 48, 48))
    result = sweep.run_experiment("gi", registry.get("gi"), quick())
    assert [o for o in result.omitted if not o.why.startswith("quick mode")] == []
    assert all(extreme.ok for extreme in result.extremes), result.extremes
    found = {p.curve: p.error["shown_rmse"] for p in result.points}
    assert found["slices, half size"] < 0.9 * found["spiral, thesis"]
    assert found["spiral, thesis"] < 0.9 * found["off"]
    energy = {p.curve: p.error["energy"] for p in result.points}
    assert energy["off"] < energy["slices, half size"] < 1.1
