"""Light between surfaces while pictures follow one another: bounces add up, lights go out, cuts forget; and mirrors."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from engine.app.headless import render_hdr
from engine.assets.primitives import card, cube, uv_sphere
from engine.assets.scene import LightAsset
from engine.experiments.harness.mirror_answers import bars
from engine.math import quat
from engine.math.transform import look_at
from engine.render.camera import Camera
from engine.render.gi.choice import RESTING
from engine.render.gi.state import is_cut

pytestmark = pytest.mark.gl

FLAT = quat.from_axis_angle((1.0, 0.0, 0.0), -math.pi / 2)
MATT = {"metallic": 0.0, "roughness": 1.0, "ior": 1.0, "specular": 0.0}


def film(stage, camera: Camera, frames: int, size: tuple[int, int] = (32, 32), **settings) -> list[np.ndarray]:
    """So many pictures that follow one another, each f8[h,w,3]."""
    view = stage.view(size, camera, **{"gi": "many", **settings})
    view.seconds = 1.0 / 60.0
    return [render_hdr(stage.runtime, view)[0][..., :3].astype(np.float64) for _ in range(frames)]


def box(stage, surface) -> Camera:
    stage.dark()
    glow = {**MATT, "base_color": (0.5, 0.5, 0.5, 1.0), "emissive": (0.25, 0.25, 0.25)}
    stage.add(cube(2.0), surface(features=("double_sided",), **glow))
    return Camera(look_at((0.0, 0.0, 0.95), (0.0, 0.0, 0.0)), 1.6)


def lamp(stage, surface) -> Camera:
    stage.dark()
    stage.add(card(3.0), surface(**MATT, base_color=(0.8, 0.3, 0.2, 1.0)), rotation=FLAT)
    stage.add(uv_sphere(0.4, 12, 24), surface(**MATT, base_color=(0.6, 0.6, 0.6, 1.0)), (0.0, 0.4, 0.0))
    stage.lamp(LightAsset("point", intensity=4.0), (0.8, 1.2, 0.8))
    return Camera(look_at((0.0, 1.0, 2.4), (0.0, 0.3, 0.0)), 0.7)


def test_a_bounce_is_added_each_frame(stage, surface) -> None:
    camera = box(stage, surface)
    whole = {"gi_unseen": "seen", "gi_radius": 10.0, "gi_smooth": False, "gi_half": False, "gi_directions": 4}
    means = [picture.mean() for picture in film(stage, camera, 12, **whole)]
    assert means[0] == pytest.approx(0.375, rel=0.02)  # e (1 + rho)
    assert means[1] == pytest.approx(0.4375, rel=0.02)  # e (1 + rho + rho^2)
    assert means[-1] == pytest.approx(0.5, rel=0.02)  # e / (1 - rho)


@pytest.mark.parametrize("smooth", [False, True])
def test_a_light_that_goes_out_is_gone(stage, surface, smooth) -> None:
    camera = lamp(stage, surface)
    lit = film(stage, camera, 8, gi_smooth=smooth)[-1]
    stage.runtime.scene.lights.set(0, intensity=0.0)
    after = film(stage, camera, 12, gi_smooth=smooth)
    assert lit.mean() > 0.05
    assert after[-1].max() < 0.01 * lit.max()


def test_a_still_camera_calms_down(stage, surface) -> None:
    camera = lamp(stage, surface)
    pictures = film(stage, camera, 20)
    steps = [np.abs(b - a).mean() for a, b in itertools.pairwise(pictures)]
    assert steps[-1] < 0.5 * steps[0]
    still = stage.hdr((32, 32), camera, gi="many", gi_bounces=8)[..., :3]
    assert np.abs(pictures[-1] - still).mean() < 0.01


def test_a_frame_says_when_light_has_come_to_rest(stage, surface) -> None:
    camera = lamp(stage, surface)
    view = stage.view((24, 24), camera, gi="one")
    view.seconds = 1.0 / 60.0
    frames, pictures = [], []
    for _ in range(RESTING + 4):
        frame = stage.runtime.render(view, hdr=True)
        frames.append(frame.settled)
        pictures.append(np.asarray(frame.hdr.read(), np.float64)[..., :3])
    assert frames == [i >= RESTING for i in range(len(frames))]
    best = stage.hdr((24, 24), camera, gi="one", gi_directions=16)[..., :3]
    off = [np.abs(pictures[i] - best).mean() for i in (1, RESTING)]
    assert off[1] < 0.5 * off[0]
    steps = [np.abs(b - a).mean() for a, b in itertools.pairwise(pictures)]
    assert max(steps[RESTING:]) < 0.1 * steps[1]
    stage.runtime.scene.lights.set(0, intensity=0.5)
    assert not stage.runtime.render(view).settled


def test_one_picture_of_many_has_all_of_its_light(stage, surface) -> None:
    """Frames that are gathered into one picture do not wait for each other's bounces."""
    camera = box(stage, surface)
    whole = {"gi_unseen": "seen", "gi_radius": 10.0, "gi_half": False, "gi_directions": 4}
    many = {"gi": "many", "gi_bounces": 8, **whole}
    run = {"antialias": "taa", "taa_frames": 4, "samples": 1, **many}
    picture = stage.hdr((32, 32), camera, **run)
    assert np.array_equal(stage.hdr((32, 32), camera, **run), picture)
    still = stage.hdr((32, 32), camera, **{**run, "antialias": "none"})
    assert picture[..., :3].mean() == pytest.approx(still[..., :3].mean(), rel=0.02)


def test_a_cut_forgets(stage, surface) -> None:
    camera = lamp(stage, surface)
    other = Camera(look_at((-2.0, 1.5, -1.5), (0.0, 0.3, 0.0)), 0.7)
    first = film(stage, other, 1)[0]
    film(stage, camera, 3)
    assert is_cut(camera, other, 3.0)
    assert np.array_equal(film(stage, other, 1)[0], first)
    moved = Camera(look_at((0.02, 1.0, 2.4), (0.0, 0.3, 0.0)), 0.7)
    assert not is_cut(camera, moved, 3.0)
    assert not is_cut(camera, camera, 3.0)


def test_a_still_picture_knows_no_frame_before(stage, surface) -> None:
    camera = lamp(stage, surface)
    fresh = stage.hdr((32, 32), camera, gi="many")
    film(stage, camera, 3)
    assert np.array_equal(stage.hdr((32, 32), camera, gi="many"), fresh)


def test_a_moving_box_leaves_no_trail(stage, surface) -> None:
    """A box that shines goes over the floor at 4 pixels a frame: what is known of it goes with it, its light on the
    floor is gone with it, and when it stops the picture soon is what a still one is."""
    stage.dark()
    stage.add(card(6.0), surface(**MATT, base_color=(0.7, 0.7, 0.7, 1.0)), rotation=FLAT)
    glow = {**MATT, "base_color": (0.5, 0.5, 0.5, 1.0), "emissive": (0.6, 0.4, 0.2)}
    node = stage.add(cube(1.0), surface(**glow), (-1.2, 0.5, 0.0))
    camera = Camera(look_at((0.0, 2.2, 4.2), (0.0, 0.3, 0.0)), 0.8)
    view = stage.view((64, 48), camera, gi="one", gi_half=False)
    view.seconds = 1.0 / 60.0
    for i in range(8):
        stage.runtime.scene.nodes.set_translation([node], [(-1.2 + 0.3 * i, 0.5, 0.0)])
        stage.runtime.update()
        frame = stage.runtime.render(view, hdr=True)
    moving = np.asarray(frame.hdr.read(), np.float64)[..., :3]
    state = np.asarray(frame.graph.texture("indirect_state").read(), np.float64)
    still = stage.hdr((64, 48), camera, gi="one", gi_half=False)[..., :3].astype(np.float64)
    box = still[..., 0] > 0.55
    inner = box[1:-1, 1:-1] & box[:-2, 1:-1] & box[2:, 1:-1] & box[1:-1, :-2] & box[1:-1, 2:]
    assert box.sum() > 150
    # all of the box is known for as long as it has gone, its leading edge too
    assert (state[1:-1, 1:-1, 1][inner] > 6.0).mean() > 0.9
    assert np.abs(moving - still)[~box].mean() < 0.005
    assert np.abs(moving - still)[~box].max() < 0.12
    for _ in range(8):
        rested = render_hdr(stage.runtime, view)[0][..., :3].astype(np.float64)
    assert np.abs(rested - still).mean() < 0.004
    assert np.abs(rested - still).max() < 0.06


def mirror(stage, surface) -> Camera:
    """A glowing wall, 1 high, behind a mirror floor."""
    stage.dark()
    stage.add(card(4.0), surface(base_color=(1.0, 1.0, 1.0, 1.0), metallic=1.0, roughness=0.0), rotation=FLAT)
    glow = {**MATT, "base_color": (0.0, 0.0, 0.0, 1.0), "emissive": (0.7, 0.5, 0.3)}
    stage.add(card(1.0), surface(**glow), (0.0, 0.5, -0.5), (3.0, 1.0, 1.0))
    return Camera(look_at((0.0, 1.2, 2.6), (0.0, 0.2, 0.0)), 0.8)


@pytest.mark.parametrize("half", [False, True])
def test_a_floor_mirrors_the_wall(stage, surface, half) -> None:
    """A spot of the floor z before the wall, seen from height e at a distance f, mirrors the wall at z e / f."""
    camera = mirror(stage, surface)
    seen = stage.hdr((96, 96), camera, reflections=True, gi_half=half, reflection_steps=64)[..., :3]
    bare = stage.hdr((96, 96), camera)[..., :3]
    clip = camera.clip_from_world(1.0)
    found = []
    for z in (0.2, 0.5, 0.9, 1.3, 1.6):
        p = clip @ np.array([0.0, 0.0, z - 0.5, 1.0])
        y = int((1.0 - p[1] / p[3]) * 48)
        height = z * 1.2 / (2.6 + 0.5 - z)
        expected = (0.7, 0.5, 0.3) if height < 1.0 else (0.0, 0.0, 0.0)
        assert seen[y, 48] == pytest.approx(expected, abs=0.03), z
        assert (bare[y, 48] < 0.01).all()
        found.append(height < 1.0)
    assert len(set(found)) == 2


def test_thin_bars_in_a_mirror_are_all_there(gl_device) -> None:
    """Two pixels wide, by formula, at every pixel; a ray that may not go far enough misses them."""
    found = bars(gl_device)
    assert np.isfinite(found.truth).sum() > 5000
    assert (found.truth > 0.0).sum() > 300
    assert (found.missed, found.false) == (0.0, 0.0)
    assert bars(gl_device, reflection_steps=8).missed > 0.5


def test_mirrors_alike_in_all_paths(stage, surface) -> None:
    camera = mirror(stage, surface)
    stage.lamp(LightAsset("point", intensity=4.0), (0.8, 1.2, 0.8))
    for settings in ({"reflections": True}, {"reflections": True, "gi": "one"}):
        truth = stage.hdr((40, 32), camera, path="forward", **settings)
        for path in ("deferred", "tiled-deferred", "forward-plus"):
            assert np.array_equal(stage.hdr((40, 32), camera, path=path, **settings), truth), path


def test_each_by_itself_is_what_it_is_with_everything(stage, surface) -> None:
    """Mirrors without gathered light and the other way round: forced passes add nothing."""
    camera = mirror(stage, surface)
    stage.lamp(LightAsset("point", intensity=4.0), (0.8, 1.2, 0.8))
    for settings in ({"reflections": True}, {"gi": "one"}, {"gi": "many"}):
        pruned = stage.hdr((32, 24), camera, **settings)
        assert np.array_equal(stage.hdr((32, 24), camera, force_all=True, **settings), pruned), settings
