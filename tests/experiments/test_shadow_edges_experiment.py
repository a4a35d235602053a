"""Edges of shadows against formulas, at thumbnail size; the group of experiments on shadows."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from engine.core.errors import UsageError
from engine.experiments import shadow_edges
from engine.experiments.harness import registry, sweep
from engine.experiments.harness.context import Context


@pytest.mark.gl
@pytest.mark.usefixtures("gl_device")
def test_softness_and_leaks(quick: Callable[[], Context], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sweep, "REPEATS", (5, 5))
    monkeypatch.setattr(sweep, "BUDGET_S", (0.1, 0.1))
    monkeypatch.setattr(shadow_edges, "FILTERS", ("pcss", "poisson24", "vsm", "msm"))
    monkeypatch.setattr(shadow_edges, "SIZE", (96, 96))
    result = sweep.run_experiment("shadow_edges", registry.get("shadow_edges"), quick())
    assert not result.omitted
    edge = {p.knobs["filter"]: p.error for p in result.points if p.knobs["scene"] == shadow_edges.PENUMBRA}
    assert min(edge, key=lambda name: edge[name]["rmse"]) == "pcss", "the only one whose width is the sun's"
    leaks = {
        (p.knobs["filter"], p.knobs["leak"] > 0.0): p.error["worst"]
        for p in result.points if p.knobs["scene"] == shadow_edges.CASTERS and p.knobs["precision"] == "single"
    }  # fmt: skip
    assert leaks["pcf", True] == 0.0
    assert leaks["vsm", False] > 0.05
    assert leaks["vsm", True] < leaks["vsm", False]
    assert leaks["msm", False] < 0.3 * leaks["vsm", False]


def test_judged_rows_keep_clear_of_other_edges() -> None:
    rows = shadow_edges.judged_rows(shadow_edges.PENUMBRA)
    strip = shadow_edges.SIZE[1] // len(shadow_edges.HEIGHTS)
    of_strip = rows // shadow_edges.SIZE[0] % strip
    assert np.abs(of_strip - strip // 2).max() <= strip // 8
    assert len(shadow_edges.judged_rows(shadow_edges.CASTERS)) == shadow_edges.SIZE[0] * shadow_edges.SIZE[1]


def test_a_group_is_its_members() -> None:
    assert tuple(registry.select(["shadows"])) == registry.GROUPS["shadows"]
    assert tuple(registry.select(["shadows", "sun-shadows", "bloom"])) == (*registry.GROUPS["shadows"], "bloom")
    for members in registry.GROUPS.values():
        assert set(members) <= set(registry.names())
    with pytest.raises(UsageError, match="shadowz"):
        registry.select(["shadowz"])
