"""The many-lights experiment, small: every path gives the truth's picture, and the tables say what they promise."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from engine.experiments import lights
from engine.experiments.harness import registry, sweep
from engine.experiments.harness.context import Context
from engine.render.lighting import PATHS

pytestmark = pytest.mark.gl

COUNTS = (3, 40)


def test_paths_and_tables(quick: Callable[[], Context], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LUCARNA_CACHE", str(tmp_path))
    monkeypatch.setattr(sweep, "BUDGET_S", (0.05, 0.05))
    monkeypatch.setattr(lights, "QUICK_COUNTS", COUNTS)
    monkeypatch.setattr(lights, "size", lambda ctx: (40, 24))
    monkeypatch.setattr(lights, "VOLUME_SIZE", (20, 12))
    result = sweep.run_experiment("lights", registry.get("lights"), quick())
    assert [p.error["max_difference"] for p in result.points] == [0.0] * (2 * len(COUNTS) * (1 + len(PATHS)))
    assert {str(p.knobs["method"]) for p in result.points} == {"auto", *PATHS}
    for point in result.points:
        method = point.knobs["method"]
        assert method in ("auto", point.extra["path"])
        if point.extra["path"] in ("tiled-deferred", "forward-plus"):
            tested, kept, needed, own = (point.extra[name] for name in lights.KEPT)
            assert tested >= kept >= needed >= own >= 0.0
            assert own > 0.0 or point.knobs["lights"] == COUNTS[0]
            assert point.extra["lists without room"] == 0
        assert ("G-buffer bytes per pixel" in point.extra) == (point.extra["path"] in ("deferred", "tiled-deferred"))
    volumes, *by_scene = result.tables
    for row in volumes.rows:
        assert float(row[2]) >= float(row[3]) > 0.0
    assert [table.title.split(":")[0] for table in by_scene] == ["atrium", "atrium", "poles", "poles"]
    assert [row[0] for row in by_scene[0].rows] == [str(n) for n in COUNTS]
    assert by_scene[0].columns[1:] == ["auto", *PATHS]
    assert "beats deferred" in by_scene[0].note
    assert [chart.title.split(":")[0] for chart in result.charts] == ["atrium", "poles"]
    for chart in result.charts:
        assert [line.name for line in chart.lines] == list(PATHS)
        assert all([p.x for p in line.points] == list(COUNTS) for line in chart.lines)
    assert not list(tmp_path.rglob("light_costs/*"))  # a quick run is no fit
    assert result.pictures
