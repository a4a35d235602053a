"""Pruning, measured on a scene made here: bit-equal, with what was left out and why."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from engine.experiments.harness import registry, sweep
from engine.experiments.harness.context import Context
from tests.support.gltf_builder import triangle


@pytest.mark.usefixtures("gl_device")
def test_a_triangle(
    quick: Callable[[], Context],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path_factory: pytest.TempPathFactory,
) -> None:
    monkeypatch.setenv("LUCARNA_CACHE", str(tmp_path_factory.mktemp("cache")))
    monkeypatch.setattr(sweep, "BUDGET_S", (0.2, 0.2))
    ctx = quick()
    ctx.scenes = (triangle().write_glb(tmp_path / "t.glb"),)
    result = sweep.run_experiment("pruning", registry.get("pruning"), ctx)
    assert [p.knobs["frame"] for p in result.points] == ["pruned", "all"]
    assert all(p.error["max_difference"] == 0.0 for p in result.points)
    saving, reasons = result.tables
    assert saving.rows[0][-1] == "bit-equal"
    assert saving.rows[0][0] == "t.glb"
    assert any("transparent" in row[0] and row[2] == "t.glb" for row in reasons.rows)
    pruned, full = result.points
    assert pruned.extra["draws"] < full.extra["draws"]
    assert pruned.extra["api calls"] < full.extra["api calls"]


def test_a_scene_that_is_none_is_an_omission(quick: Callable[[], Context], tmp_path: Path) -> None:
    (tmp_path / "bad.glb").write_bytes(b"nothing")
    ctx = quick()
    ctx.scenes = (tmp_path / "bad.glb",)
    result = sweep.run_experiment("pruning", registry.get("pruning"), ctx)
    assert result.points == []
    assert any("bad.glb" in o.what for o in result.omitted)
