"""TAA: the mean of its frames, the supersampled picture in the end; nothing dragged along; nothing where it is off."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from engine.assets.primitives import card
from engine.render.motion.jitter import pixel_jitter
from engine.render.passes.taa import part_of
from tests.support import poison
from tests.support.stage import front_camera

pytestmark = pytest.mark.gl

SIZE, FINER = (40, 32), 8
CAMERA = front_camera(0.5, SIZE[0] / SIZE[1])


def glow(surface, strength: float = 0.7):
    return surface(base_color=(0.0, 0.0, 0.0, 1.0), specular=0.0, emissive=(1.0, 1.0, 1.0), emissive_strength=strength)


def edge(stage, surface, strength: float = 0.7, degrees: float = 20.0) -> int:
    """A card that shines, turned, on black; its node."""
    stage.dark()
    half = math.radians(degrees) / 2.0
    return stage.add(card(0.5), glow(surface, strength), rotation=(0.0, 0.0, math.sin(half), math.cos(half)))


def live(stage, *, frames: int = 1, cut: bool = False, size=SIZE, camera=CAMERA, **settings):
    """f4[h,w]: one channel of the last of some frames in a row."""
    view = replace(stage.view(size, camera, **{"antialias": "taa", **settings}), seconds=0.02)
    for frame in range(frames):
        picture = stage.runtime.render(replace(view, cut=cut and frame == 0), hdr=True)
    return np.asarray(picture.hdr.read(), np.float64)[..., 0]


def truth(stage) -> np.ndarray:
    fine = stage.hdr((SIZE[0] * FINER, SIZE[1] * FINER), CAMERA)[..., 0].astype(np.float64)
    return fine.reshape(SIZE[1], FINER, SIZE[0], FINER).mean(axis=(1, 3))


def rmse(a, b) -> float:
    return float(np.sqrt(np.mean((a - b) ** 2)))


def test_a_picture_is_the_mean_of_its_frames(stage, surface) -> None:
    """Frame by frame what was drawn, read back before it was mixed: their mean is the picture, to its half floats."""
    edge(stage, surface)
    frames = 5
    drawn = []
    for index in range(frames):
        view = replace(stage.view(SIZE, CAMERA, antialias="taa", taa_frames=frames), seconds=0.0, cut=index == 0)
        drawn.append(poison.shoot(stage.runtime, view, "opaque").outputs["hdr"][..., 0].astype(np.float64))
    assert len({d.tobytes() for d in drawn}) == frames, "each looks elsewhere"
    got = stage.hdr(SIZE, CAMERA, antialias="taa", taa_frames=frames)[..., 0]
    assert np.abs(got - np.mean(drawn, axis=0)).max() < 1e-3


def test_it_converges_to_the_supersampled_picture(stage, surface) -> None:
    edge(stage, surface)
    best = truth(stage)
    errors = [rmse(stage.hdr(SIZE, CAMERA, antialias="taa", taa_frames=n)[..., 0], best) for n in (1, 4, 16, 64)]
    assert errors == sorted(errors, reverse=True)
    assert errors[0] == pytest.approx(rmse(stage.hdr(SIZE, CAMERA)[..., 0], best))
    assert errors[2] < 0.2 * errors[0]
    assert errors[3] < 0.1 * errors[0]
    got = stage.hdr(SIZE, CAMERA, antialias="taa", taa_frames=64)[..., 0]
    assert got.sum() == pytest.approx(best.sum(), rel=2e-3)
    assert rmse(live(stage, frames=64, cut=True), best) < 0.2 * errors[0], "as frames come, too"


def test_a_picture_depends_on_nothing_but_the_scene(stage, surface) -> None:
    edge(stage, surface)
    first = stage.ldr(SIZE, CAMERA, antialias="taa")
    live(stage, frames=3)
    stage.ldr(SIZE, front_camera(0.3, SIZE[0] / SIZE[1]), antialias="taa")
    assert np.array_equal(stage.ldr(SIZE, CAMERA, antialias="taa"), first)


def test_a_moving_edge_is_smoother_than_without(stage, surface) -> None:
    """A card that goes 0.4 pixels a frame: nearer to the truth of the moment than one sample a pixel."""
    node = edge(stage, surface)
    step = 0.4 * 2.0 * 0.5 / SIZE[1]
    places = [(step * (i - 12), 0.3 * step * (i - 12), 0.0) for i in range(13)]
    for i, place in enumerate(places):
        stage.runtime.scene.nodes.set_translation([node], [place])
        got = live(stage, cut=i == 0)
    best = truth(stage)
    assert rmse(got, best) < 0.6 * rmse(stage.hdr(SIZE, CAMERA)[..., 0], best)


def test_nothing_is_dragged_along(stage, surface) -> None:
    """Behind a bright card that went away there is what is there: at once where its edge was known, and no more than
    a fiftieth of its light in any pixel anywhere else."""
    node = edge(stage, surface, strength=1.0, degrees=0.0)
    live(stage, frames=8, cut=True)
    for i in range(3):
        stage.runtime.scene.nodes.set_translation([node], [(0.06 * (i + 1), 0.0, 0.0)])
        got = live(stage)
    now = stage.hdr(SIZE, CAMERA)[..., 0]
    left = np.pad(now, 1, mode="edge")
    around = np.max(
        [left[1 + dy : 1 + dy + SIZE[1], 1 + dx : 1 + dx + SIZE[0]] for dx in (-1, 0, 1) for dy in (-1, 0, 1)], 0
    )
    empty = around == 0.0
    assert empty.sum() > 200
    assert got[empty].max() < 0.02


def test_a_light_that_goes_out_is_out(stage, surface) -> None:
    """Nothing moves, so that motion says nothing; colours around do: the next frame is dark."""
    stage.look(kind="uniform", color=(1.0, 1.0, 1.0), sun_illuminance=0.0)
    stage.add(card(4.0), surface(base_color=(0.5, 0.5, 0.5, 1.0), metallic=0.0))
    bright = live(stage, frames=8, cut=True)
    stage.runtime.scene.environment.intensity = 0.01
    assert live(stage).mean() < 0.02 * bright.mean()


def test_a_cut_leaves_nothing(stage, surface) -> None:
    node = edge(stage, surface)
    live(stage, frames=5, cut=True)
    stage.runtime.scene.nodes.set_translation([node], [(0.1, 0.0, 0.0)])
    after = live(stage, cut=True)
    fresh = live(stage, cut=True)
    assert np.array_equal(after, fresh)
    x, y = pixel_jitter(0, 16)
    assert (x, y) != (0.0, 0.0)


def test_a_bright_edge_has_no_stairs(stage, surface) -> None:
    """At a hundred times white one covered sample of 16 shows as a sixteenth or so of what a display makes of it."""
    edge(stage, surface, strength=100.0)
    got = np.minimum(stage.hdr(SIZE, CAMERA, antialias="taa")[..., 0], 1.0)
    between = (got > 0.03) & (got < 0.97)
    assert between.sum() > 25, "without weights nearly every pixel of the edge would be white"


def test_sharpening_makes_no_new_extremes(stage, surface) -> None:
    edge(stage, surface)
    soft, sharp = (live(stage, frames=20, cut=True, taa_sharpness=s) for s in (0.0, 1.0))
    assert sharp.max() <= soft.max() + 1e-3
    assert sharp.min() >= soft.min()
    assert np.abs(np.diff(sharp, axis=1)).max() > np.abs(np.diff(soft, axis=1)).max()


def test_off_is_nothing(stage, surface) -> None:
    edge(stage, surface)
    off = stage.ldr(SIZE, CAMERA)
    view = replace(stage.view(SIZE, CAMERA), seconds=0.02)
    assert np.array_equal(stage.runtime.render(view).color.read(), off)
    for settings in ({"samples": 4}, {"view": "normal"}):
        assert np.array_equal(stage.ldr(SIZE, CAMERA, antialias="taa", **settings), stage.ldr(SIZE, CAMERA, **settings))
    frame = stage.runtime.render(view)
    assert {"taa", "motion", "motion_late"} <= {item.name for item in frame.graph.left_out}


@pytest.mark.parametrize("size", [(1, 1), (2, 1), (3, 17)])
def test_small_pictures(stage, surface, size) -> None:
    edge(stage, surface)
    assert np.isfinite(live(stage, frames=3, size=size)).all()


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 1e38])
def test_a_bad_texel_of_before_goes(stage, surface, value) -> None:
    edge(stage, surface)
    stage.runtime.scene.nodes.add("somebody else")
    view = replace(stage.view(SIZE, CAMERA, antialias="taa"), seconds=0.02)
    graph = [stage.runtime.render(replace(view, cut=cut), hdr=True).graph for cut in (True, False)][-1]
    poison.put(stage.device, graph.texture("taa_mean"), 5, 5, value)  # it is what was before in the next frame
    clean = stage.hdr(SIZE, CAMERA)[..., 0]
    stage.runtime.scene.nodes.set_translation(
        [1], [(0.3, 0.0, 0.0)]
    )  # somebody else moves: all is held to what is seen
    for _ in range(2):
        got = live(stage)
        assert np.isfinite(got).all()
        assert abs(got[5, 5] - clean[5, 5]) < 0.05


def test_the_weight_of_a_frame() -> None:
    assert [part_of(i, i, 0.1) for i in range(4)] == [1.0, 0.5, 1.0 / 3.0, 0.25], "a plain mean from a cut on"
    assert part_of(30, 0, 0.1) == 0.1
    assert part_of(2, 0, 0.1) == pytest.approx(1.0 / 3.0)
    assert part_of(100, 1, 0.1) == pytest.approx(0.2), "what was gathered while things moved counts as three frames"
