"""Shadows of local lights against rays, at thumbnail size: right almost everywhere, and better with more texels."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from engine.core.errors import InputError
from engine.experiments import local_shadows
from engine.experiments.harness import registry, sweep
from engine.experiments.harness.context import Context
from engine.experiments.harness.samples import build
from engine.experiments.harness.scenes import LIVE

pytestmark = pytest.mark.gl


@pytest.mark.usefixtures("gl_device")
def test_against_rays(quick: Callable[[], Context], monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("embreex")
    monkeypatch.setattr(sweep, "REPEATS", (5, 5))
    monkeypatch.setattr(sweep, "BUDGET_S", (0.1, 0.1))
    monkeypatch.setattr(local_shadows, "size", lambda ctx: (96, 64))
    monkeypatch.setattr(local_shadows, "SIZES", (64, 256, 1024, 2048))
    result = sweep.run_experiment("local_shadows", registry.get("local_shadows"), quick())
    assert not [o for o in result.omitted if not o.why.startswith("quick mode")]
    for light in local_shadows.LIGHTS:
        error = {(p.knobs["filter"], p.knobs["size"]): p.error for p in result.points if p.knobs["light"] == light}
        assert error["auto", local_shadows.SIZE]["misclassified"] < 0.005
        assert error["none", 256]["rmse"] > error["none", 2048]["rmse"]


def test_lights_of_an_open_scene_are_left_alone(quick: Callable[[], Context]) -> None:
    ctx = quick()
    assert ctx.device is not None
    scene = build("room", ctx.device)
    try:
        with pytest.raises(InputError, match="cannot be told"):
            local_shadows.alone(scene, LIVE, "point")
        with pytest.raises(InputError, match="no disk light"):
            local_shadows.alone(scene, "made: room", "disk")
        assert len(scene.scene.lights.shining()) == 3
        local_shadows.alone(scene, "made: room", "spot")
        assert len(scene.scene.lights.shining()) == 1
    finally:
        scene.close()
