"""Shadows of a sun and of lamps that move, and of any number of cascades, where the right answer is known."""

from __future__ import annotations

import math

import numpy as np
import pytest

from engine.assets.primitives import plane
from engine.assets.scene import LightAsset
from engine.math.transform import look_at
from engine.render.camera import Camera
from tests.support.stage import surface

pytestmark = pytest.mark.gl

SIZE = (96, 96)
HALF = 1.5
STEPS = 9


def above(stage) -> Camera:
    stage.look(kind="none", background="color", background_color=(0, 0, 0), sun_illuminance=0.0)
    grey = surface(base_color=(0.5, 0.5, 0.5, 1.0), metallic=0.0, specular=0.0)
    stage.add(plane(12.0), grey)
    turned = (0.0, math.sin(0.2), 0.0, math.cos(0.2))  # its edges lie along no row of texels
    stage.add(plane(1.0), grey, (0.0, 1.0, 0.0), rotation=turned)
    return Camera(look_at((0.0, 0.9, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, -1.0)), znear=0.01, zfar=2.0, ymag=HALF)


def seen(stage, camera: Camera, **settings) -> np.ndarray:
    """Visibility f8[h,w] of the one light."""
    bare = stage.hdr(SIZE, camera, **{**settings, "shadows": False, "local_shadows": "off"})[..., 0]
    with_it = stage.hdr(SIZE, camera, local_shadows="all", **settings)[..., 0]
    return np.asarray(with_it, np.float64) / np.maximum(bare, 1e-9)


def restlessness(frames: list[np.ndarray], truths: list[np.ndarray]) -> float:
    """How much more the pictures change from frame to frame, all in all, than they must."""
    ours, must = (np.abs(np.diff(np.stack(part), axis=0)).sum() for part in (frames, truths))
    assert must > 10.0
    return float(ours / must)


def shade(center: np.ndarray, scale: float) -> np.ndarray:
    """f8[h,w]: 0 in the square of width `scale`, turned as the card is, 1 beside it; edges as pixels see them."""
    fine = 4
    along = (np.arange(SIZE[0] * fine) + 0.5) / (SIZE[0] * fine) * 2.0 - 1.0
    x, z = np.meshgrid(along * HALF - center[0], along * HALF - center[1])
    a, b = math.cos(0.4) * x - math.sin(0.4) * z, math.sin(0.4) * x + math.cos(0.4) * z
    lit = (np.maximum(np.abs(a), np.abs(b)) > scale / 2.0).astype(np.float64)
    return lit.reshape(SIZE[1], fine, SIZE[0], fine).mean(axis=(1, 3))


@pytest.mark.parametrize("filter", ["pcf", "vogel16", "evsm4"])
@pytest.mark.parametrize("light", ["sun", "point"])
def test_a_light_that_moves_does_not_make_edges_flicker(stage, light: str, filter: str) -> None:
    """Steps of a fraction of a texel: all changes of all pixels against those of the geometry. The sun's map lies still
    in the world, so that an edge only moves on; a lamp's map goes with it, and with it the stairs of its texels."""
    camera = above(stage)
    if light == "point":
        stage.lamp(LightAsset("point", intensity=5.0), (0.0, 3.0, 0.0))
    frames, truths = [], []
    for i in range(STEPS):
        t = 0.05 * i / STEPS
        if light == "sun":
            environment = stage.runtime.scene.environment
            environment.sun_illuminance, environment.sun_elevation = 2.0, math.pi / 2 - t
            environment.sun_azimuth = 0.3
            away = math.tan(t) * np.array([-math.sin(0.3), math.cos(0.3)])
            truths.append(shade(_towards(stage, camera, away), 1.0))
        else:
            node = int(stage.runtime.scene.lights.node[0])
            stage.runtime.scene.nodes.set_translation([node], [[t, 3.0, 0.4 * t]])
            stage.runtime.update()
            truths.append(shade(-0.5 * np.array([t, 0.4 * t]), 1.5))
        frames.append(seen(stage, camera, shadow_filter=filter, shadow_size=512, local_shadow_size=1024))
    assert np.abs(frames[-1] - truths[-1]).mean() < 0.02
    assert restlessness(frames, truths) < (1.1 if light == "sun" else 3.5 if filter == "pcf" else 2.5)


def _towards(stage, camera: Camera, away: np.ndarray) -> np.ndarray:
    """The shadow's middle: of the two ways that an azimuth may count, the one that the renderer's sun shines."""
    stage.hdr((8, 8), camera)
    direction = stage.runtime.renderer.rows.lights.suns[0, 0, :3].astype(np.float64)
    found = direction[[0, 2]] / -direction[1]
    assert np.linalg.norm(found) == pytest.approx(np.linalg.norm(away), abs=1e-3)
    return found


@pytest.mark.parametrize(("count", "weight"), [(1, 0.9), (2, 0.0), (3, 0.5), (5, 1.0), (8, 0.0), (8, 0.9)])
def test_any_number_of_cascades_however_split_shows_one_shadow(stage, count: int, weight: float) -> None:
    camera = above(stage)
    environment = stage.runtime.scene.environment
    environment.sun_illuminance, environment.sun_elevation = 2.0, math.pi / 2
    settings = {"shadow_cascades": count, "shadow_split": weight, "shadow_size": 256}
    got = seen(stage, camera, **settings)
    assert 1 <= len(stage.runtime.renderer.rows.shadows.cascades) <= count
    assert np.abs(got - shade(np.zeros(2), 1.0)).mean() < 0.03
    low = Camera(look_at((0.0, 0.6, 3.0), (0.0, 0.0, -2.0)), 0.9, znear=0.01)
    one, other = (seen(stage, low, **{**settings, "shadow_size": s}) for s in (512, 1024))
    assert np.abs(one - other).mean() < 0.02
