"""Facts that flicker: held where that changes no pixel, let go where the scene really changed."""

from __future__ import annotations

import gc

import numpy as np
import pytest

from engine.assets.primitives import card, cube
from engine.assets.scene import LightAsset
from engine.render.facts import SceneFacts
from engine.render.hysteresis import HOLD, NEUTRAL, VIEWS, Hysteresis
from engine.scene.scene import Scene
from tests.stability.rows import covers
from tests.support.stage import Stage, front_camera, surface


def facts(**on: bool) -> SceneFacts:
    named = {"opaque": True, "transparent": False, "suns": False, "local_lights": False, **on}
    return SceneFacts(**named, environment=False, background=False, tone_map="none", samples=1, debug_view="lit")


def run(hysteresis: Hysteresis, scene: Scene, wanted: str, view: object = None) -> str:
    """Steps of one fact, `1` needed and `.` not; what came out, likewise."""
    return "".join(".1"[hysteresis(scene, view, facts(local_lights=w == "1")).local_lights] for w in wanted)


@pytest.mark.parametrize(
    ("wanted", "expected"),
    [
        ("111...", "111..."),  # what really ends, ends at once
        ("1.1.1.1.", "1.111111"),  # comes back soon: held
        ("1.1.1....", "1.11111.."),  # and let go after `hold` frames without need
        ("1....1....", "1....1...."),  # too rare to be a flicker
        ("1.1111111..", "1.1111111.."),  # settled: goes at once again
        (".........", "........."),
    ],
)
def test_a_fact_is_held_only_when_it_flickers(wanted: str, expected: str) -> None:
    assert run(Hysteresis(hold=3), Scene(), wanted) == expected


def test_nothing_that_is_needed_is_ever_off() -> None:
    rng = np.random.default_rng(3)
    for hold in (1, 2, 5):
        hysteresis, scene = Hysteresis(hold=hold), Scene()
        for _ in range(200):
            wanted = facts(**{name: bool(rng.random() < 0.5) for name in NEUTRAL})
            got = hysteresis(scene, 0, wanted)
            assert all(getattr(got, name) or not getattr(wanted, name) for name in NEUTRAL)
            assert set(hysteresis.held) == {n for n in NEUTRAL if getattr(got, n) and not getattr(wanted, n)}


def test_views_and_scenes_do_not_hold_for_each_other() -> None:
    hysteresis, scene = Hysteresis(hold=3), Scene()
    run(hysteresis, scene, "1.1", "one view")
    assert run(hysteresis, scene, ".1.", "another") == ".1."
    assert run(hysteresis, scene, ".", "one view") == "1"
    for view in range(2 * VIEWS):
        run(hysteresis, scene, "1", view)
    assert len(hysteresis._views) == VIEWS
    run(hysteresis, scene, "1.1", "x")
    assert run(hysteresis, Scene(), ".", "x") == "."


def test_a_scene_is_not_kept_alive() -> None:
    hysteresis, scene = Hysteresis(), Scene()
    run(hysteresis, scene, "1.1")
    assert hysteresis._scene is not None
    del scene
    gc.collect()
    assert hysteresis._scene() is None


@covers("facts.flicker")
@pytest.mark.gl
def test_a_flickering_scene_compiles_each_graph_once(stage: Stage) -> None:
    """A lamp and a sun that blink, each in its own time, with room for two of the four graphs that this makes: after
    the first blinks none is compiled any more, and each picture is equal to the bit to that of a renderer that holds
    nothing."""
    stage.look(kind="uniform", color=(0.4, 0.5, 0.6), sun_illuminance=0.0, background="environment")
    stage.add(cube(), surface(base_color=(0.6, 0.4, 0.3, 1), metallic=0.0))
    stage.add(card(0.6), surface("transparent", base_color=(0.2, 0.4, 0.9, 0.5)), (0.1, 0.0, 0.7))
    lamp = stage.lamp(LightAsset("point", intensity=1.0), (0.4, 0.5, 1.2))
    sun = stage.lamp(LightAsset("directional", intensity=1.0))
    scene, renderer = stage.runtime.scene, stage.runtime.renderer
    camera = front_camera(0.7)
    renderer.graph.capacity = 2
    rng = np.random.default_rng(2)
    states = [(i % 2, i % 3 > 0) for i in range(12)] + [tuple(rng.integers(0, 2, 2)) for _ in range(12)]

    def compiled(hold: int) -> tuple[int, list[np.ndarray]]:
        renderer.graph.release()
        renderer.hysteresis = Hysteresis(hold=hold)
        taken, before = [], 0
        for number, (by_lamp, by_sun) in enumerate(states):
            before = renderer.graph.compiles if number == 6 else before
            scene.lights.set(lamp, intensity=float(by_lamp))
            scene.lights.set(sun, intensity=float(by_sun))
            taken.append(stage.hdr((24, 20), camera, shadows=False))
        return renderer.graph.compiles - before, taken

    plain, expected = compiled(0)
    held, got = compiled(HOLD)
    assert plain > 8, "the scene does not flicker"
    assert held == 0
    last = renderer.hysteresis(scene, ("", True, 24, 20, False), facts())
    assert last.local_lights, "still held"
    assert last.suns
    for a, b in zip(expected, got, strict=True):
        assert (a.view(np.uint32) == b.view(np.uint32)).all()
