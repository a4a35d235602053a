"""What shadows are by default, beside the thesis's own choice and beside formulas, at thumbnail size."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from engine.experiments import sun_shadows, translucent_shadows
from engine.experiments.harness.context import Context
from engine.experiments.harness.scenes import open_scene
from engine.render.shadows.quality import DEFAULT

pytestmark = pytest.mark.gl


@pytest.mark.parametrize("scene", sun_shadows.SCENES)
@pytest.mark.usefixtures("gl_device")
def test_a_quarter_of_the_thesis_s_maps_is_nearer_to_rays(
    quick: Callable[[], Context], monkeypatch: pytest.MonkeyPatch, scene: str
) -> None:
    pytest.importorskip("embreex")
    monkeypatch.setattr(sun_shadows, "size", lambda ctx: (200, 133))
    monkeypatch.setattr(sun_shadows, "RAYS", 16)
    monkeypatch.setattr(sun_shadows, "SCENES", (scene,))
    ctx = quick()
    monkeypatch.setattr(sun_shadows, "scenes", lambda ctx: [scene])
    list(sun_shadows.prepare(ctx))
    found, opened = sun_shadows.truth(ctx, scene), open_scene(ctx, scene)
    try:
        base = {"scene": scene, "filter": "auto", "cascades": DEFAULT.cascades, "size": DEFAULT.size}
        ours = sun_shadows.judge(ctx, opened, base, found).error
        thesis = {**base, "filter": sun_shadows.THESIS, "size": sun_shadows.THESIS_SETTINGS["shadow_size"]}
        theirs = sun_shadows.judge(ctx, opened, thesis, found).error
    finally:
        opened.close()
    assert thesis["size"] == 2 * base["size"]
    assert ours["rmse"] < 0.95 * theirs["rmse"]
    assert ours["misclassified"] < 0.01


@pytest.mark.parametrize("light", ["sun", "point", "rectangle"])
@pytest.mark.usefixtures("gl_device")
def test_coloured_glass_against_the_formula(
    quick: Callable[[], Context], monkeypatch: pytest.MonkeyPatch, light: str
) -> None:
    monkeypatch.setattr(translucent_shadows, "SIZE", (64, 64))
    trial = translucent_shadows.run(quick(), {"light": light, "filter": "pcf"})
    assert trial.work is not None
    assert trial.close is not None
    try:
        outcome = trial.judge(trial.work())
    finally:
        trial.close()
    assert outcome.error["colour"] < 0.01
    assert outcome.error["rmse"] < 0.03
    assert len(outcome.pictures) in (2, 3)
