"""Programs of other paths and views are made while nothing else is to do: a switch then compiles nothing."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.app.framing import frame_bounds
from engine.app.rehearsal import Rehearsal
from engine.app.runtime import Runtime
from engine.gpu.types import Device
from engine.render.frame import Frame
from engine.render.settings import RenderSettings
from engine.render.view import View
from tests.support.effect_project import EffectProject

THING = 'name = "thing"\n[params]\nroughness = 0.4\n'
SWITCHES = (
    {"path": "deferred"}, {"path": "forward-plus"}, {"path": "tiled-deferred"}, {"view": "normal"}, {"view": "depth"},
    {"view": "overdraw"}, {"view": "gbuffer_color"},
)  # fmt: skip


def view_of(**settings: object) -> View:
    camera = frame_bounds(np.full(3, -0.9), np.full(3, 0.9), 4 / 3)
    return View(camera, 64, 48, RenderSettings(**{"samples": 1, "path": "forward", "shadow_size": 256, **settings}))


@pytest.fixture
def runtime(gl_device: Device, tmp_path: Path) -> Iterator[Runtime]:
    made = EffectProject(tmp_path, {"thing.material.toml": THING}).open(gl_device)
    yield made
    made.close()


def compiled(runtime: Runtime, view: View) -> tuple[Frame, int]:
    """A frame, and how many programs it made."""
    before = runtime.residency.effects.compiled
    frame = runtime.render(view)
    counters = frame.stats.counters
    made = counters["programs_compiled"] + counters["programs_loaded"]
    return frame, made + runtime.residency.effects.compiled - before


def pixels(frame: Frame) -> NDArray[np.uint8]:
    return np.array(frame.color.read())


def rehearsed(runtime: Runtime, view: View) -> int:
    for count in range(2000):
        if not runtime.rehearsal.step(view, 0.05):
            return count + 1
    raise AssertionError("it does not end")


def test_a_switch_after_a_rest_compiles_nothing(runtime: Runtime, monkeypatch: pytest.MonkeyPatch) -> None:
    some = ("lit", *(str(switch["view"]) for switch in SWITCHES if "view" in switch))
    monkeypatch.setattr("engine.app.rehearsal.DEBUG_VIEWS", some)  # the others are no other case
    first, _ = compiled(runtime, view_of())
    shown = pixels(first)
    waited = {}
    assert rehearsed(runtime, view_of()) > len(SWITCHES)
    assert np.array_equal(pixels(first), shown), "what is shown stays"
    for switch in SWITCHES:
        frame, made = compiled(runtime, view_of(**switch))
        assert made == 0, switch
        waited[str(switch)] = pixels(frame)
    frame, made = compiled(runtime, view_of())
    assert made == 0
    assert np.array_equal(pixels(frame), shown)
    assert not np.array_equal(waited[str(SWITCHES[3])], shown)
    assert runtime.rehearsal.done == runtime.rehearsal.total
    assert runtime.rehearsal.step(view_of(), 0.05) is False, "it ends"


def test_without_it_a_switch_compiles_and_gives_the_same(runtime: Runtime) -> None:
    shown = pixels(compiled(runtime, view_of())[0])
    frame, made = compiled(runtime, view_of(path="deferred"))
    assert made > 3
    assert np.array_equal(pixels(frame), shown)
    _, made = compiled(runtime, view_of(view="normal"))
    assert made > 0


def test_it_begins_again_for_another_scene_and_stops_in_time(runtime: Runtime, monkeypatch: pytest.MonkeyPatch) -> None:
    compiled(runtime, view_of())
    rehearsal: Rehearsal = runtime.rehearsal
    assert rehearsal.step(view_of(), 0.0)
    uses = set(runtime.renderer.variant_uses())
    assert uses == set(runtime.renderer.variant_uses())
    assert {request.role for request in uses} >= {"forward"}
    assert "gbuffer" not in {request.role for request in uses}, "the facts are those of what is shown"
    monkeypatch.setattr("engine.app.rehearsal.SECONDS", -1.0)
    assert rehearsal.step(view_of(), 0.0) is False
    monkeypatch.undo()
    assert rehearsal.step(view_of(), 0.0) is False, "the same state"
    runtime.residency.effects.revision += 1
    compiled(runtime, view_of())
    assert rehearsal.step(view_of(), 0.0)
