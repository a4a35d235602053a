"""Flat mirrors at the ends of where a camera may be: on the plane, under it, along it."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.assets.primitives import cube, plane, uv_sphere
from engine.math.transform import look_at
from engine.render.camera import Camera
from engine.render.planar.planes import LEAST_PIXELS
from tests.stability.rows import covers
from tests.support.stage import DARK, Stage, surface

pytestmark = pytest.mark.gl

SIZE = (72, 56)
NEAR = 0.05


def glowing(*color: float) -> object:
    return surface(base_color=(0.0, 0.0, 0.0, 1.0), metallic=0.0, specular=0.0, emissive=color)


def scene(stage: Stage, *, mirror: bool, sides: tuple[float, ...] = (1.0, -1.0)) -> None:
    """Two bodies that glow, over (1) and under (-1) a mirror."""
    stage.look(**DARK)
    for side in sides:
        stage.add(uv_sphere(0.4), glowing(1.0, 0.2, 0.1), (-0.5, 0.6 * side, 0.1))
        stage.add(cube(0.6), glowing(0.1, 0.9, 0.3), (0.5, 0.9 * side, -0.4), (1.0, side, 1.0))
    if mirror:
        both = ("planar_reflection", "double_sided")
        stage.add(plane(6.0), surface(features=both, metallic=1.0, roughness=0.0))


def camera(height: float) -> Camera:
    """Looks along the mirror, level."""
    return Camera(look_at((0.3, height, 3.0), (0.0, height, 0.0)), 0.9, znear=NEAR)


def bodies(picture: NDArray[np.float32]) -> NDArray[np.int8]:
    """Which body a pixel shows: 0 none, 1 red, 2 green."""
    shown = picture[..., :3].max(axis=-1) > 0.25
    return np.where(shown, np.where(picture[..., 0] > picture[..., 1], 1, 2), 0).astype(np.int8)


def within_a_pixel(a: NDArray[np.int8], b: NDArray[np.int8]) -> bool:
    """Whether what each pixel of one shows is in the other, in that pixel or one beside it."""

    def near(x: NDArray[np.int8], y: NDArray[np.int8]) -> bool:
        padded = np.pad(y, 1, mode="edge")
        h, w = x.shape
        around = np.stack([padded[i : i + h, j : j + w] for i in range(3) for j in range(3)])
        return bool((around == x).any(axis=0).all())

    return near(a, b) and near(b, a)


@covers("light.reflection")
@pytest.mark.parametrize("height", [-1.0, -1e-6, 0.0, 1e-6, 1.0])
def test_cameras_on_and_under_the_mirror(stage: Stage, height: float) -> None:
    """What it shows is where the bodies' images would be, to the pixel; edge-on nothing is drawn for it."""
    edge_on = abs(height) / NEAR * SIZE[1] / (2.0 * np.tan(0.45)) < LEAST_PIXELS
    side = -1.0 if height < -0.5 else 1.0
    scene(stage, mirror=False, sides=(side,) if edge_on else (1.0, -1.0))
    expected = bodies(stage.hdr(SIZE, camera(height)))
    scene(stage, mirror=True, sides=(side,))
    picture = stage.hdr(SIZE, camera(height))
    assert np.isfinite(picture).all()
    shown = stage.runtime.renderer.rows.mirrors.shown
    assert len(shown) == (0 if edge_on else 1)
    assert within_a_pixel(bodies(picture), expected)
    assert (expected == 1).sum() > (30 if edge_on else 60), "the ball, and its image"


@covers("light.reflection")
def test_from_above_and_from_below_are_each_other(stage: Stage) -> None:
    """A scene that is its own image: from under a mirror of two sides it looks as from over it, upside down."""
    scene(stage, mirror=True)
    over, under = (stage.hdr(SIZE, camera(height)) for height in (1.0, -1.0))
    assert len(stage.runtime.renderer.rows.mirrors.shown) == 1
    assert within_a_pixel(bodies(over), bodies(under)[::-1])
    assert set(np.unique(bodies(over))) == {0, 1, 2}


@covers("light.reflection")
def test_an_orthographic_camera_along_the_mirror(stage: Stage) -> None:
    """As with a perspective one: level, half a degree up, and 30 degrees."""
    for turn in (0.0, 1e-9, np.radians(0.5), np.radians(30.0)):
        eye = (0.3, 0.6 + 3.0 * np.sin(turn), 3.0 * np.cos(turn))
        flat = Camera(look_at(eye, (0.3, 0.6, 0.0)), znear=0.01, zfar=20.0, ymag=1.6)
        scene(stage, mirror=False)
        images = bodies(stage.hdr(SIZE, flat))
        scene(stage, mirror=True, sides=(1.0,))
        picture = stage.hdr(SIZE, flat)
        assert np.isfinite(picture).all()
        if turn > 0.1:
            assert within_a_pixel(bodies(picture), images)
        else:
            assert not stage.runtime.renderer.rows.mirrors.shown or turn > 1e-3


@covers("light.reflection", "pose.singular-scale")
@pytest.mark.parametrize("scale", [0.0, 1e-300, 1e-12, 1e30, 1e200])
def test_a_mirror_that_is_nowhere(stage: Stage, scale: float) -> None:
    """Flat, gone to nothing, endless: it mirrors nothing, and the rest of the picture stays."""
    scene(stage, mirror=False, sides=(1.0,))
    whole = stage.hdr(SIZE, camera(1.0))
    odd = stage.add(plane(1.0), surface(features=("planar_reflection",), metallic=1.0, roughness=0.0), (0.0, -0.5, 0.0))
    with np.errstate(all="ignore"):
        stage.runtime.scene.nodes.set_scale([odd], [(1.0, 1.0, scale)])
        stage.runtime.update()
        picture = stage.hdr(SIZE, camera(1.0))
    assert np.isfinite(picture).all()
    assert (bodies(picture) != bodies(whole)).mean() < 0.4
    assert len(stage.runtime.renderer.rows.mirrors.shown) <= 1
