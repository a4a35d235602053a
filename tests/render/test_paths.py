"""One picture from all paths: bit by bit, for every knob of culling, at odd sizes, with odd lights, through glass."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.assets.primitives import card, cube, plane, uv_sphere
from engine.assets.scene import LightAsset
from engine.gpu.types import Device
from engine.render import light_lists
from engine.render.camera import Camera
from engine.render.light_groups import group_rows
from engine.render.light_rows import LightBounds
from engine.render.lighting import PATHS, loop_steps
from engine.render.paths.choice import choose
from engine.render.paths.cost import CostModel
from engine.render.settings import RenderSettings
from tests.support.stage import Stage, front_camera, surface

pytestmark = pytest.mark.gl

SIZE = (75, 49)
CAMERA = front_camera(0.9, SIZE[0] / SIZE[1])
OTHERS = PATHS[1:]
KNOBS: tuple[dict[str, str], ...] = (
    {},
    {"light_tile": "8", "light_test": "planes", "light_depth": "range"},
    {"light_tile": "32", "light_test": "cone", "light_depth": "clusters"},
)


def room(stage: Stage, glass: bool = False, metallic: float = 0.3) -> None:
    """Dull, shiny and unlit things under a dim sky, some glass in front."""
    stage.look(
        kind="uniform", color=(0.05, 0.05, 0.06), sun_illuminance=0.5, background="color",
        background_color=(0.1, 0.05, 0.2),
    )  # fmt: skip
    stage.add(plane(4.0), surface(base_color=(0.5, 0.5, 0.5, 1), metallic=0.0, roughness=0.8), (0, -0.5, 0))
    stage.add(uv_sphere(), surface(base_color=(0.9, 0.3, 0.2, 1), metallic=metallic, roughness=0.3), (-0.5, 0, 0))
    stage.add(cube(), surface(base_color=(0.3, 0.6, 0.9, 1), metallic=metallic, roughness=0.5), (0.6, -0.1, 0.1), 0.6)
    stage.add(cube(0.3), surface(features=("unlit",), base_color=(0.2, 0.9, 0.4, 1)), (0.0, 0.5, -0.3))
    for i, color in enumerate([(1, 0, 0, 0.4), (0, 1, 0, 0.6)] if glass else []):
        stage.add(card(0.8), surface("transparent", base_color=color, roughness=0.6), (-0.3 + 0.3 * i, 0.5, 0.2 * i))


def lamps(stage: Stage, count: int, seed: int = 3, **values: Any) -> None:
    rng = np.random.default_rng(seed)
    for i in range(count):
        light = LightAsset(
            "point" if i % 3 else "spot", tuple(rng.uniform(0.2, 1.0, 3)), 0.3,  # type: ignore[arg-type]  # three
            float(rng.uniform(0.3, 1.5)) if i % 7 else 0.0, 0.2, float(rng.uniform(0.3, 1.2)),
        )  # fmt: skip
        for name, value in values.items():
            setattr(light, name, value)
        stage.lamp(light, rng.uniform(-1.2, 1.2, 3), (-0.7, 0.0, 0.0, 0.7))


def many(stage: Stage, positions: NDArray[np.float64], light: LightAsset) -> None:
    scene = stage.runtime.scene
    count = len(positions)
    nodes = scene.nodes.add_many(
        ["lamp"] * count, np.full(count, -1), positions, np.tile([0.0, 0.0, 0.0, 1.0], (count, 1)), np.ones((count, 3))
    )
    scene.lights.add_many(nodes, light)
    stage.runtime.update()


def agree(
    stage: Stage, size: tuple[int, int] = SIZE, camera: Camera = CAMERA, paths: tuple[str, ...] = OTHERS,
    knobs: tuple[dict[str, str], ...] = KNOBS, **settings: Any,
) -> NDArray[np.float32]:  # fmt: skip
    """Assert that every path makes the picture of `forward`, which is returned, bit by bit."""
    truth = stage.hdr(size, camera, path="forward", **settings).copy()
    for path in paths:
        for choice in knobs if path != "deferred" else knobs[:1]:
            picture = stage.hdr(size, camera, path=path, **{**settings, **choice})
            apart = (picture.view(np.uint32) != truth.view(np.uint32)).any(axis=-1)
            assert not apart.any(), f"{path} {choice}: {apart.sum()} pixels, first {np.argwhere(apart)[0].tolist()}"
    return truth


@pytest.mark.parametrize("metallic", [0.0, 0.3], ids=["dielectric", "metal"])
def test_paths_agree(stage: Stage, metallic: float) -> None:
    room(stage, glass=True, metallic=metallic)
    dark = stage.hdr(SIZE, CAMERA).copy()
    lamps(stage, 40)
    lit = agree(stage)
    assert (lit[..., :3] - dark[..., :3]).mean() > 0.02  # the lamps do show
    assert stage.runtime.renderer.graph.passes


@pytest.mark.parametrize("size", [(1, 1), (17, 33), (16, 16), (64, 2)], ids=str)
def test_odd_sizes(stage: Stage, size: tuple[int, int]) -> None:
    room(stage)
    lamps(stage, 20)
    agree(stage, size, knobs=KNOBS[:2])


@pytest.mark.parametrize("samples", [2, 8])
def test_forward_plus_with_many_samples(stage: Stage, samples: int) -> None:
    room(stage, glass=True)
    lamps(stage, 30)
    agree(stage, paths=("forward-plus",), samples=samples)


def test_one_light(stage: Stage) -> None:
    room(stage, glass=True)
    lamps(stage, 2)
    stage.runtime.scene.lights.remove([1])
    stage.runtime.update()
    agree(stage, knobs=KNOBS[:2])


@pytest.mark.parametrize("reach", [1e-6, 1e6, 1e9, 0.0])
def test_odd_ranges(stage: Stage, reach: float) -> None:
    room(stage)
    lamps(stage, 12, range=reach)
    agree(stage, knobs=KNOBS[:1])


def test_orthographic_view(stage: Stage) -> None:
    room(stage, glass=True)
    lamps(stage, 30)
    camera = Camera(CAMERA.world_from_camera, znear=0.05, zfar=50.0, ymag=0.9)
    agree(stage, camera=camera)


def test_orthographic_view_without_end(stage: Stage) -> None:
    """A far plane at 10^6 m, as a file gives that names none: lamps a few centimetres across light what they do in a
    view that ends behind the scene."""
    room(stage)
    places = np.random.default_rng(5).uniform((-0.8, -0.5, -0.8), (0.8, -0.45, 0.8), (60, 3))
    many(stage, places, LightAsset("point", intensity=0.02, range=0.1))
    pose = CAMERA.world_from_camera
    endless = agree(stage, camera=Camera(pose, znear=0.05, zfar=1e6, ymag=0.9))
    near = stage.hdr(SIZE, Camera(pose, znear=0.05, zfar=20.0, ymag=0.9), path="deferred")
    apart = np.abs(endless - near).max(axis=-1)
    assert (apart > 1e-3 * near.max()).mean() < 0.002  # edges of triangles may fall on the other side of a pixel
    assert near.max() > 0.5


def test_far_from_the_origin_of_the_world(stage: Stage) -> None:
    far = np.array([1e6, 0.0, -2e5])
    stage.look(kind="none", sun_illuminance=0.0, background="color")
    stage.add(uv_sphere(), surface(metallic=0.0), far)
    stage.lamp(LightAsset("point", intensity=2.0, range=3.0), np.add(far, (0.5, 1.0, 1.0)))
    camera = front_camera(0.9, SIZE[0] / SIZE[1])
    camera.world_from_camera[:3, 3] += far
    assert agree(stage, camera=camera, knobs=KNOBS[:1]).max() > 0.1


def test_no_local_light_is_one_path(stage: Stage) -> None:
    """Nothing of any path runs, and the frame is the forward one."""
    room(stage)
    truth = stage.hdr(SIZE, CAMERA, path="forward").copy()
    for path in OTHERS:
        frame = stage.runtime.render(stage.view(SIZE, CAMERA, path=path), hdr=True)
        assert frame.facts.lighting.path == "forward"
        assert {p.name for p in frame.graph.passes}.isdisjoint({"light_culling", "depth_prepass", "light_volumes"})
        assert frame.hdr is not None
        assert np.array_equal(frame.hdr.read(), truth)


def test_order_of_lights_changes_no_bit(stage: Stage) -> None:
    pictures = []
    for order in (range(15), reversed(range(15)), np.random.default_rng(1).permutation(15)):
        room(stage)
        made = np.random.default_rng(8).uniform(-1.0, 1.0, (15, 3))
        for i in order:
            stage.lamp(LightAsset("point", (1.0, 0.5 + 0.03 * i, 0.4), 0.1 + 0.01 * i, 2.0), made[i])
        pictures.append(agree(stage, knobs=KNOBS[:1]))
    assert np.array_equal(pictures[0], pictures[1])
    assert np.array_equal(pictures[0], pictures[2])


# --- lists ---


def overflows(stage: Stage, frames: int) -> list[int]:
    """Lists without room, frame by frame; each frame is right."""
    room(stage, glass=True)
    lamps(stage, 40)
    truth = stage.hdr(SIZE, CAMERA, path="forward").copy()
    found = []
    for _ in range(frames):
        frame = stage.runtime.render(stage.view(SIZE, CAMERA, path="forward-plus"), hdr=True)
        assert frame.hdr is not None
        assert np.array_equal(frame.hdr.read(), truth)
        found.append(stage.runtime.renderer.light_lists.read(wait=True).overflow)
        assert frame.stats.counters["light_list_bytes"] > 0
    return found


def test_room_is_made_before_lists_are_written(stage: Stage, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(light_lists, "FIRST_ROOM", 1)
    assert overflows(stage, 2) == [0, 0]


def test_short_of_room_is_right_and_reported(stage: Stage, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where nobody waits for the count, the room is that for next to nothing: all lights are meant, then it grows."""
    monkeypatch.setattr(light_lists, "FIRST_ROOM", 1)
    monkeypatch.setattr(light_lists.LightLists, "unsure", False)
    found = overflows(stage, 6)
    assert found[0] > 0
    assert found[-1] == 0


def test_more_lists_than_memory_is_right_and_reported(stage: Stage, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(light_lists, "FIRST_ROOM", 1)
    monkeypatch.setattr(light_lists, "MOST_BYTES", 256)
    found = overflows(stage, 3)
    assert found[-1] > 0
    assert stage.runtime.renderer.light_lists.capacity == 64


def test_very_many_lights_at_one_point(stage: Stage) -> None:
    """More than a driver's loops have turns; every one of them counts."""
    stage.look(kind="none", sun_illuminance=0.0, background="color")
    stage.add(plane(4.0), surface(metallic=0.0, roughness=1.0), (0, -0.5, 0))
    count = 70_000
    many(stage, np.tile([0.0, 0.1, 0.3], (count, 1)), LightAsset("point", intensity=1.0 / count, range=1.5))
    truth = agree(stage, (12, 8), knobs=KNOBS[:1])
    one = Stage(stage.device, kind="none", sun_illuminance=0.0, background="color")
    one.add(plane(4.0), surface(metallic=0.0, roughness=1.0), (0, -0.5, 0))
    one.lamp(LightAsset("point", intensity=1.0, range=1.5), (0.0, 0.1, 0.3))
    np.testing.assert_allclose(truth, one.hdr((12, 8), CAMERA), rtol=5e-3, atol=1e-4)
    one.close()


def test_lights_behind_the_camera_cost_no_list(stage: Stage) -> None:
    room(stage)
    places = np.add(np.random.default_rng(2).uniform(-1, 1, (100_000, 3)), (0, 0, 40))
    many(stage, places, LightAsset("point", range=2.0))
    dark = stage.hdr(SIZE, CAMERA, path="forward-plus").copy()
    agree(stage, (12, 8), knobs=KNOBS[:1])
    for path in OTHERS:
        assert np.array_equal(stage.hdr(SIZE, CAMERA, path=path), dark), path
    stage.hdr(SIZE, CAMERA, path="forward-plus")
    assert stage.runtime.renderer.light_lists.read(wait=True).tested == 0


def kept(stage: Stage, size: tuple[int, int] = (64, 64), **settings: Any) -> int:
    stage.hdr(size, front_camera(0.9), path="forward-plus", **settings)
    return stage.runtime.renderer.light_lists.read(wait=True).kept


def test_groups_of_lights_hold_what_is_in_them() -> None:
    """The box of each 32 lights, against the lights themselves; one without end makes it endless."""
    rng = np.random.default_rng(4)
    center, radius = rng.uniform(-50, 50, (70, 3)).astype(np.float32), rng.uniform(0, 3, 70).astype(np.float32)
    radius[66] = np.inf
    bounds = LightBounds(center, radius, np.zeros((70, 3), np.float32), np.full(70, -1.0, np.float32))
    rows = group_rows(bounds)
    assert rows.shape == (3, 2, 4)
    for group in range(2):
        part = slice(32 * group, 32 * group + 32)
        low, high = (center[part] - radius[part, None]).min(axis=0), (center[part] + radius[part, None]).max(axis=0)
        assert (rows[group, 0, :3] <= low).all()
        assert (rows[group, 1, :3] >= high).all()
        assert (rows[group, 1, :3] - high).max() < 1e-2
    assert rows[2, 0, :3].max() < -1e29
    assert np.isfinite(rows).all()
    assert group_rows(LightBounds(center[:0], radius[:0], center[:0], radius[:0])).shape == (0, 2, 4)


def test_sky_does_not_widen_a_tile(stage: Stage) -> None:
    """A post before the sky: lights far behind it reach nothing, and no tile keeps them."""
    stage.look(kind="none", sun_illuminance=0.0, background="color")
    stage.add(cube(), surface(), scale=(0.05, 2.0, 0.05))
    places = np.random.default_rng(2).uniform((-3, -3, -8), (3, 3, -8), (50, 3))
    many(stage, places, LightAsset("point", range=2.0))
    assert kept(stage) == 0
    stage.lamp(LightAsset("point", range=0.5), (0.0, 0.0, 0.2))
    assert kept(stage) > 0


def test_spots_are_culled_as_cones(stage: Stage) -> None:
    stage.look(kind="none", sun_illuminance=0.0, background="color")
    stage.add(plane(4.0), surface(), (0, -0.5, 0))
    lamp = LightAsset("spot", range=3.0, outer_angle=0.15, inner_angle=0.1)
    row = stage.lamp(lamp, (0.0, 0.3, 0.0), (-0.7071, 0.0, 0.0, 0.7071))
    as_spot = kept(stage, light_tile="8")
    stage.runtime.scene.lights.set(row, type="point")
    stage.runtime.update()
    assert 0 < as_spot < 0.5 * kept(stage, light_tile="8")


def test_tests_and_depths_keep_less_and_less(stage: Stage) -> None:
    """Each refinement keeps no more than the coarser one, and all keep what is needed."""
    room(stage)
    lamps(stage, 60, range=0.5)
    planes = kept(stage, light_test="planes", light_depth="range")
    boxes = kept(stage, light_test="aabb", light_depth="range")
    assert boxes < planes
    assert kept(stage, light_test="aabb", light_depth="bins") <= boxes


def test_counts_of_lights(stage: Stage) -> None:
    """Tested, kept, needed: each no more than the one before; G-buffer and lists are accounted for."""
    room(stage)
    lamps(stage, 50, range=0.6)
    for _ in range(2):
        stage.runtime.render(stage.view(SIZE, CAMERA, path="tiled-deferred", light_stats=True))
    counters = stage.runtime.render(stage.view(SIZE, CAMERA, path="tiled-deferred", light_stats=True)).stats.counters
    stats = stage.runtime.renderer.light_lists.read(wait=True)
    assert stats.tested >= stats.kept >= stats.needed > 0
    assert stats.kept < 2.5 * stats.needed
    assert stats.in_pixels >= stats.needed
    assert counters["gbuffer_bytes"] == SIZE[0] * SIZE[1] * 16
    assert counters["light_list_bytes"] > 0


# --- glass ---


@pytest.mark.parametrize("path", PATHS)
def test_glass_is_lit_from_near_to_what_is_behind(stage: Stage, path: str) -> None:
    """A lamp between the eye and the wall that reaches the pane only."""
    stage.look(kind="none", sun_illuminance=0.0, background="color")
    stage.add(card(8.0), surface(metallic=0.0), (0, 0, -6))
    stage.add(card(1.0), surface("transparent", base_color=(1, 1, 1, 0.5), metallic=0.0), (0, 0, 0))
    stage.lamp(LightAsset("point", intensity=1.0, range=1.0), (0.0, 0.0, 0.4))
    picture = stage.hdr((48, 48), front_camera(0.9), path=path)
    assert picture[24, 24, :3].min() > 0.1
    assert picture[2, 2, :3].max() == 0.0  # the wall beside the pane stays dark


@pytest.mark.parametrize("path", PATHS)
def test_glass_against_sorted_layers(stage: Stage, path: str) -> None:
    """Each pane alone over black, then blended by hand from back to front over what is solid."""
    panes = [((1, 0.2, 0.2, 0.4), -0.2), ((0.2, 1, 0.2, 0.6), 0.1), ((0.3, 0.3, 1, 0.3), 0.4)]

    def picture(solid: bool, shown: list[int]) -> NDArray[np.float32]:
        stage.look(kind="none", sun_illuminance=0.0, background="color", background_color=(0.0, 0.0, 0.0))
        if solid:
            stage.add(cube(1.2), surface(metallic=0.0, roughness=0.7), (0, 0, -1.2))
        for i in shown:
            color, z = panes[i]
            stage.add(card(0.9), surface("transparent", base_color=color, metallic=0.0), (0.15 * i, 0.1 * i, z))
        lamps(stage, 10, range=4.0, type="point")
        return stage.hdr((40, 40), front_camera(0.9), path=path).astype(np.float64)

    want = picture(True, [])[..., :3]
    for i in range(3):
        alone = picture(False, [i])[..., :3]
        covered = (alone.sum(axis=-1) > 0.0)[..., None]
        want = np.where(covered, alone + (1.0 - panes[i][0][3]) * want, want)
    got = picture(True, [2, 0, 1])[..., :3]  # in whatever order they were made
    np.testing.assert_allclose(got, want, rtol=4e-3, atol=2e-4)


# --- choice ---


def test_choice_says_why() -> None:
    def of(lights: int = 500, samples: int = 1, **settings: Any) -> Any:
        return choose(
            RenderSettings(samples=samples, **settings), local_lights=lights > 0, lights=lights, pixels=640 * 360,
            samples=samples, model=CostModel(),
        )  # fmt: skip

    assert of(0).path == "forward"
    assert "no local lights" in of(0, path="deferred").reason
    assert of(100_000).path in ("forward-plus", "tiled-deferred")
    assert of(100_000, samples=4).path == "forward-plus"
    assert "4 samples" in of(500, samples=4).reason
    asked = of(samples=4, path="deferred")
    assert (asked.path, asked.samples) == ("forward-plus", 4)
    assert "one sample" in asked.reason
    assert of(path="deferred").path == "deferred"
    assert of(view="normal").path == "forward"
    assert of(view="light_tiles").path == "forward-plus"


def test_loops_stay_within_what_a_software_driver_turns() -> None:
    for lights in (1, 1024, 29_000, 100_000, 300_000):
        steps = loop_steps(lights, software=True)
        assert 2 * lights / steps + lights / 16 < 65_535
        assert loop_steps(lights, software=False) == 1


def test_paths_are_swapped_from_frame_to_frame(gl_device: Device) -> None:
    """Two views of one renderer, each with its path: neither disturbs the other."""
    stage = Stage(gl_device)
    room(stage, glass=True)
    lamps(stage, 9)
    first = {path: stage.hdr(SIZE, CAMERA, path=path).copy() for path in PATHS}
    for path in PATHS:
        assert np.array_equal(stage.hdr(SIZE, CAMERA, path=path), first[path])
    stage.close()


def test_null_device_runs_every_path(null_stage: Stage, surface: Callable[..., Any]) -> None:
    null_stage.add(uv_sphere(), surface())
    lamps(null_stage, 4)
    calls = {}
    for path in PATHS:
        null_stage.runtime.render(null_stage.view(SIZE, CAMERA, path=path))
        frame = null_stage.runtime.render(null_stage.view(SIZE, CAMERA, path=path))
        calls[path] = frame.stats.counters["api_calls"]
    assert max(calls.values()) < 130, calls


# --- cut-outs ---


def test_cut_outs_with_alpha_to_coverage(stage: Stage) -> None:
    """Vertex alpha falls across a card: its cut edge has shades between, in the middle where the cutoff is, and the
    pre-pass cuts the same samples."""
    mesh = card(1.6)
    x = mesh.streams["position"][:, 0]
    across = (x - x.min()) / np.ptp(x)
    colors = np.full((mesh.vertex_count, 4), 65535, np.uint16)
    colors[:, 3] = np.round(across * 65535)
    leaf = replace(mesh, streams={**mesh.streams, "color": colors})

    def picture(path: str, **settings: Any) -> NDArray[np.float32]:
        stage.look(kind="none", sun_illuminance=0.0, background="color", background_color=(0.0, 0.0, 0.0))
        stage.add(leaf, surface("alpha_test", metallic=0.0, base_color=(1, 1, 1, 1)), rotation=(0, 0, 0.1, 0.995))
        stage.lamp(LightAsset("point", intensity=2.0), (0.0, 0.0, 2.0))
        return stage.hdr((64, 64), front_camera(0.9), path=path, samples=4, **settings)[..., 1].copy()

    smooth, hard = picture("forward"), picture("forward", alpha_to_coverage=False)
    assert np.array_equal(picture("forward-plus"), smooth)
    assert np.array_equal(picture("forward-plus", alpha_to_coverage=False), hard)
    inner = slice(16, 48)  # away from the card's own edges, where triangles end
    steps_smooth = np.unique(np.round(smooth[inner, 28:36] / smooth[inner].max(), 2))
    steps_hard = np.unique(np.round(hard[inner, 28:36] / hard[inner].max(), 2))
    assert len(steps_smooth) > len(steps_hard)
    assert abs(smooth[inner].sum() / hard[inner].sum() - 1.0) < 0.02  # the edge stays where it was


def test_three_pass_form_is_near(stage: Stage) -> None:
    """Dull dielectrics under white light: gathering light apart from surfaces loses little; shiny metal loses more."""

    def errors(**values: Any) -> float:
        stage.look(kind="none", sun_illuminance=0.0, background="color", background_color=(0.0, 0.0, 0.0))
        stage.add(uv_sphere(), surface(**values))
        lamps(stage, 6, type="point", color=(1.0, 1.0, 1.0), range=4.0, intensity=0.5)
        exact = stage.hdr((48, 48), front_camera(0.6), path="deferred").astype(np.float64)
        near = stage.hdr((48, 48), front_camera(0.6), path="deferred", light_form="three-pass").astype(np.float64)
        assert near[24, 24, :3].min() > 0.0
        return float(np.abs(near - exact).mean() / exact[..., :3].mean())

    dull = errors(base_color=(0.5, 0.4, 0.3, 1.0), metallic=0.0, roughness=1.0)
    assert dull < 0.06
    assert errors(base_color=(0.9, 0.6, 0.2, 1.0), metallic=0.5, roughness=0.3) < 0.5
