"""How the atlas is divided: nothing overlaps, the important stay wide, equal input gives equal tiles."""

from __future__ import annotations

import numpy as np
import pytest

from engine.render.shadows.atlas import MIN_TILE, divide


def cover(tiles, faces, atlas: int) -> np.ndarray:
    used = np.zeros((atlas, atlas), int)
    for width, corners, count in zip(tiles.width, tiles.corner, faces, strict=True):
        for x, y in corners[: count if width else 0]:
            assert x + width <= atlas
            assert y + width <= atlas
            used[y : y + width, x : x + width] += 1
    return used


@pytest.mark.parametrize("count", [0, 1, 3, 40])
def test_tiles_never_overlap(count) -> None:
    rng = np.random.default_rng(count)
    faces = rng.choice([1, 6], count)
    share, weight = rng.uniform(0.01, 1.0, count), rng.uniform(size=count)
    tiles = divide(share, weight, faces, 512, 256)
    assert cover(tiles, faces, 512).max(initial=0) <= 1
    again = divide(share, weight, faces, 512, 256)
    assert np.array_equal(tiles.width, again.width)
    assert np.array_equal(tiles.corner, again.corner)
    on = tiles.width > 0
    assert all(MIN_TILE <= w <= 256 and w & (w - 1) == 0 for w in tiles.width[on].tolist())


def test_a_full_atlas_is_full_and_the_brightest_stay() -> None:
    rng = np.random.default_rng(1)
    faces, weight = np.ones(300, int), rng.uniform(size=300)
    tiles = divide(np.ones(300), weight, faces, 512, 256)
    assert (tiles.width > 0).sum() == 256  # 16 x 16 tiles of 32
    assert (cover(tiles, faces, 512) == 1).all()
    assert weight[tiles.width > 0].min() > weight[tiles.width == 0].max()


def test_width_follows_importance() -> None:
    share, weight = np.array([1.0, 0.5, 0.49, 0.01]), np.ones(4)
    tiles = divide(share, weight, np.ones(4, int), 1024, 4)
    assert tiles.width.tolist() == [512, 256, 128, 32]
    assert divide(share, weight, np.full(4, 6), 1024, 2).width.tolist() == [256, 128, 0, 0]
    assert divide(share, weight, np.ones(4, int), 16, 4).width.max() <= 16
