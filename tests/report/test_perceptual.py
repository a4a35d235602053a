"""FLIP and SSIM: known answers, and what may not fool them."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from engine.core.errors import InputError, LucarnaError
from engine.report.perceptual import flip, magma, ssim


@pytest.fixture
def picture() -> np.ndarray:
    x = np.linspace(0.0, 1.0, 64)
    return np.stack([np.broadcast_to(x, (64, 64)), np.broadcast_to(x[:, None], (64, 64)), np.full((64, 64), 0.5)], -1)


def test_equal_pictures(picture: np.ndarray) -> None:
    mean, error_map = flip(picture, picture)
    assert mean == 0.0
    assert error_map.shape == (64, 64)
    assert ssim(picture, picture) == 1.0


def test_black_against_white_is_the_greatest_difference() -> None:
    black, white = np.zeros((32, 32, 3)), np.ones((32, 32, 3))
    assert flip(black, white)[0] == pytest.approx(0.97, abs=0.04)
    assert ssim(black, white) == pytest.approx(1e-4 / (1 + 1e-4), rel=0.01), "only C1 is left: (0.01)^2"


def test_a_larger_difference_is_larger(picture: np.ndarray) -> None:
    steps = [flip(np.clip(picture + d, 0.0, 1.0), picture)[0] for d in (0.02, 0.08, 0.3)]
    assert steps == sorted(steps)
    assert steps[0] > 0.0


def test_bytes_and_floats_agree(picture: np.ndarray) -> None:
    as_bytes = np.rint(picture * 255.0).astype(np.uint8)
    exact = as_bytes / 255.0
    other = 255 - as_bytes
    assert flip(as_bytes, other)[0] == pytest.approx(flip(exact, other / 255.0)[0], abs=1e-6)


def test_hdr_sees_what_ldr_clips() -> None:
    reference = np.full((16, 16, 3), 4.0, np.float32)
    brighter = reference * 4.0
    assert flip(brighter, reference)[0] == 0.0
    assert flip(brighter, reference, hdr=True)[0] > 0.1


def test_a_nan_is_seen(picture: np.ndarray) -> None:
    bad = picture.copy()
    bad[5, 7] = np.nan
    assert flip(bad, picture)[1][5, 7] == 1.0
    assert ssim(bad, picture) == -1.0


def test_shapes(picture: np.ndarray) -> None:
    with pytest.raises(InputError, match="shapes"):
        flip(picture, picture[:-1])
    with pytest.raises(InputError, match="7 x 7"):
        ssim(picture[:4], picture[:4])


def test_missing_packages_say_what_to_install(picture: np.ndarray, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, call in (("flip_evaluator", flip), ("skimage.metrics", ssim)):
        monkeypatch.setitem(sys.modules, name, None)
        with pytest.raises(LucarnaError, match=r"lucarna\[report\]"):
            call(picture, picture)


def test_magma_gets_brighter() -> None:
    colors = magma(np.linspace(0.0, 1.0, 33)[None, :])
    assert colors.shape == (1, 33, 3)
    assert (np.diff(colors.astype(int).sum(axis=2)) > 0).all()
    assert tuple(magma(np.array([[np.nan]]))[0, 0]) == (252, 253, 191)
