"""The experiment on texture encoders: found, run in part, and its qualities are those that the importers use."""

from __future__ import annotations

import pytest

from engine.experiments.harness import registry
from engine.experiments.harness.context import Context
from importers.experiments import texture_encoders
from importers.textures.encode import _PRESETS


@pytest.fixture(autouse=True)
def _included(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(registry, "_packages", ["engine.experiments"])
    registry.include("importers.experiments")


def test_it_is_found() -> None:
    assert registry.get("texture-encoders") is texture_encoders.EXPERIMENT
    assert "mip_filter" in registry.names()


def test_the_qualities_are_those_of_the_encoder() -> None:
    for problem in ("color bc7", "data bc7", "leaf bc7"):
        assert texture_encoders.CHOSEN[problem] == {quality: p[0] for quality, p in _PRESETS.items()}


@pytest.mark.parametrize(
    ("problem", "effort", "error"), [("color bc7", "ultrafast", 0.04), ("normal bc5", "only", 0.012)]
)
def test_a_setting_is_judged(problem: str, effort: str, error: float) -> None:
    trial = texture_encoders.run(Context(), {"problem": problem, "encoder": "ispc", "effort": effort})
    assert trial.work is not None
    outcome = trial.judge(trial.work())
    assert 0.0 < outcome.error["rmse"] < error
    assert outcome.extra["bytes per texel"] == 1.0
