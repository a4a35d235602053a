"""Automatic exposure: middle grey, percentiles, time, and pictures in which there is nothing to meter."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from engine.assets.primitives import card
from engine.assets.scene import LightAsset
from engine.render.exposure import LATENCY, adaptation
from engine.render.settings import RenderSettings
from tests.support import poison
from tests.support.stage import front_camera

pytestmark = pytest.mark.gl

GREY = math.log2(0.18)
ON = {"auto_exposure": True}


def metered(stage, size=(64, 48), *, seconds: float | None = None, **settings):
    """(stops, picture u1[h,w,4])."""
    view = replace(stage.view(size, front_camera(0.5, size[0] / size[1]), **{**ON, **settings}), seconds=seconds)
    frame = stage.runtime.renderer.render(stage.runtime.scene, view)
    return frame.stats.counters["auto_exposure_ev"], np.asarray(frame.color.read())


def glow(stage, surface, strength: float, *, width: float = 4.0, at: float = 0.0) -> None:
    stage.add(
        card(1.0), surface(base_color=(0.0, 0.0, 0.0, 1.0), specular=0.0, emissive=(1.0, 1.0, 1.0),
        emissive_strength=strength), position=(at, 0.0, 0.0), scale=width,
    )  # fmt: skip


@pytest.mark.parametrize("light", [1e-3, 0.18, 1.0, 37.0, 1e4])
@pytest.mark.parametrize("samples", [1, 4])
def test_a_constant_picture_becomes_middle_grey(stage, light, samples) -> None:
    stage.look(kind="uniform", color=(light,) * 3)
    shown = stage.hdr((8, 8), front_camera())[0, 0].astype(np.float64) @ (0.2126, 0.7152, 0.0722, 0.0)
    stops, picture = metered(stage, samples=samples)
    assert stops == pytest.approx(GREY - math.log2(shown), abs=0.01)
    assert np.abs(picture[..., :3].astype(int) - 118).max() <= 1  # sRGB of 0.18
    brighter = metered(stage, exposure=1.0, samples=samples)[1]
    assert int(brighter[0, 0, 0]) == pytest.approx(161, abs=1)  # and of 0.36


def test_the_scenes_own_exposure_is_not_added(stage) -> None:
    stage.look(kind="uniform", color=(1.0, 1.0, 1.0), exposure=-5.0)
    assert np.abs(metered(stage)[1][..., :3].astype(int) - 118).max() <= 1


def test_the_percentiles_say_what_counts(stage, surface) -> None:
    """Left half of light 1, right half of light 16, by log-mean."""
    stage.dark()
    glow(stage, surface, 1.0, width=1.0, at=-0.5)
    glow(stage, surface, 16.0, width=1.0, at=0.5)
    size = (64, 64)
    for low, high, light in ((0.0, 1.0, 2.0), (0.0, 0.45, 0.0), (0.55, 1.0, 4.0), (0.25, 0.75, 2.0), (0.9, 0.9, 4.0)):
        stops, _ = metered(stage, size, auto_low=low, auto_high=high)
        assert stops == pytest.approx(GREY - light, abs=0.05), (low, high)


def test_a_sun_and_the_dark_do_not_count(stage, surface) -> None:
    """A spot of highest radiance changes nothing, and neither does black around what is lit."""
    stage.dark()
    glow(stage, surface, 1.0, width=0.5)
    alone, _ = metered(stage)
    assert alone == pytest.approx(GREY, abs=0.02)
    glow(stage, surface, 1e4, width=0.02, at=0.3)
    assert metered(stage)[0] == pytest.approx(alone, abs=0.02)


def test_nothing_to_meter(stage) -> None:
    stage.dark()
    stops, picture = metered(stage)
    assert stops == 0.0
    assert not picture[..., :3].any()
    assert metered(stage, (1, 1))[0] == 0.0


def test_limits(stage) -> None:
    stage.look(kind="uniform", color=(1e6, 1e6, 1e6))
    assert metered(stage, auto_limit=3.0)[0] == -3.0
    assert metered(stage)[0] == -16.0
    assert metered(stage, (1, 1), auto_limit=32.0)[0] == pytest.approx(GREY - math.log2(32000.0), abs=0.02)


@pytest.mark.parametrize("value", [math.nan, math.inf, -1.0, 1e38])
def test_a_bad_pixel_does_not_count(stage, value) -> None:
    stage.look(kind="uniform", color=(1.0, 1.0, 1.0))
    view = stage.view((24, 16), front_camera(), **ON)
    clean = poison.shoot(stage.runtime, view, "auto_exposure")
    shot = poison.shoot(stage.runtime, view, "auto_exposure", ("hdr", 3, 5, value))
    assert np.array_equal(shot.outputs["exposure"], clean.outputs["exposure"])


def test_it_takes_its_time(stage) -> None:
    stage.look(kind="uniform", color=(1.0, 1.0, 1.0))
    times = {"adapt_darker": 0.2, "adapt_brighter": 0.5}
    first, _ = metered(stage, seconds=0.05, **times)
    assert first == pytest.approx(GREY, abs=0.02)  # there was nothing to come from
    for change, constant in ((4.0, 0.2), (-4.0, 0.5)):
        start, _ = metered(stage, **times)
        stage.runtime.scene.environment.intensity *= 2.0**change
        for step in range(1, 4):
            stops, _ = metered(stage, seconds=0.05, **times)
            expected = start - change * (1.0 - math.exp(-0.05 * step / constant))
            assert stops == pytest.approx(expected, abs=0.03)
        assert metered(stage, **times)[0] == pytest.approx(start - change, abs=0.02)
    settings = RenderSettings(adapt_darker=0.0)
    assert adaptation(settings, 0.01)[0] == 1.0
    assert adaptation(settings, -5.0)[1] == 0.0
    assert adaptation(settings, 1e9)[1] < 0.1, "a picture that stood still did not get used to the next one"


def test_a_frame_says_when_it_has_settled(stage) -> None:
    stage.look(kind="uniform", color=(1.0, 1.0, 1.0))
    metered(stage)
    stage.runtime.scene.environment.intensity *= 16.0
    view = replace(stage.view((8, 8), front_camera(), **ON), seconds=0.1)
    settled = [stage.runtime.render(view).settled for _ in range(40)]
    assert not settled[0]
    assert settled[-1]
    assert settled == sorted(settled)
    assert LATENCY < settled.index(True) < 35


def test_off_is_nothing(stage, surface) -> None:
    stage.look(kind="uniform", color=(0.05, 0.05, 0.05))
    glow(stage, surface, 3.0, width=0.3)
    camera = front_camera(0.5, 33 / 20)
    off = stage.ldr((33, 20), camera)
    assert np.array_equal(stage.ldr((33, 20), camera, force_all=True), off)
    for settings, why in (({}, "is off"), ({**ON, "view": "normal"}, "values as they are")):
        frame = stage.runtime.renderer.render(stage.runtime.scene, stage.view((33, 20), camera, **settings))
        assert why in next(item.reason for item in frame.graph.left_out if item.name == "auto_exposure")
        assert "auto_exposure_ev" not in frame.stats.counters
    assert np.array_equal(stage.hdr((33, 20), camera, **ON), stage.hdr((33, 20), camera))


def test_all_paths(stage, surface) -> None:
    stage.look(kind="uniform", color=(0.02, 0.02, 0.02))
    glow(stage, surface, 3.0, width=0.3)
    stage.lamp(LightAsset("point", intensity=4.0, range=3.0), (0.2, 0.0, 1.0))
    pictures = [
        metered(stage, (40, 32), path=path) for path in ("forward", "deferred", "tiled-deferred", "forward-plus")
    ]
    for stops, picture in pictures[1:]:
        assert stops == pictures[0][0]
        assert np.array_equal(picture, pictures[0][1])


def test_each_view_has_an_eye_of_its_own(stage) -> None:
    """Two views of one renderer, one bright, one dark, side by side: neither gets used to what the other shows."""
    stage.look(kind="uniform", color=(1.0, 1.0, 1.0))
    view = replace(stage.view((8, 8), front_camera(), **ON), seconds=0.02)
    bright = float(stage.runtime.render(replace(view, key="a")).stats.counters["auto_exposure_ev"])
    stage.runtime.scene.environment.intensity /= 256.0
    dark = float(stage.runtime.render(replace(view, key="b")).stats.counters["auto_exposure_ev"])
    assert dark == pytest.approx(bright + 8.0, abs=0.05), "it is the first thing that view sees"
    slowly = float(stage.runtime.render(replace(view, key="a")).stats.counters["auto_exposure_ev"])
    assert bright < slowly < bright + 1.0
    assert float(stage.runtime.render(replace(view, key="a", cut=True)).stats.counters["auto_exposure_ev"]) == dark
