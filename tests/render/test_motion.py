"""Motion vectors: known answers for cameras, nodes, joints, morph targets and sky; cuts; nothing where all is still."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from engine.animation.reach import joint_reach
from engine.assets.mesh import MorphTarget, Skeleton
from engine.assets.primitives import card
from engine.assets.scene import LightAsset
from engine.math import quat
from engine.render.camera import Camera
from engine.render.motion.before import is_cut
from engine.render.motion.frame import NOWHERE
from engine.render.motion.jitter import halton, pixel_jitter
from tests.support import poison
from tests.support.stage import front_camera

SIZE = (48, 36)
#: one place in a pixel: its middle
ON = {"antialias": "taa", "taa_frames": 1}
#: half floats of some pixels
CLOSE = 4e-3


def view_of(stage, camera, size=SIZE, **settings):
    return replace(stage.view(size, camera, **{**ON, **settings}), seconds=0.1)


def motion(stage, camera, size=SIZE, **settings):
    """f4[h,w,2] of the next frame."""
    view = view_of(stage, camera, size, **settings)
    passes = ("motion", "motion_late")
    name = passes[0] if settings.get("ambient_occlusion", "off") != "off" else passes[1]
    return poison.shoot(stage.runtime, view, name).outputs["motion"].astype(np.float64)


def rest(stage, camera, **settings) -> None:
    stage.runtime.render(view_of(stage, camera, **settings))


def at(position, yfov=0.8, znear=0.05, turn=0.0) -> Camera:
    pose = np.eye(4)
    pose[:3, :3] = quat.to_matrix3(quat.from_axis_angle((0.0, 1.0, 0.0), turn))
    pose[:3, 3] = position
    return Camera(pose, yfov, znear)


@pytest.mark.gl
@pytest.mark.parametrize("scale", [1.0, 1e4])
@pytest.mark.parametrize("where", [0.0, 1e6])
def test_a_moved_camera(stage, surface, scale, where) -> None:
    """A wall 3 units off, a step of 0.05 and one ahead of 0.1: similar triangles, at any scale and place."""
    place = np.array([where, 0.0, -where])
    stage.add(card(8.0), surface(), place, scale)
    focal = SIZE[1] / 2.0 / math.tan(0.4)
    start = place + np.array([0.0, 0.0, 3.0 * scale])
    rest(stage, at(start, znear=0.05 * scale))
    moved = motion(stage, at(start + np.array([0.05, 0.02, 0.0]) * scale, znear=0.05 * scale))
    assert np.abs(moved[..., 0] + 0.05 / 3.0 * focal).max() < CLOSE
    assert np.abs(moved[..., 1] - 0.02 / 3.0 * focal).max() < CLOSE
    rest(stage, at(start, znear=0.05 * scale))
    moved = motion(stage, at(start - np.array([0.0, 0.0, 0.1 * scale]), znear=0.05 * scale))
    x = np.arange(SIZE[0]) + 0.5 - SIZE[0] / 2.0
    assert np.abs(moved[SIZE[1] // 2, :, 0] - x * (1.0 - 2.9 / 3.0)).max() < 2 * CLOSE


@pytest.mark.gl
def test_a_turned_camera_moves_the_sky_and_all_depths_alike(stage, surface) -> None:
    stage.add(card(0.3), surface())
    rest(stage, at((0.0, 0.0, 3.0)))
    moved = motion(stage, at((0.0, 0.0, 3.0), turn=0.02))
    focal = SIZE[1] / 2.0 / math.tan(0.4)
    angle = np.arctan((np.arange(SIZE[0]) + 0.5 - SIZE[0] / 2.0) / focal)
    expected = focal * (np.tan(angle) - np.tan(angle - 0.02))
    row = moved[SIZE[1] // 2, :, 0]
    sky = np.r_[0:14, 34:48]
    assert np.abs(row[sky] - expected[sky]).max() < CLOSE, "there is no far plane: the sky turns as it should"
    middle = row[20:28] - expected[20:28]
    assert np.abs(middle).max() < CLOSE, "turning about the eye has no parallax"


@pytest.mark.gl
def test_a_moved_node_and_nothing_else(stage, surface) -> None:
    """The card alone, by its own way; what stands still has 0 to the bit although jitter is at work."""
    stage.add(card(4.0), surface(), (0.0, 0.0, -1.0))
    node = stage.add(card(0.3), surface())
    camera = front_camera(0.5, SIZE[0] / SIZE[1])
    jittered = {"taa_frames": 16}
    rest(stage, camera, **jittered)
    still = motion(stage, camera, **jittered)
    assert not still.any()
    stage.runtime.scene.nodes.set_translation([node], [(0.05, -0.02, 0.0)])
    moved = motion(stage, camera, **jittered)
    distance = camera.position[2]
    focal = SIZE[1] / 2.0 / math.tan(camera.yfov / 2.0) / distance
    inside = moved[SIZE[1] // 2 - 2 : SIZE[1] // 2 + 3, SIZE[0] // 2 - 2 : SIZE[0] // 2 + 4]
    assert np.abs(inside - (0.05 * focal, 0.02 * focal)).max() < CLOSE
    assert not moved[:6].any()
    assert 20 < np.count_nonzero(moved[..., 0]) < SIZE[0] * SIZE[1] / 2
    assert not motion(stage, camera, **jittered).any(), "it stands again"


@pytest.mark.gl
@pytest.mark.parametrize("method", ["linear", "dual_quaternion"])
def test_a_turning_joint(stage, method) -> None:
    """Every pixel of a skinned card was where the joint had it: turned back about the middle."""
    nodes = stage.runtime.scene.nodes
    joint = nodes.add("joint")
    mesh = card(0.7)
    count = mesh.vertex_count
    weights = np.zeros((count, 4), "<u2")
    weights[:, 0] = 65535
    mesh.streams |= {"joints": np.zeros((count, 4), "<u2"), "weights": weights}
    mesh.skeleton = Skeleton(["a"], np.array([-1], np.int32), np.eye(4, dtype="<f4")[None])
    node = stage.add(mesh)
    reach = joint_reach(mesh.streams["position"], mesh.streams["joints"], weights, mesh.skeleton.inverse_bind)
    skin = stage.runtime.scene.skins.add(node, [joint], mesh.skeleton.inverse_bind, reach)
    stage.runtime.scene.skins.set_method(skin, method)
    camera = front_camera(0.5, SIZE[0] / SIZE[1])
    stage.runtime.update()
    rest(stage, camera)
    angle = 0.1
    nodes.set_rotation([joint], [quat.from_axis_angle((0.0, 0.0, 1.0), angle)])
    moved = motion(stage, camera)
    y, x = np.mgrid[-3:4, -3:4] + 0.5  # pixels from the middle, down
    got = moved[SIZE[1] // 2 - 3 : SIZE[1] // 2 + 4, SIZE[0] // 2 - 3 : SIZE[0] // 2 + 4]
    c, s = math.cos(angle), math.sin(angle)
    # anticlockwise with y up; it was at the point turned back
    before = np.stack([c * x - s * y, s * x + c * y], axis=-1)
    assert np.abs(got - (np.stack([x, y], axis=-1) - before)).max() < CLOSE
    assert np.abs(got).max() > 0.2


@pytest.mark.gl
def test_a_morph_target(stage) -> None:
    mesh = card(0.6)
    away = np.zeros((mesh.vertex_count, 3), np.float32)
    away[:, 0] = 0.2
    mesh.morphs = [MorphTarget("right", {"position": away})]
    node = stage.add(mesh)
    stage.runtime.scene.morphs.add(node, ["right"], np.array([0.2]), [0.25])
    camera = front_camera(0.5, SIZE[0] / SIZE[1])
    rest(stage, camera)
    rest(stage, camera)
    stage.runtime.scene.morphs.set_node(node, [0.75])
    moved = motion(stage, camera)
    focal = SIZE[1] / 2.0 / math.tan(camera.yfov / 2.0) / camera.position[2]
    assert moved[SIZE[1] // 2, SIZE[0] // 2 + 2] == pytest.approx((0.1 * focal, 0.0), abs=CLOSE)
    assert not moved[:, :4].any()


@pytest.mark.gl
@pytest.mark.parametrize("alpha", [0.2, 0.8])
def test_what_is_cut_out_moves_as_what_is_behind_it(stage, surface, alpha) -> None:
    """A card that moves before one that stands: with its alpha below the cut nothing moves, above it the card does."""
    stage.add(card(4.0), surface(), (0.0, 0.0, -1.0))
    node = stage.add(card(0.3), surface("alpha_test", ("alpha_test",), base_color=(1.0, 1.0, 1.0, alpha)))
    camera = front_camera(0.5, SIZE[0] / SIZE[1])
    rest(stage, camera)
    rest(stage, camera)
    stage.runtime.scene.nodes.set_translation([node], [(0.05, 0.0, 0.0)])
    moved = motion(stage, camera)
    focal = SIZE[1] / 2.0 / math.tan(camera.yfov / 2.0) / camera.position[2]
    expected = 0.05 * focal if alpha > 0.5 else 0.0
    assert moved[SIZE[1] // 2, SIZE[0] // 2] == pytest.approx((expected, 0.0), abs=CLOSE)
    assert not moved[:4].any()


def test_effects_that_are_drawn_in_depth_say_how_far_they_moved(null_stage) -> None:
    """Else TAA would take what they show for standing still."""
    effects = null_stage.runtime.residency.effects
    shipped = [path.name.removesuffix(".effect.toml") for path in effects.search[-1].glob("effects/*.effect.toml")]
    solid = [name for name in shipped if "depth" in effects.get(name).techniques]
    assert len(solid) > 3
    assert [name for name in solid if "motion" not in effects.get(name).techniques] == []


@pytest.mark.gl
def test_what_was_behind_the_camera_was_nowhere(stage, surface) -> None:
    stage.add(card(20.0), surface(), (0.0, 0.0, -2.0))
    rest(stage, at((0.0, 0.0, -2.5)))
    moved = motion(stage, at((0.0, 0.0, 0.5)))
    assert (np.abs(moved) >= NOWHERE - 16.0).all()


@pytest.mark.gl
def test_all_paths_and_all_depths(stage, surface) -> None:
    """Known before shading where depth is drawn first, and after it elsewhere: the same numbers."""
    node = stage.add(card(0.4), surface())
    stage.add(card(4.0), surface(), (0.0, 0.0, -1.0))
    stage.lamp(LightAsset("point", intensity=4.0, range=9.0), (0.2, 0.0, 1.0))
    start, end = at((0.0, 0.0, 2.0)), at((0.03, 0.0, 2.0))
    found = []
    for number, settings in enumerate(
        [{"path": "forward"}, {"path": "deferred"}, {"path": "forward", "ambient_occlusion": "gtao"}]
    ):
        stage.runtime.scene.nodes.set_translation([node], [(0.0, 0.0, 0.0)])
        rest(stage, start, **settings)
        stage.runtime.scene.nodes.set_translation([node], [(0.0, 0.04, 0.0)])
        found.append(motion(stage, end, **settings))
        assert np.array_equal(found[number], found[0])
    assert found[0].any()


def test_when_the_frame_before_tells_nothing(null_stage, surface) -> None:
    stage = null_stage
    stage.add(card(4.0), surface())
    renderer, scene = stage.runtime.renderer, stage.runtime.scene
    start = view_of(stage, at((0.0, 0.0, 3.0)))

    def known(view) -> bool:
        renderer.render(scene, start)
        return renderer.before.begin(scene, view, np.zeros(3)).known

    assert not renderer.before.begin(scene, start, np.zeros(3)).known, "the first frame"
    assert known(start)
    assert known(replace(start, camera=at((0.1, 0.0, 3.0))))
    assert known(replace(start, camera=at((0.0, 0.0, 3.0), turn=0.3)))
    assert not known(replace(start, camera=at((0.0, 0.0, 3.0), turn=1.3))), "it turned too far"
    assert not known(replace(start, camera=at((0.0, 0.0, 9.0)))), "it jumped"
    assert not known(replace(start, camera=at((0.0, 0.0, 3.0), yfov=1.6))), "another lens"
    assert not known(replace(start, cut=True))
    assert not known(replace(start, width=47))
    assert not known(replace(start, seconds=None)), "a picture that depends on nothing but the scene"
    assert not known(replace(start, key="another view"))
    renderer.render(scene, start)
    renderer.before.begin(scene, start, np.zeros(3))
    assert not renderer.before.on_path("deferred").known
    assert is_cut(at((0.0,) * 3), replace(at((0.0,) * 3), ymag=1.0), 1.0)
    still = at((0.0,) * 3)
    assert not is_cut(still, still, math.inf)


def test_off_keeps_no_rows(null_stage, surface) -> None:
    stage = null_stage
    node = stage.add(card(1.0), surface())
    renderer, scene = stage.runtime.renderer, stage.runtime.scene
    view = replace(stage.view(SIZE, at((0.0, 0.0, 3.0))), seconds=0.1)
    for step in range(3):
        scene.nodes.set_translation([node], [(0.1 * step, 0.0, 0.0)])
        frame = renderer.render(scene, view)
        assert not frame.facts.motion
        assert not frame.facts.moving
    assert all(seen.rows is None for seen in renderer.before._views.values())
    assert renderer.rows.transforms.buffer.size < 2 * 48 * len(scene.nodes)


def test_jitter_is_even_and_about_the_middle() -> None:
    assert halton(0) == pytest.approx((0.0, 1.0 / 3.0 - 0.5))
    for period in (1, 4, 16):
        points = np.array([pixel_jitter(i, period) for i in range(period)])
        assert points.mean(axis=0) == pytest.approx((0.0, 0.0), abs=1e-12)
        assert np.abs(points).max() < 0.75
    points = np.array([pixel_jitter(i, 16) for i in range(16)])
    assert np.ptp(points, axis=0) == pytest.approx((0.9, 0.9), abs=0.06)
    assert pixel_jitter(17, 16) == pixel_jitter(1, 16)
