"""Looking through bodies at the ends: posts before them, the picture's border, light that cannot leave them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from engine.assets.material import MaterialAsset
from engine.assets.primitives import card, cube, plane, uv_sphere
from engine.math import quat
from engine.math.transform import look_at
from engine.render.camera import Camera
from tests.stability.rows import covers
from tests.support.stage import DARK, Stage, surface

pytestmark = pytest.mark.gl

SIZE = (72, 56)
RED, BLUE = (1.0, 0.0, 0.0, 1.0), (0.0, 0.2, 0.6, 1.0)
CAMERA = Camera(look_at((0.4, 0.9, 3.0), (0.0, -0.2, 0.0)), 0.8, znear=0.02)


def clear(*features: str, **params: Any) -> MaterialAsset:
    values = {"metallic": 0.0, "specular": 0.0, "roughness": 0.0, "ior": 1.5, **params}
    return replace(surface(features=("transmission", *features), **values), effect="layered")


def flat(color: tuple[float, ...]) -> MaterialAsset:
    return surface(features=("unlit",), base_color=color)


def water(stage: Stage, roughness: float, *, body: bool, glass: bool = True) -> None:
    """A blue ground under water, or about a ball of glass; a red post stands before it, nearer to the camera."""
    stage.look(**DARK)
    stage.add(plane(30.0), flat(BLUE), (0.0, -1.2, -5.0))
    stage.add(cube(), flat(RED), (0.15, 0.3, 1.2), (0.1, 1.1, 0.1))
    through = clear(roughness=roughness, thickness=0.9)
    if glass and body:
        stage.add(uv_sphere(0.6), through, (0.0, 0.0, 0.1))
    elif glass:
        stage.add(plane(6.0), through, (0.0, -0.5, -1.0))


@covers("light.refraction")
@pytest.mark.parametrize("roughness", [0.0, 0.3, 0.6])
@pytest.mark.parametrize("body", [True, False], ids=["ball", "water"])
@pytest.mark.parametrize("ortho", [False, True])
def test_a_post_before_the_water_is_never_in_it(stage: Stage, roughness: float, body: bool, ortho: bool) -> None:
    camera = replace(CAMERA, ymag=1.2, zfar=20.0) if ortho else CAMERA
    water(stage, roughness, body=body, glass=False)
    post = stage.hdr(SIZE, camera)[..., 0] > 0.0
    assert 40 < post.sum() < 400
    water(stage, roughness, body=body)
    seen = stage.hdr(SIZE, camera)
    assert np.isfinite(seen).all()
    assert seen[~post][:, 0].max() <= 1e-6
    assert seen[~post][:, 2].max() > 0.1
    untested = stage.hdr(SIZE, camera, refraction="bent")
    assert untested[~post][:, 0].max() > 0.02, "without the test it is seen there"


@covers("light.refraction")
def test_what_is_off_the_screen_is_taken_from_its_border(stage: Stage) -> None:
    """Balls of glass on all four borders before an even background show it, wherever the ray goes."""
    stage.look(kind="none", sun_illuminance=0.0, background="color", background_color=(0.2, 0.5, 0.8))
    for x, y in ((-1.2, 0.0), (1.2, 0.0), (0.0, 0.9), (0.0, -0.9)):
        stage.add(uv_sphere(0.5), clear(thickness=5.0), (x, y, 0.0))
    picture = stage.hdr(SIZE, Camera(look_at((0.0, 0.0, 2.6), (0.0, 0.0, 0.0)), 0.75, znear=0.02))
    assert np.abs(picture[..., :3] - (0.2, 0.5, 0.8)).max() < 2e-3


@covers("light.refraction")
@pytest.mark.parametrize("ior", [1.2, 1.5, 2.0])
def test_light_that_cannot_leave_a_body_is_reflected(stage: Stage, ior: float) -> None:
    """From inside, beyond asin(1 / ior) from the normal, a wall shows what is about the camera, and nothing beyond."""
    stage.look(
        kind="uniform", color=(0.0, 1.0, 0.0), sun_illuminance=0.0, background="color", background_color=(1.0, 0.0, 0.0)
    )  # fmt: skip
    turned = quat.from_axis_angle((0.0, 1.0, 0.0), np.pi)
    stage.add(card(100.0), clear("double_sided", thickness=0.5, ior=ior), rotation=turned)
    yfov = 2.2
    picture = stage.hdr(SIZE, Camera(look_at((0.0, 0.0, 1.0), (0.0, 0.0, 0.0)), yfov, znear=0.02))
    assert np.isfinite(picture).all()
    y, x = np.mgrid[0 : SIZE[1], 0 : SIZE[0]] + 0.5
    tangent = np.tan(yfov / 2)
    off = np.hypot((x / SIZE[0] * 2 - 1) * tangent * SIZE[0] / SIZE[1], (y / SIZE[1] * 2 - 1) * tangent)
    pixel = 2.0 * tangent / SIZE[1]
    limit = np.tan(np.arcsin(1.0 / ior))
    leaves, kept = off < limit - pixel, off > limit + pixel
    assert leaves.sum() > 100 < kept.sum()
    assert (picture[leaves][:, 0] > 0.9).all()
    assert (picture[kept][:, 0] == 0.0).all()
    assert (picture[kept][:, 1] > 0.9).all()
