"""Whole-picture experiments, at thumbnail size: against rays and paths, on made scenes and on the one that is open."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from engine.core.errors import InputError
from engine.experiments import picture, picture_lights, sun_shadows
from engine.experiments.harness import live, registry, sweep
from engine.experiments.harness.context import Context
from engine.experiments.harness.samples import build
from engine.experiments.harness.scenes import MADE, LiveScene, own_or
from engine.gpu.types import Device
from engine.render.settings import RenderSettings
from engine.render.view import View
from engine.report.advice import KINDS, advise
from engine.report.records import Result

pytestmark = pytest.mark.gl


@pytest.fixture(autouse=True)
def _few(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sweep, "REPEATS", (5, 5))
    monkeypatch.setattr(sweep, "BUDGET_S", (0.2, 0.2))
    monkeypatch.setattr(picture_lights, "size", lambda ctx: (36, 24, 64))
    monkeypatch.setattr(picture_lights, "SCENES", [MADE + "room", MADE + "metals"])
    monkeypatch.setattr(picture, "size", lambda ctx: (48, 32))
    monkeypatch.setattr(picture, "FINER", 2)
    monkeypatch.setattr(sun_shadows, "size", lambda ctx: (96, 64))
    monkeypatch.setattr(sun_shadows, "SIZES", (64, 128, 256, 512))
    monkeypatch.setattr(sun_shadows, "QUICK_FILTERS", ("none", "pcf", "msm"))
    monkeypatch.setattr(sun_shadows, "KEPT", ("auto",))
    monkeypatch.setitem(sun_shadows.THESIS_SETTINGS, "shadow_size", 512)


def run(name: str, ctx: Context) -> Result:
    return sweep.run_experiment(name, registry.get(name), ctx)


def why(result: Result) -> list[Any]:
    return [o for o in result.omitted if not o.why.startswith("quick mode") and "the device takes" not in o.why]


def test_lighting_against_paths(quick: Callable[[], Context]) -> None:
    pytest.importorskip("embreex")
    result = run("picture_lights", quick())
    assert why(result) == []
    assert {p.knobs["scene"] for p in result.points} == {MADE + "room", MADE + "metals"}
    assert result.noise_floor is not None
    for point in (p for p in result.points if p.knobs["samples"] == 4):
        error = point.error
        assert error["shown_rmse_unshadowed"] < error["shown_rmse_full"], (
            "approximations cost less than what is missing"
        )
        assert error["shown_rmse_unshadowed"] < 0.08
    assert [row[1] for row in result.tables[0].rows[:3]] == ["unshadowed", "direct", "full"]
    assert sum(name.startswith("picture-") for name in result.references) == 6


def test_sun_shadows_against_rays(quick: Callable[[], Context]) -> None:
    pytest.importorskip("embreex")
    result = run("sun_shadows", quick())
    assert why(result) == []
    order = result.order
    assert order is not None
    assert order.met, order
    unfiltered = {p.knobs["size"]: p.error for p in result.points if p.curve == "none"}
    assert unfiltered[512]["misclassified"] < unfiltered[64]["misclassified"] / 2.0
    assert unfiltered[512]["misclassified"] < 0.02
    assert len(result.pictures[0]) == 3
    beside, kept = result.tables
    assert [row[1] for row in beside.rows] == ["the thesis", "default", "best in the thesis's time"]
    assert len(kept.rows) == 1


def test_no_rays_no_points_but_a_reason(quick: Callable[[], Context], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("engine.experiments.truth.rays.missing", lambda: "it needs embreex (pip install …)")
    result = run("sun_shadows", quick())
    assert result.points == []
    assert [(o.what, o.why) for o in result.omitted] == [("the whole experiment", "it needs embreex (pip install …)")]


def test_a_scene_without_a_sun_is_an_omission(quick: Callable[[], Context], gl_device: Device) -> None:
    pytest.importorskip("embreex")
    ctx = quick()
    scene = build("room", gl_device)
    try:
        ctx.live = LiveScene(scene.scene, scene.residency, View(scene.camera(1.5), 60, 40), scene.renderer)
        result = run("sun_shadows", ctx)
        assert result.points == []
        assert any("has no sun" in o.why for o in result.omitted)
    finally:
        scene.close()


def test_files_are_named_without_their_folders(tmp_path: Path) -> None:
    ctx = Context(scenes=(tmp_path / "a" / "x.glb", tmp_path / "b" / "x.glb", tmp_path / "y.glb"))
    for _ in range(2):
        assert own_or(ctx, ["never"]) == ["x.glb", "x.glb (2)", "y.glb"]
    assert own_or(Context(), [MADE + "ball"]) == [MADE + "ball"]
    with pytest.raises(InputError, match="no made scene"):
        build("bal", None)  # type: ignore[arg-type]  # refused before a device is needed


def test_the_open_scene_in_steps(
    gl_device: Device, quick: Callable[[], Context], monkeypatch: pytest.MonkeyPatch
) -> None:
    some = ("samples", "shadows", "shadow_size")
    monkeypatch.setattr(picture, "VARIED", {name: picture.VARIED[name] for name in some})
    scene = build("blocks", gl_device)
    try:
        own = RenderSettings(shadow_size=256, samples=1)
        open_scene = LiveScene(scene.scene, scene.residency, View(scene.camera(1.5), 60, 40, own), scene.renderer)
        run = live.LiveRun("picture", device=gl_device, live=open_scene, references=quick().references)
        seen: list[float] = []
        while run.step():
            seen.append(run.done)
        assert run.state == "done", run.error
        assert seen == sorted(seen)
        assert run.result is not None
        assert run.result.advisory
        first = run.result.points[0]
        assert first.knobs["setting"] == "as it is"
        by = {(p.knobs["setting"], p.knobs["value"]): p for p in run.result.points}
        assert by["samples", 4].error["flip"] < first.error["flip"] < by["shadows", False].error["flip"]
        advice = advise(run.result)
        assert len(advice) == len(run.result.points) - 1
        assert all(a.kind in KINDS and a.text for a in advice)
        best = next(a for a in advice if a.knobs["setting"] == "samples" and a.knobs["value"] == 4)
        assert best.error_removed > 0.0
        assert own.values() == RenderSettings(shadow_size=256, samples=1).values(), "the view's own settings stay"
    finally:
        scene.close()


def test_a_cancelled_run_frees_and_says_so(gl_device: Device) -> None:
    scene = build("flat", gl_device)
    try:
        view = View(scene.camera(1.5), 60, 40)
        run = live.LiveRun(
            "picture", device=gl_device, live=LiveScene(scene.scene, scene.residency, view, scene.renderer)
        )
        assert run.step()
        run.cancel()
        assert not run.step()
        assert run.state == "cancelled"
        assert run.result is None
        assert scene.render(view).color is not None, "the open scene goes on"
    finally:
        scene.close()


def test_offers_say_where_and_why_not(gl_device: Device) -> None:
    with_scene = {o.name: o for o in live.offers(device=gl_device, scene_open=True)}
    assert list(with_scene)[:4] == sorted(n for n, o in with_scene.items() if o.own_scene)[:4]
    assert with_scene["picture"].thread == "render"
    assert with_scene["picture"].why_not == ""
    assert with_scene["quaternion"].thread == "worker"
    assert "importers" in with_scene["mip_filter"].why_not
    bare = {o.name: o for o in live.offers(device=None, scene_open=False)}
    assert bare["picture"].why_not
    assert bare["quaternion"].why_not == ""


def test_a_worker_runs_to_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    run = live.LiveRun("quaternion")
    assert run.run() is run.result
    assert run.state == "done"
    assert run.done == 1.0
