"""Ambient occlusion over frames, and from smaller depths: known answers, no ghosts, nothing where it is off."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from engine.assets.primitives import card, cube
from engine.assets.scene import LightAsset
from engine.render.occlusion import METHODS, occlusion_of, turns_of
from engine.render.passes.ambient_occlusion import levels_of
from engine.render.settings import RenderSettings
from tests.support import poison
from tests.support.stage import front_camera

pytestmark = pytest.mark.gl

FLAT = (math.sin(-math.pi / 4), 0.0, 0.0, math.cos(-math.pi / 4))
SIZE = (64, 48)
CAMERA = front_camera(0.6, SIZE[0] / SIZE[1])
#: few slices, so that each frame is far from the truth
FEW = {
    "ambient_occlusion": "gtao", "ao_radius": 0.5, "ao_thickness": 0.35, "ao_directions": 1, "ao_bent": False,
    "view": "ambient_occlusion",
}  # fmt: skip


def niche(stage, surface) -> int:
    """A wall with a block before it; the block's node."""
    stage.look(kind="uniform", color=(1.0, 1.0, 1.0))
    stage.add(card(6.0), surface(), (0.0, 0.0, -0.3))
    return stage.add(cube(0.4), surface())


def live(stage, *, frames: int = 1, cut: bool = False, size=SIZE, camera=CAMERA, raw: bool = False, **settings):
    """f8[h,w] of the last of some frames in a row; `raw`: before the filter."""
    view = replace(stage.view(size, camera, **{**FEW, "ao_temporal": True, **settings}), seconds=0.02)
    for frame in range(frames):
        shot = poison.shoot(stage.runtime, replace(view, cut=cut and frame == 0), "ambient_occlusion")
    return shot.outputs["ambient_mean" if raw else "ambient_visibility"].astype(np.float64)[..., 0]


def still(stage, **settings):
    return stage.hdr(SIZE, CAMERA, **{**FEW, **settings})[..., 0].astype(np.float64)


def rmse(a, b) -> float:
    return float(np.sqrt(np.mean((a - b) ** 2)))


def test_at_rest_it_converges_to_many_slices(stage, surface) -> None:
    niche(stage, surface)
    best = still(stage, ao_directions=16)
    errors = [rmse(live(stage, frames=n, cut=True, raw=True), best) for n in (1, 4, 16)]
    assert errors == sorted(errors, reverse=True)
    assert errors[0] > 0.004, "one slice is far from it before it is filtered"
    assert errors[2] < 0.25 * errors[0]
    assert rmse(live(stage, frames=16, cut=True), best) < 0.001


def test_before_the_filter_it_is_the_mean_of_its_frames(stage, surface) -> None:
    """The textures of five frames, each with other slices: their mean is what is kept."""
    niche(stage, surface)
    drawn = []
    for frame in range(5):
        view = replace(stage.view(SIZE, CAMERA, **FEW, ao_temporal=True), seconds=0.02, cut=frame == 0)
        outputs = poison.shoot(stage.runtime, view, "ambient_occlusion").outputs
        drawn.append(outputs["ambient_visibility_raw"].astype(np.float64)[..., 0])
    assert len({frame.tobytes() for frame in drawn}) == 5
    assert np.abs(outputs["ambient_mean"][..., 0] - np.mean(drawn, axis=0)).max() < 1e-5


def test_sixteen_frames_have_every_place_of_the_pattern() -> None:
    turns = np.array([turns_of(frame) for frame in range(16)])
    own = (5 + 0.5) / 16.0
    assert sorted(np.floor(16.0 * ((own + turns[:, 0]) % 1.0)).astype(int)) == list(range(16))
    assert turns_of(0) == (0.0, 0.0), "the first frame is that of a single picture"


def test_the_first_frame_and_one_after_a_cut_are_a_single_picture(stage, surface) -> None:
    block = niche(stage, surface)
    alone = still(stage)
    assert np.abs(live(stage) - alone).max() < 1e-3
    live(stage, frames=4)
    stage.runtime.scene.nodes.set_translation([block], [(0.15, 0.0, 0.0)])
    assert np.abs(live(stage, cut=True) - still(stage)).max() < 1e-3
    live(stage, frames=2)
    wider = (SIZE[0] + 8, SIZE[1])
    assert np.array_equal(live(stage, size=wider), live(stage, size=wider, cut=True)), "another size is another picture"
    stage.lamp(LightAsset("point", intensity=4.0, range=3.0), (0.8, 1.0, 0.8))
    lit = {"view": "lit", "path": "deferred"}
    live(stage, frames=2, view="lit", path="forward")
    assert np.array_equal(live(stage, **lit), live(stage, cut=True, **lit)), "another path, too"
    assert stage.runtime.renderer.path.path == "deferred"


def test_a_picture_that_depends_on_the_scene_alone_has_none_of_it(stage, surface) -> None:
    niche(stage, surface)
    off = still(stage)
    live(stage, frames=3)
    assert np.array_equal(still(stage, ao_temporal=True), off)
    frame = stage.runtime.renderer.render(stage.runtime.scene, stage.view(SIZE, CAMERA, **FEW, ao_temporal=True))
    assert not frame.facts.motion
    assert "motion" in {item.name for item in frame.graph.left_out}
    wanted = {"ambient_occlusion": "gtao", "ao_temporal": True}
    assert not occlusion_of(RenderSettings(**wanted), lit=True, solid=True).temporal
    assert not occlusion_of(RenderSettings(ambient_occlusion="gtao"), lit=True, solid=True, live=True).temporal


@pytest.mark.parametrize("half", [False, True])
def test_no_ghost_where_a_thing_went_away(stage, surface, half) -> None:
    """The block goes a third of the picture off: the wall there is open two frames later, the whole as near to
    the truth as without a past eight frames later."""
    block = niche(stage, surface)
    live(stage, frames=8, cut=True, ao_half=half)
    stage.runtime.scene.nodes.set_translation([block], [(0.6, 0.0, 0.0)])
    assert live(stage, frames=2, ao_half=half)[:, : SIZE[0] // 2 - 2].min() > 0.97, "nothing hides the wall any more"
    ghost = live(stage, frames=6, ao_half=half)
    alone, best = still(stage, ao_half=half), still(stage, ao_half=half, ao_directions=16)
    assert rmse(ghost, best) < rmse(alone, best)


def test_a_camera_that_moves_keeps_what_it_saw(stage, surface) -> None:
    """Steps of a third of a pixel: before the filter nearer to many slices than each frame by itself."""
    niche(stage, surface)
    pose = CAMERA.world_from_camera
    for i in range(12):
        moved = pose.copy()
        moved[0, 3] += 0.008 * i
        camera = replace(CAMERA, world_from_camera=moved)
        got = live(stage, camera=camera, cut=i == 0, raw=True)
    views = [stage.view(SIZE, camera, **{**FEW, "ao_directions": n}) for n in (1, 16)]
    shots = [poison.shoot(stage.runtime, view, "ambient_occlusion") for view in views]
    alone, best = (shot.outputs["ambient_visibility_raw"].astype(np.float64)[..., 0] for shot in shots)
    assert rmse(got, best) < 0.6 * rmse(alone, best)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 1e38])
def test_a_bad_texel_of_before_is_gone_at_once(stage, surface, value) -> None:
    niche(stage, surface)
    live(stage, frames=2, cut=True)
    view = replace(stage.view(SIZE, CAMERA, **FEW, ao_temporal=True), seconds=0.02)
    poison.shoot(stage.runtime, view, "tone_map", ("ambient_mean", 20, 20, value))
    got = live(stage)
    assert np.isfinite(got).all()
    assert (got.min() >= 0.0) & (got.max() <= 1.0)


@pytest.mark.parametrize("size", [(1, 1), (2, 1), (3, 17)])
def test_small_pictures_over_frames(stage, surface, size) -> None:
    niche(stage, surface)
    assert np.isfinite(live(stage, frames=2, size=size, ao_half=True, ao_mips=True)).all()


def test_bent_normals_are_kept_too_and_all_paths_agree(stage, surface) -> None:
    niche(stage, surface)
    settings = {"ambient_occlusion": "gtao", "ao_radius": 0.5, "ao_temporal": True}
    pictures = []
    for path in ("forward", "deferred", "tiled-deferred", "forward-plus"):
        for frame in range(3):
            view = replace(stage.view(SIZE, CAMERA, path=path, **settings), seconds=0.02, cut=frame == 0)
            last = stage.runtime.render(view, hdr=True)
        assert last.facts.ambient_occlusion.bent
        pictures.append(np.asarray(last.hdr.read()))
    assert all(np.array_equal(picture, pictures[0]) for picture in pictures[1:])


# --- smaller depths ---


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("scale", [1e-4, 1.0, 1e4])
def test_a_plane_hides_nothing_of_itself_in_smaller_depths(stage, surface, method, scale) -> None:
    """Each texel of a smaller depth is taken for the pixel that it comes from: no slope becomes a stair."""
    stage.look(kind="uniform", color=(1.0, 1.0, 1.0))
    stage.add(card(4.0), surface(), rotation=FLAT, scale=scale)
    tilted = replace(CAMERA, world_from_camera=_above(scale), znear=0.01 * scale)
    settings = {"ambient_occlusion": method, "ao_radius": 2.0 * scale, "ao_mips": True, "view": "ambient_occlusion"}
    seen = stage.hdr((96, 96), tilted, **settings)[..., 0]
    assert np.abs(seen[40:-4, 4:-4] - 1.0).max() < 0.02


def _above(scale: float) -> np.ndarray:
    c = math.sqrt(0.5)
    pose = np.eye(4)
    pose[:3, :3] = [[1, 0, 0], [0, c, c], [0, -c, c]]
    pose[:3, 3] = np.array([0.0, 1.0, 1.0]) * scale
    return pose


def test_smaller_depths_are_looked_at_far_off_only_and_say_about_the_same(stage, surface) -> None:
    niche(stage, surface)
    near = {"ao_directions": 4, "ao_radius": 0.12}
    assert np.array_equal(still(stage, ao_mips=True, **near), still(stage, **near)), (
        "within 16 pixels there is no other"
    )
    far = {"ao_directions": 4, "ao_radius": 2.0}
    plain, smaller = still(stage, **far), still(stage, ao_mips=True, **far)
    assert 0.0 < rmse(plain, smaller) < 0.02


def test_smaller_depths_are_made_where_they_are_used(stage, surface) -> None:
    niche(stage, surface)
    counts = []
    for mips in (False, True):
        view = stage.view(SIZE, CAMERA, **FEW, ao_mips=mips)
        frame = stage.runtime.renderer.render(stage.runtime.scene, view)
        counts.append((frame.stats.counters["dispatches"], frame.stats.counters["transient_bytes"]))
    assert counts[1][0] - counts[0][0] == levels_of(*SIZE) == 5
    assert levels_of(1, 600) == 0
    assert levels_of(33, 17) == 4
