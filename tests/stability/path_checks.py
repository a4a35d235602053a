"""One picture by every path, as functions: also run against passes with planted bugs."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
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
    stage.lamp(LightAsset("point", (1.0, 0.9, 0.8), 0.5, 1.5), (0.5, 0.5, 1.1))  # the ball's: metal is lit, too


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


#: layout of the G-buffer -> a material that needs it
NEEDING: tuple[dict[str, Any], ...] = (
    {"metallic": 0.0}, {"metallic": 1.0}, {"metallic": 0.0, "specular_color": (1.0, 0.1, 0.1)},
)  # fmt: skip


def layout_is_enough(stage: Stage, layout: int) -> None:
    """A ball of that material looks as in the widest layout, which leaves nothing out. Every path packs its surfaces,
    so that paths agree in a layout that is too narrow, too."""
    stage.look(kind="none", background="color")
    stage.add(uv_sphere(0.4), surface(base_color=(0.9, 0.4, 0.2, 1), roughness=0.4, **NEEDING[layout]))
    stage.lamp(LightAsset("point", (1.0, 0.9, 0.8), 1.0, 5.0), (0.3, 0.5, 1.0))
    got = shoot(stage, path="deferred")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("engine.render.light_path.layout_of", lambda rows: 2)
        stage.runtime.renderer.light_path.layout = (None, 2)
        full = shoot(stage, path="deferred")
    # the layouts keep the same numbers in other fields of 16 bits
    assert np.abs(full - got).max() <= 1e-3 * full.max(), f"layout {layout} leaves out what is seen"
    assert full.max() > 0.05
