"""Every experiment, in quick mode: it runs, its order is the expected one, its extreme cases hold."""

from __future__ import annotations

import json
import math
from collections.abc import Callable

import pytest

from engine.experiments.harness import registry, sweep, verdict
from engine.experiments.harness.context import Context
from engine.report.page import diagram
from engine.report.records import Result

#: what renders whole scenes says its points only when it runs; that is slow here, and has tests of its own
SCENES = {name for name in registry.names() if callable(registry.get(name).knobs)}
NAMES = [name for name in registry.names() if name not in SCENES]


@pytest.fixture(autouse=True)
def _few_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    """Errors are what is tested here; times are taken, but few."""
    monkeypatch.setattr(sweep, "REPEATS", (5, 5))
    monkeypatch.setattr(sweep, "BUDGET_S", (0.2, 0.2))


def run(name: str, ctx: Context) -> Result:
    return sweep.run_experiment(name, registry.get(name), ctx)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.usefixtures("gl_device")
def test_runs_and_shows_its_order(name: str, quick: Callable[[], Context]) -> None:
    experiment, result = registry.get(name), run(name, quick())
    assert result.points
    why = [o for o in result.omitted if not o.why.startswith("quick mode")]
    assert why == [], "nothing is left out but what quick mode leaves out"
    for order in result.orders:
        assert order.met, f"{order.curve}: {order.observed} instead of {order.expected} ± {order.tolerance}"
    assert result.orders or "order is expected" in experiment.note, "no order: the note says why"
    for order in experiment.orders:  # a line that goes two ways is two lines
        if order.step is not None:
            mine = [p for p in result.points if verdict.of_order(order, experiment, p.knobs)]
            worst: dict[float, list[float]] = {}
            for point in mine:
                worst.setdefault(order.step(point.knobs), []).append(point.error[experiment.metric])
            assert all(max(v) <= 2.0 * min(v) for v in worst.values()), (order.curve, worst)
    for extreme in result.extremes:
        assert extreme.ok, extreme
    default = verdict.find(result.points, experiment.default)
    assert default is not None, "the default is among the points, also in quick mode"
    assert default.status == "ok"
    assert experiment.metric in default.error
    for point in result.points:
        assert point.status == "ok" or not math.isfinite(point.error[experiment.metric])
    json.dumps(result.to_json(), allow_nan=False)
    assert diagram.work_precision(result)


@pytest.mark.parametrize("name", NAMES)
def test_declares_itself(name: str) -> None:
    experiment = registry.get(name)
    for text in (experiment.title, experiment.method, experiment.truth, experiment.metric, experiment.unit):
        assert text.strip()
    assert experiment.timed in ("cpu", "gpu")
    assert not callable(experiment.knobs)
    assert any(all(k[n] == v for n, v in experiment.default.items()) for k in experiment.knobs)
    assert not experiment.curve or all(experiment.curve in k for k in experiment.knobs)
    if any(o.step is None for o in experiment.orders):
        assert experiment.profile_label
    if any(o.step is not None for o in experiment.orders):
        assert experiment.step_label


@pytest.mark.usefixtures("gl_device")
def test_errors_do_not_depend_on_the_run(quick: Callable[[], Context]) -> None:
    """The same seed gives the same errors, down to the last bit."""
    for name in ("brdf_d", "mip_filter"):
        first, second = (run(name, quick()) for _ in range(2))
        assert [p.error for p in first.points] == [p.error for p in second.points]
