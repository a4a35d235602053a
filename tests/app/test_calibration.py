"""Presets and budgets: sound values, the best that fits, kept times, and times that make no sense."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import pytest

from engine.app import calibration
from engine.assets.primitives import card
from engine.core.errors import UsageError
from engine.gpu.types import Device
from engine.render.camera import Camera
from engine.render.presets import NAMES, PRESETS, preset_of, with_preset, within_budget
from engine.render.settings import RenderSettings
from engine.render.view import View
from engine.report.page.text import milliseconds
from importers.cli.render_quality import add_quality_arguments, auto_quality, check_quality
from tests.support.stage import Stage

TIMES = {"low": 2.0, "medium": 5.0, "high": 9.0, "ultra": 40.0}


@pytest.fixture
def stage(null_device: Device, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(calibration, "user_cache_dir", lambda: tmp_path)
    made = Stage(null_device)
    yield made
    made.close()


@pytest.mark.parametrize("name", NAMES)
def test_a_preset_is_parameters_and_nothing_else(name: str) -> None:
    """Each value is one that its parameter takes; all presets name the same ones; the look is in none."""
    looked = with_preset(RenderSettings(exposure=1.5, bloom=0.2), name)
    assert preset_of(looked) == name
    assert (looked.exposure, looked.bloom) == (1.5, 0.2)
    left = {"ao_directions", "ao_steps", "ao_half"}  # of what `low` does not have
    assert set(PRESETS[name]) | left == set(PRESETS["ultra"])
    assert preset_of(RenderSettings(**{**looked.values(), "shadow_size": 999})) == ""


@pytest.mark.parametrize(
    ("budget", "preset", "within"),
    [(1.0, "low", False), (2.0, "low", True), (16.0, "high", True), (1e4, "ultra", True)],
)
def test_the_best_that_fits(budget: float, preset: str, within: bool) -> None:
    chosen = within_budget(TIMES, budget, "this scene")
    assert (chosen.preset, chosen.within) == (preset, within)
    assert all(f"{name} {milliseconds(ms)}" in chosen.why for name, ms in TIMES.items()), "it says what was measured"
    # a preset that is both better and quicker is taken, whatever the order of the names
    assert within_budget({**TIMES, "ultra": 3.0}, 4.0, "").preset == "ultra"
    assert within_budget({"low": 10.1, "medium": 9.8, "ultra": 10.0}, 4.0, "").preset == "low"


def costs(times: dict[str, float]) -> dict[str, calibration.Cost]:
    return {name: calibration.Cost(ms, 1.1 * ms, 5) for name, ms in times.items()}


def test_measured_once_a_scene_and_size(stage: Stage, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[int] = []
    monkeypatch.setattr(calibration, "measure", lambda runtime, view: asked.append(view.width) or costs(TIMES))
    small, large = stage.view((32, 24)), stage.view((64, 48))
    assert calibration.choose(stage.runtime, small, 16.0).preset == "high"
    assert "measured before" in calibration.choose(stage.runtime, small, 4.0).why
    assert "measured now" in calibration.choose(stage.runtime, large, 4.0).why
    assert "measured now" in calibration.choose(stage.runtime, small, 4.0, again=True).why
    assert asked == [32, 64, 32]
    stage.add(card())
    calibration.choose(stage.runtime, small, 4.0)
    assert len(asked) == 4, "another scene"
    calibration.choose(stage.runtime, replace(small, camera=calibration.turned(small.camera, 1.0)), 4.0)
    assert len(asked) == 5, "seen from elsewhere"


class StandIn:
    """A device whose frames take what their preset's samples say, and every fifth of them twice as long."""

    def __init__(self, times: dict[str, float]) -> None:
        self.now, self.frames, self.times = 0.0, 0, times
        self.cameras: dict[str, set[bytes]] = {name: set() for name in NAMES}
        self.device = self

    def render(self, view: View) -> None:
        name = preset_of(view.settings)
        self.frames += 1
        self.cameras[name].add(view.camera.world_from_camera.tobytes())
        self.now += 1e-3 * self.times[name] * (2.0 if self.frames % 5 == 0 else 1.0)

    def finish(self) -> None:
        pass


@pytest.mark.parametrize(("scale", "frames"), [(1.0, 15), (100.0, 3)])
def test_every_preset_is_measured_in_motion(scale: float, frames: int) -> None:
    """Its own time, whatever comes between; in views that differ; slow devices are asked for fewer frames."""
    device = StandIn({name: scale * ms for name, ms in TIMES.items()})
    found = calibration.measure(device, View(Camera(), 16, 12, RenderSettings()), lambda: device.now)  # type: ignore[arg-type]  # all that is used of it
    assert {name: round(cost.least, 6) for name, cost in found.items()} == device.times
    assert {cost.frames for cost in found.values()} == {frames}
    assert all(cost.median >= cost.least for cost in found.values())
    assert all(len(seen) > 1 for seen in device.cameras.values()), "nothing that is kept at rest counts"
    for budget, preset in ((scale * 9.5, "high"), (scale * 0.5, "low")):
        lines = calibration.table(found, preset, budget)
        assert [line.split()[0] for line in lines[1:]] == list(NAMES)
        assert [line.endswith("chosen") for line in lines[1:]] == [name == preset for name in NAMES]
    assert sum("yes" in line for line in calibration.table(found, "high", scale * 9.5)) == 3


def test_frames_of_every_preset_are_taken(stage: Stage) -> None:
    found = calibration.measure(stage.runtime, stage.view((16, 12)))
    assert set(found) == set(NAMES)
    assert all(cost.least > 0.0 for cost in found.values())


def test_a_budget_that_nothing_meets_warns(
    stage: Stage, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(calibration, "measure", lambda runtime, view: costs(TIMES))
    arguments = argparse.Namespace(quality="auto", budget_ms=1.0)
    settings = auto_quality(arguments, stage.runtime, stage.view((32, 24)), {})
    assert preset_of(settings) == "low"
    said = capsys.readouterr().err
    assert "warning: quality low: none stays within 1 ms" in said
    assert all(name in said for name in NAMES)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "{",
        '{"scenes": {"a": {"low": 1}}}',
        "[]",
        '{"scenes": {"a": {"low": [-1, 1, 3], "medium": [1, 1, 3], "high": [1, 1, 3], "ultra": [1, 1, 3]}}}',
        '{"scenes": {"a": {"low": [1, 1], "medium": [1, 1, 3], "high": [1, 1, 3], "ultra": [1, 1, 3]}}}',
    ],
)
def test_kept_times_that_make_no_sense_count_as_none(stage: Stage, text: str) -> None:
    path = calibration.file_of(stage.device.caps)
    path.parent.mkdir(parents=True)
    path.write_text(text, "utf-8")
    assert calibration.load(stage.device.caps) == {}


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--quality", "auto"], "no budget"),
        (["--budget-ms", "16"], "without --quality auto"),
        (["--quality", "auto", "--budget-ms", "0"], "above 0"),
    ],
)
def test_arguments_that_do_not_go_together(arguments: list[str], said: str) -> None:
    parser = argparse.ArgumentParser()
    add_quality_arguments(parser)
    with pytest.raises(UsageError, match=said):
        check_quality(parser.parse_args(arguments))
