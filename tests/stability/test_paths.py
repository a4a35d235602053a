"""One picture by every path: deferred, tiled, forward+, whatever the tiles and tests; at odd sizes, full of lights."""

from __future__ import annotations

import numpy as np
import pytest

from engine.assets.primitives import card, uv_sphere
from engine.assets.scene import LightAsset
from engine.render.lighting import DEPTHS, PATHS, TESTS, TILE_SIZES
from tests.stability.path_checks import NEEDING, layout_is_enough, paths_agree, poles, shoot, within_one_ulp
from tests.stability.rows import covers
from tests.support.stage import Stage, surface

pytestmark = pytest.mark.gl

OTHERS = [path for path in PATHS if path != "forward"]


@covers("light.path-agreement", "light.tile-depth")
@pytest.mark.parametrize("path", OTHERS)
def test_every_path_gives_the_same_picture(stage: Stage, path: str) -> None:
    paths_agree(stage, path)


@pytest.mark.parametrize("layout", range(len(NEEDING)))
def test_a_layout_of_the_gbuffer_is_enough(stage: Stage, layout: int) -> None:
    """What the narrow layouts leave out is not missed; that they leave it out: tests/render/test_gbuffer.py."""
    layout_is_enough(stage, layout)


@covers("light.tile-edges", "light.tile-depth")
def test_swapping_tiles_changes_no_bit(stage: Stage) -> None:
    """Tile sizes, tests of lights against tiles, ways to keep a tile's depth: more work or less, one picture."""
    poles(stage)
    expected = shoot(stage, path="forward-plus")
    for tile in TILE_SIZES:
        assert (shoot(stage, path="forward-plus", light_tile=str(tile)) == expected).all(), f"tiles of {tile}"
    for test in TESTS:
        for depth in DEPTHS:
            got = shoot(stage, path="forward-plus", light_tile="8", light_test=test, light_depth=depth)
            assert (got == expected).all(), f"{test}, {depth}"


@covers("light.tile-edges", "size.odd")
@pytest.mark.parametrize("path", OTHERS)
def test_paths_agree_at_odd_sizes(stage: Stage, path: str) -> None:
    poles(stage, 6)
    for size in ((1, 1), (17, 31), (33, 1), (1, 9)):
        assert within_one_ulp(shoot(stage, size, path="forward"), shoot(stage, size, path=path)), f"{size}"


@covers("light.order")
@pytest.mark.parametrize("path", OTHERS)
def test_lights_in_any_order_by_any_path(stage: Stage, path: str) -> None:
    rng = np.random.default_rng(3)
    places, colors = np.add(rng.uniform(-1.0, 1.0, (20, 3)), (0.0, 0.0, 1.5)), rng.uniform(0.0, 1.0, (20, 3))
    pictures = []
    for order in (np.arange(20), rng.permutation(20)):
        stage.dark()
        stage.add(uv_sphere(), surface(base_color=(0.8, 0.7, 0.6, 1), metallic=0.3, roughness=0.4))
        for i in order:
            r, g, b = colors[i].tolist()
            stage.lamp(LightAsset("point", (r, g, b), intensity=0.3, range=4.0), places[i])
        pictures.append(shoot(stage, path=path))
    assert within_one_ulp(*pictures)
    assert pictures[0].max() > 0.1


@covers("light.very-many", "format.half-sums")
@pytest.mark.parametrize("path", OTHERS)
def test_ten_thousand_lights_in_one_tile(stage: Stage, path: str) -> None:
    """All of them in every tile: the picture of one that is as bright, no light lost."""
    count, pictures = 10_000, []
    for lights in (1, count):
        stage.dark()
        stage.add(card(4.0), surface(base_color=(0.5, 0.5, 0.5, 1), metallic=0.0, roughness=0.6))
        scene = stage.runtime.scene
        node = scene.nodes.add("lamp", -1, (0.0, 0.0, 1.0))
        for _ in range(lights):
            scene.lights.add(node, LightAsset("point", intensity=2.0 / lights))
        stage.runtime.update()
        pictures.append(shoot(stage, (8, 8), path=path))
    np.testing.assert_allclose(pictures[0], pictures[1], rtol=4e-3)
    assert pictures[0][..., 0].min() > 0.01
