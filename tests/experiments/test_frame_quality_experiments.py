"""Frame quality experiments, at thumbnail size."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from engine.experiments import bloom
from engine.experiments.harness import registry, sweep
from engine.experiments.harness.context import Context
from engine.report.records import Result

pytestmark = pytest.mark.gl


@pytest.fixture(autouse=True)
def _few(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sweep, "REPEATS", (5, 5))
    monkeypatch.setattr(sweep, "BUDGET_S", (0.2, 0.2))
    monkeypatch.setattr(bloom, "size", lambda ctx: (96, 64))


def run(name: str, ctx: Context) -> Result:
    result = sweep.run_experiment(name, registry.get(name), ctx)
    why = [o for o in result.omitted if not o.why.startswith("quick mode") and "the device takes" not in o.why]
    assert why == []
    assert all(extreme.ok for extreme in result.extremes), result.extremes
    return result


@pytest.mark.usefixtures("gl_device")
def test_bloom_is_the_halos_and_keeps_the_light(quick: Callable[[], Context]) -> None:
    pytest.importorskip("flip_evaluator")
    errors = {p.curve: p.error for p in run("bloom", quick()).points if p.knobs["radius"] == 0.1}
    assert errors["bloom"]["misplaced"] < 0.1
    assert abs(errors["bloom"]["lost"]) < 1e-3 < errors["calm"]["lost"]
    assert errors["off"]["misplaced"] == 1.0


@pytest.mark.usefixtures("gl_device")
def test_every_way_to_smooth_edges_helps(quick: Callable[[], Context]) -> None:
    pytest.importorskip("flip_evaluator")
    points = run("antialias", quick()).points
    found = {(p.curve, p.knobs["samples"]): p.error["rmse_8_bit"] for p in points}
    assert found["fxaa", 1] < 0.9 * found["none", 1]
    assert found["msaa", 4] < found["fxaa", 1]
