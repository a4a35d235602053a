"""One picture by every path, as functions: also run against passes with planted bugs."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.assets.primitives import card, cube, plane, uv_sphere
from engine.assets.scene import LightAsset
from tests.support.stage import Stage, front_camera, surface

F4 = NDArray[np.float32]
SIZE = (37, 23)


def poles(stage: Stage, lights: int = 24) -> None:
    """Thin poles at many depths before an empty sky, a floor, a pane: tiles of nothing, of one body, of many depths."""
    stage.look(kind="uniform", color=(0.05, 0.06, 0.08), sun_illuminance=0.0, background="color")
    rng = np.random.default_rng(8)
    grey = surface(base_color=(0.7, 0.7, 0.7, 1), metallic=0.0, roughness=0.5)
    stage.add(plane(6.0), grey, (0.0, -0.7, -1.0))
    for i in range(7):
        stage.add(cube(), grey, (-0.9 + 0.3 * i, 0.0, -0.7 * i), (0.05, 1.2, 0.05))
    stage.add(uv_sphere(0.3), surface(base_color=(0.9, 0.4, 0.2, 1), metallic=1.0, roughness=0.3), (0.3, 0.2, 0.3))
    stage.add(card(0.5), surface("transparent", base_color=(0.2, 0.5, 0.9, 0.4)), (-0.5, 0.2, 0.8))
    places = rng.uniform((-1.2, -0.6, -4.0), (1.2, 0.8, 1.0), (lights, 3))
    for place, color, kind in zip(places, rng.random((lights, 3)), rng.choice(["point", "spot"], lights), strict=True):
        r, g, b = color.tolist()
        stage.lamp(LightAsset(str(kind), (r, g, b), 0.5, float(rng.uniform(0.2, 2.0))), place)


def shoot(stage: Stage, size: tuple[int, int] = SIZE, **settings: object) -> F4:
    got = stage.hdr(size, front_camera(0.8, size[0] / size[1]), **settings)
    assert np.isfinite(got).all()
    return got


def within_one_ulp(a: F4, b: F4) -> bool:
    """Of a half float, in which light is kept."""
    ulp = np.spacing(np.maximum(np.abs(a), np.abs(b)).astype(np.float16)).astype(np.float32)
    return bool((np.abs(a - b) <= ulp).all())


def paths_agree(stage: Stage, path: str) -> None:
    """`path` and forward give one picture, of lamps."""
    poles(stage)
    expected = shoot(stage, path="forward")
    got = shoot(stage, path=path)
    assert stage.runtime.renderer.path.path == path
    assert within_one_ulp(expected, got), f"{path} differs from forward by up to {np.abs(expected - got).max():.3g}"
    assert expected.max() > 0.1
