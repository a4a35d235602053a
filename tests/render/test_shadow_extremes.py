"""Shadows where numbers are at their ends: depth ranges, sizes, nothing at all; and cameras that hardly move."""

from __future__ import annotations

import math

import numpy as np
import pytest

from engine.assets.primitives import card, cube, plane, uv_sphere
from engine.assets.scene import LightAsset
from engine.math.transform import look_at
from engine.render.camera import Camera

pytestmark = pytest.mark.gl

SUN = {"sun_azimuth": -math.pi / 2, "sun_elevation": math.pi / 4}
DOWN = (math.sin(-math.pi / 4), 0.0, 0.0, math.cos(-math.pi / 4))
#: one of each kind: texels, compared, disc, search, moments of two and of four numbers
FAMILIES = ("none", "pcf", "vogel8", "pcss", "vsm", "msm")


def sunny(stage, **sun: float) -> None:
    stage.look(kind="none", background="color", background_color=(0, 0, 0), **{"sun_illuminance": 2.0, **SUN, **sun})


def brightness(stage, camera: Camera, size=(64, 48), **settings) -> np.ndarray:
    return stage.hdr(size, camera, **{"shadow_size": 256, **settings})[..., 0]


@pytest.mark.parametrize("filter", FAMILIES)
def test_near_of_a_millimetre_and_a_ground_of_a_thousand_kilometres(stage, surface, filter) -> None:
    """Between what is seen at 1e-3 m and at 1e6 m: the cube at 3 m still has its shadow, and all is finite."""
    sunny(stage)
    stage.add(plane(2e6), surface(metallic=0.0))
    stage.add(cube(), surface(metallic=0.0), (0.0, 0.5, 0.0))
    camera = Camera(look_at((1.0, 2.5, 3.0), (0.8, 0.0, 0.0)), 0.8, znear=1e-3, zfar=1e6)
    lit = brightness(stage, camera, shadows=False)
    seen = brightness(stage, camera, shadow_filter=filter, shadow_cascades=4, shadow_size=1024)
    assert np.isfinite(seen).all()
    if filter in ("none", "pcf", "vogel8"):
        assert 0.01 < (seen < 0.5 * lit).mean() < 0.6  # the others need finer maps, or less depth, than are left
    stage.add(plane(2e6), surface(metallic=0.0), (0.0, 1e-3, 0.0))
    away = Camera(look_at((5e4, 2.0, 0.0), (9e4, 0.0, 0.0)), 0.8, znear=1e-3, zfar=1e6)
    plain, shadowed = (brightness(stage, away, shadows=on, shadow_filter=filter) for on in (False, True))
    assert np.isfinite(shadowed).all()
    assert (shadowed >= 0.0).all()
    assert (plain > 0.0).mean() > 0.3


@pytest.mark.parametrize("filter", FAMILIES)
def test_nothing_and_one_pixel(stage, surface, filter) -> None:
    sunny(stage)
    assert not stage.hdr((8, 8), shadow_filter=filter)[..., :3].any()  # an empty scene
    stage.add(plane(4.0), surface(metallic=0.0))
    stage.add(plane(4.0), surface(metallic=0.0), (-1.0, 1.0, 0.0))
    camera = Camera(look_at((0.5, 0.9, 0.0), (0.5, 0.0, 0.0), (0.0, 0.0, -1.0)), 0.4, znear=0.01)
    assert stage.hdr((1, 1), camera, shadow_filter=filter, shadow_size=256)[0, 0, 0] == 0.0
    assert stage.hdr((1, 1), camera, shadow_filter=filter, shadows=False)[0, 0, 0] > 0.0


@pytest.mark.parametrize("filter", ["pcf", "pcss", "msm"])
@pytest.mark.parametrize("elevation", [math.pi / 2, -math.pi / 2, 0.0, 1e-6])
def test_a_sun_straight_above_below_and_on_the_horizon(stage, surface, filter, elevation) -> None:
    sunny(stage, sun_elevation=elevation)
    stage.add(plane(8.0), surface(metallic=0.0))
    stage.add(uv_sphere(), surface(metallic=0.0), (0.0, 1.5, 0.0))
    camera = Camera(look_at((2.0, 2.5, 4.0), (0.0, 0.5, 0.0)), 0.9, znear=0.05)
    seen, lit = brightness(stage, camera, shadow_filter=filter), brightness(stage, camera, shadows=False)
    assert np.isfinite(seen).all()
    assert (seen <= lit + 1e-6).all()
    if elevation == math.pi / 2:
        assert 0.01 < (seen < 0.5 * lit).mean() < 0.3


@pytest.mark.parametrize("filter", ["pcf", "vogel16", "pcss", "evsm4", "msm"])
@pytest.mark.parametrize("moved", [(0.0, 0.0, 0.0), (1e6, 0.0, 1e6)])
def test_a_seventh_of_a_texel_changes_no_shadow(stage, surface, filter, moved) -> None:
    """The camera steps sideways by 1/7 texel, seven times: the maps' texels stay where they are in the world, and so
    does the light of every place of the floor."""
    sunny(stage)
    stage.add(plane(30.0), surface(metallic=0.0), moved)
    stage.add(cube(), surface(metallic=0.0), np.add(moved, (0.0, 0.6, 0.0)))

    def camera(x: float) -> Camera:
        at = np.add(moved, (1.0 + x, 0.0, 0.0))
        return Camera(look_at(np.add(at, (0.0, 10.0, 0.0)), at, (0.0, 0.0, -1.0)), ymag=1.5, znear=0.1, zfar=30.0)

    options = {"shadow_filter": filter, "shadow_size": 128, "shadow_cascades": 2}
    first = brightness(stage, camera(0.0), **options)
    shadows = stage.runtime.renderer.rows.shadows
    before = list(shadows.cascades)
    texel = before[-1].texel
    assert texel > 2.0 * 3.0 / 48  # wider than pixels
    for k in range(1, 8):
        seen = brightness(stage, camera(k * texel / 7.0), **options)
        for old, new in zip(before, shadows.cascades, strict=True):
            steps = np.subtract((new.x, new.y), (old.x, old.y)) / old.texel
            assert new.texel == old.texel, k
            assert np.abs(steps - np.round(steps)).max() < 1e-4, k  # whole texels, if at all
        shift = k * texel / 7.0 / (3.0 / 48)
        low = math.floor(shift)
        part = shift - low
        # the picture before, moved by that part of a pixel, up to what lies between two of its pixels
        a, b = first[:, low : low + 50], first[:, low + 1 : low + 51]
        between = (1.0 - part) * a + part * b
        if filter in ("evsm4", "msm"):  # without a turn for each pixel, and smooth
            assert np.abs(seen[:, :50] - between).mean() < 0.01 * first.max()


@pytest.mark.parametrize("kind", ["point", "spot", "disk"])
def test_lamps_at_the_ends(stage, surface, kind) -> None:
    """On the floor, in it, a micrometre above, and a thousand kilometres away; near 1e-3 and far 1e6: finite, and no
    brighter than without shadows."""
    stage.dark()
    stage.add(card(20.0), surface(metallic=0.0), rotation=DOWN)
    stage.add(cube(), surface(metallic=0.0), (0.7, 0.25, 0.0), 0.5)
    lamp = LightAsset(kind, intensity=20.0, outer_angle=0.8, width=0.2, height=0.2, radius=0.05, casts_shadow=True)
    row = stage.lamp(lamp, (0.0, 1.0, 0.0), DOWN)
    camera = Camera(look_at((2.0, 2.5, 3.0), (0.3, 0.0, 0.0)), 0.9, znear=1e-3, zfar=1e6)
    nodes = stage.runtime.scene.nodes
    for height in (0.0, -0.5, 1e-6, 1e-3, 1.0, 1e6):
        nodes.set_translation([stage.runtime.scene.lights.node[row]], [(0.0, height, 0.0)])
        stage.runtime.update()
        lit = stage.hdr((32, 24), camera, local_shadows="off")
        seen = stage.hdr((32, 24), camera, local_shadow_size=256)
        assert np.isfinite(seen).all(), height
        assert (seen <= lit * (1.0 + 1e-3) + 1e-4).all(), height
