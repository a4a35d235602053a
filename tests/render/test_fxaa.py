"""FXAA and SMAA: nearer to the supersampled picture, flat areas to the bit, nothing where they are off."""

from __future__ import annotations

import math

import numpy as np
import pytest

from engine.assets.primitives import card
from engine.math.color import srgb_to_linear
from tests.support.stage import front_camera

pytestmark = pytest.mark.gl

SIZE, FINER = (48, 40), 8


@pytest.fixture(params=["fxaa", "smaa"])
def form(request) -> str:
    return str(request.param)


def edge(stage, surface, degrees: float) -> None:
    """A grey card, turned, on black."""
    stage.dark()
    grey = surface(base_color=(0.0, 0.0, 0.0, 1.0), specular=0.0, emissive=(1.0, 1.0, 1.0), emissive_strength=0.7)
    half = math.radians(degrees) / 2.0
    stage.add(card(0.6), grey, rotation=(0.0, 0.0, math.sin(half), math.cos(half)))


def shown(stage, size=SIZE, **settings):
    return stage.ldr(size, front_camera(0.5, size[0] / size[1]), **settings)


@pytest.mark.parametrize("degrees", [4.0, 20.0, 33.0, 77.0])
def test_edges_come_nearer_to_the_truth(stage, surface, form, degrees) -> None:
    edge(stage, surface, degrees)
    fine = srgb_to_linear(shown(stage, (SIZE[0] * FINER, SIZE[1] * FINER))[..., 0] / 255.0)
    truth = fine.reshape(SIZE[1], FINER, SIZE[0], FINER).mean(axis=(1, 3))
    bare, smooth = (srgb_to_linear(shown(stage, antialias=a)[..., 0] / 255.0) for a in ("none", form))
    before, after = (np.sqrt(np.mean((picture - truth) ** 2)) for picture in (bare, smooth))
    assert after < 0.7 * before
    assert smooth.sum() == pytest.approx(truth.sum(), rel=0.02)


def test_what_has_no_edge_stays(stage, surface, form) -> None:
    """Away from the card's edge no byte changes, and a mirrored picture gives the mirrored result."""
    edge(stage, surface, 20.0)
    bare, smooth = shown(stage), shown(stage, antialias=form)
    luma = bare[..., 0].astype(int)
    padded = np.pad(luma, 1, mode="edge")
    around = np.stack([padded[1 + dy : 41 + dy, 1 + dx : 49 + dx] for dy, dx in ((0, 1), (0, -1), (1, 0), (-1, 0))])
    flat = (around == luma).all(axis=0)
    assert flat.sum() > 1000
    assert np.array_equal(smooth[flat], bare[flat])
    assert (smooth != bare).any()
    edge(stage, surface, 0.0)
    assert np.array_equal(shown(stage, antialias=form), shown(stage, antialias=form)[::-1, ::-1])


def test_off_is_nothing(stage, surface, form) -> None:
    edge(stage, surface, 20.0)
    assert np.array_equal(shown(stage, samples=4, antialias=form), shown(stage, samples=4))
    view = {"view": "normal"}
    assert np.array_equal(shown(stage, antialias=form, **view), shown(stage, **view))


@pytest.mark.parametrize("size", [(1, 1), (2, 1), (3, 17)])
def test_small_pictures(stage, surface, form, size) -> None:
    edge(stage, surface, 20.0)
    assert shown(stage, size, antialias=form).shape == (size[1], size[0], 4)
