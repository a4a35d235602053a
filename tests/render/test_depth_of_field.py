"""Depth of field: discs by the formula, light kept, nearer to a lens's truth than a pinhole, what is sharp stays."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from engine.assets.primitives import card
from engine.render.camera import Camera
from engine.render.focus import WIDEST, disc, lens_width, pixels_per_slope
from engine.render.settings import RenderSettings
from tests.support.stage import front_camera

SIZE = (192, 192)
ON = {"depth_of_field": True, "focus": 4.0, "f_stop": 2.0}


def eye() -> Camera:
    pose = np.eye(4)
    return Camera(pose, 0.6, 0.05)


def glow(surface, strength: float = 1.0):
    return surface(base_color=(0.0, 0.0, 0.0, 1.0), specular=0.0, emissive=(1.0, 1.0, 1.0), emissive_strength=strength)


def channel(stage, camera=None, size=SIZE, shift=(0.0, 0.0), **settings):
    """f8[h,w]."""
    view = replace(stage.view(size, camera or eye(), **settings), shift=shift)
    return np.asarray(stage.runtime.render(view, hdr=True).hdr.read(), np.float64)[..., 0]


def test_the_disc_by_hand() -> None:
    """A lens of 50 mm at f/2 on 24 mm: 25 mm wide; 2 m in focus, a point at 4 m: 25 mm / 4 m of slope."""
    camera = Camera(np.eye(4), 2.0 * math.atan(12.0 / 50.0))
    settings = RenderSettings(f_stop=2.0, sensor=24.0)
    assert lens_width(camera, settings) == pytest.approx(0.025)
    assert pixels_per_slope(camera, 480) == pytest.approx(480 * 50 / 24)
    assert disc(camera, settings, 480, 2.0, 4.0) == pytest.approx(-0.025 / 4.0 * 1000.0)
    assert disc(camera, settings, 480, 2.0, 1.0) == pytest.approx(0.025 / 2.0 * 1000.0)
    assert disc(camera, settings, 480, 2.0, 2.0) == 0.0
    assert disc(camera, settings, 480, 2.0, 1e-3) == WIDEST * 480
    assert disc(camera, settings, 480, math.inf, 4.0) > 0.0


@pytest.mark.gl
@pytest.mark.parametrize("distance", [2.5, 12.0])
def test_a_point_becomes_its_disc(stage, surface, distance) -> None:
    """A small light before or behind: the spread (variance) of its light is a disc's, r^2 / 4 on each axis, and there
    is as much light as without."""
    stage.dark()
    settings = {**ON, "sensor": 340.0}
    pixels = pixels_per_slope(eye(), SIZE[1])
    stage.add(card(1.0), glow(surface, 4.0), (0.0, 0.0, -distance), 4.0 / pixels * distance)
    sharp, blurred = channel(stage), channel(stage, **settings)
    assert blurred.sum() == pytest.approx(sharp.sum(), rel=0.1)
    y, x = np.mgrid[: SIZE[1], : SIZE[0]] + 0.5 - SIZE[0] / 2.0

    def spread(light) -> float:
        return float((light * (x**2 + y**2)).sum() / light.sum()) / 2.0

    radius = abs(disc(eye(), RenderSettings(**settings), SIZE[1], 4.0, distance)) / 2.0
    assert 6.0 < radius < 0.5 * WIDEST * SIZE[1] + 1e-9
    assert spread(blurred) - spread(sharp) == pytest.approx(radius**2 / 4.0, rel=0.2)


@pytest.mark.gl
def test_nearer_to_a_lens_than_a_pinhole_is(stage, surface) -> None:
    """Truth: the mean over the lens, each place with the plane of focus held still."""
    stage.look(kind="uniform", sun_illuminance=0.0)
    stage.add(card(0.5), glow(surface, 0.8), (-0.4, 0.0, -2.4))
    stage.add(card(0.7), glow(surface, 0.3), (0.5, 0.2, -4.0))
    stage.add(card(8.0), glow(surface, 0.1), (0.0, -4.0, -9.0))
    settings = {**ON, "sensor": 400.0}
    camera = eye()
    width, pixels = lens_width(camera, RenderSettings(**settings)), pixels_per_slope(camera, SIZE[1])
    total = np.zeros(SIZE)
    count = 48
    for i in range(count):
        radius, turn = 0.5 * width * math.sqrt((i + 0.5) / count), i * 2.39996323
        u, v = radius * math.cos(turn), radius * math.sin(turn)
        pose = camera.world_from_camera.copy()
        pose[:2, 3] += (u, v)
        total += channel(stage, replace(camera, world_from_camera=pose), shift=(u * pixels / 4.0, -v * pixels / 4.0))
    truth = total / count
    errors = [float(np.sqrt(np.mean((channel(stage, **s) - truth) ** 2))) for s in ({}, settings)]
    assert errors[1] < 0.4 * errors[0]


@pytest.mark.gl
def test_what_is_in_focus_stays_to_the_bit(stage, surface) -> None:
    stage.dark()
    stage.add(card(1.0), surface(), (0.2, 0.1, -4.0), 8.0)
    assert np.array_equal(channel(stage, **ON), channel(stage))
    assert np.array_equal(channel(stage, **{**ON, "focus": 0.0}), channel(stage)), "the middle of the picture is"


@pytest.mark.gl
def test_what_is_in_focus_keeps_its_edge(stage, surface) -> None:
    """A dark card in focus before stripes far off: nothing of their light comes over it, up to its last pixel, and it
    leaves no seam of its own around it: nowhere is it darker or brighter there than stripes are."""
    stage.dark()
    stage.add(card(1.0), glow(surface, 0.05), (0.0, 0.0, -4.0))
    stage.add(card(40.0), glow(surface, 0.4), (0.0, 0.0, -13.0))
    for i in range(-5, 6):
        stage.add(card(1.0), glow(surface, 1.0), (1.3 * i, 0.0, -12.0), (0.6, 20.0, 1.0))
    settings = {**ON, "sensor": 300.0}
    sharp, blurred = channel(stage), channel(stage, **settings)
    own = sharp < 0.1
    assert own.sum() > 500
    assert np.abs(blurred[own] - sharp[own]).max() < 1e-3
    assert blurred[~own].min() > 0.39
    assert blurred[~own].max() < 1.01
    assert np.abs(blurred - sharp)[~own].max() > 0.1, "what is behind it is blurred"


@pytest.mark.gl
def test_a_shifted_picture_is_the_picture_moved(stage, surface) -> None:
    stage.add(card(0.8), glow(surface), (0.1, 0.2, -4.0))
    plain, moved = channel(stage), channel(stage, shift=(7.0, -3.0))
    assert np.abs(moved[:-3, 7:] - plain[3:, :-7]).max() < 2e-3


@pytest.mark.gl
def test_off_is_nothing(stage, surface) -> None:
    stage.add(card(0.5), surface(), (0.0, 0.0, -2.0))
    bare = channel(stage)
    assert np.array_equal(channel(stage, depth_of_field=True, f_stop=64.0, sensor=0.1), bare), "a pinhole"
    for settings in ({"samples": 4}, {"view": "normal"}):
        assert np.array_equal(channel(stage, **ON, **settings), channel(stage, **settings))
    flat = front_camera(0.5)
    flat.ymag = 0.5
    assert np.array_equal(channel(stage, flat, **ON), channel(stage, flat))


@pytest.mark.gl
@pytest.mark.parametrize("size", [(1, 1), (2, 1), (3, 17)])
@pytest.mark.parametrize("settings", [{}, {"focus": 1e-4, "f_stop": 0.5, "sensor": 1000.0}, {"focus": 1e6}], ids=str)
def test_extremes(stage, surface, size, settings) -> None:
    stage.add(card(0.5), surface(), (0.0, 0.0, -2.0))
    assert np.isfinite(channel(stage, size=size, **{**ON, **settings})).all()
