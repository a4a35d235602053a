"""The experiment on flat mirrors, at thumbnail size."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from engine.experiments import planar
from engine.experiments.harness import registry, sweep
from engine.experiments.harness.context import Context
from engine.experiments.harness.scenes import MADE

pytestmark = pytest.mark.gl


@pytest.mark.usefixtures("gl_device")
def test_a_mirror_s_own_picture_beats_the_screen_s_and_the_environment(
    quick: Callable[[], Context], monkeypatch: pytest.MonkeyPatch
) -> None:
    for package in ("flip_evaluator", "embreex"):
        pytest.importorskip(package)
    monkeypatch.setattr(sweep, "BUDGET_S", (0.05, 0.05))
    monkeypatch.setattr(planar, "SCENES", (MADE + "satin",))
    result = sweep.run_experiment("planar", registry.get("planar"), quick())
    assert [o for o in result.omitted if not o.why.startswith("quick mode")] == []
    found = {(p.knobs["method"], p.knobs["scale"]): p.error["shown_rmse"] for p in result.points}
    assert found["planar", 1.0] < 0.75 * found["environment", 0.0]
    assert found["planar", 1.0] < 0.8 * found["screen", 0.0]
    assert result.default_on_front
    assert result.pictures
