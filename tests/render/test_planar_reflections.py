"""Flat mirrors: what they show is the mirrored scene, and only who asks for one pays."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.assets.primitives import card, cube, mesh_from_arrays, plane, uv_sphere
from engine.assets.scene import LightAsset
from engine.math import quat
from engine.math.transform import look_at
from engine.render.camera import Camera
from engine.render.planar.camera import mirrored_camera, reflection
from engine.render.planar.parts import flat_parts
from tests.support.stage import Stage, surface

SIZE = (72, 56)
SKY = {"kind": "uniform", "color": (0.5, 0.6, 0.8), "sun_illuminance": 0.0, "background": "environment"}
MIRROR = {"metallic": 1.0, "roughness": 0.0, "base_color": (1.0, 1.0, 1.0, 1.0)}
CAMERA = Camera(look_at((1.4, 1.3, 2.6), (0.0, 0.1, 0.0)), 0.8, znear=0.02)


def floor(stage: Stage, *features: str, size: float = 3.0, **more: Any) -> int:
    return stage.add(plane(size), surface(features=("planar_reflection", *features), **{**MIRROR, **more}))


def bodies(stage: Stage, side: float = 1.0) -> None:
    red = surface(base_color=(0.9, 0.3, 0.2, 1.0), metallic=0.0, roughness=0.7)
    green = surface(base_color=(0.2, 0.8, 0.3, 1.0), metallic=0.0, roughness=0.9)
    stage.add(uv_sphere(0.4), red, (-0.5, 0.45 * side, 0.2), (1.0, side, 1.0))
    turn = quat.from_axis_angle((0.0, 1.0, 0.0), 0.5)
    stage.add(cube(0.6), green, (0.4, 0.5 * side, -0.3), (1.0, side, 1.0), turn)


def shown(stage: Stage) -> int:
    return len(stage.runtime.renderer.rows.mirrors.shown)


# --- what is mirrored ---


def test_flat_parts_of_shapes() -> None:
    (whole,) = flat_parts(plane(2.0), 0)
    assert whole.whole
    assert np.allclose(whole.plane, (0.0, 1.0, 0.0, 0.0))
    assert whole.area == pytest.approx(4.0)
    sides = flat_parts(cube(2.0), 0)
    assert len(sides) == 6
    assert not any(part.whole for part in sides)
    for part in sides:
        assert part.plane[3] == pytest.approx(-1.0), "the outside is the side that is seen"
        assert part.plane[:3] @ part.center == pytest.approx(1.0)
    assert flat_parts(uv_sphere(), 0) == []
    nothing = mesh_from_arrays("nothing", [(0, 0, 0)] * 3, [(0, 1, 0)] * 3, [(1, 0, 0, 1)] * 3, [(0, 0)] * 3, [0, 1, 2])
    assert flat_parts(nothing, 0) == []


def test_the_eye_behind_a_mirror() -> None:
    """What lies in the plane is as far left in its picture as it is right in the other, and as deep; both are right-
    handed."""
    n = np.array([0.2, 0.9, -0.3]) / np.linalg.norm([0.2, 0.9, -0.3])
    mirror = np.append(n, 0.4)
    behind = mirrored_camera(CAMERA, mirror)
    assert np.linalg.det(behind.world_from_camera[:3, :3]) == pytest.approx(1.0)
    points = np.random.default_rng(1).uniform(-1.0, 1.0, (20, 3))
    points -= np.outer(points @ n + 0.4, n)
    points = np.hstack([points, np.ones((20, 1))])
    a, b = (points @ c.clip_from_world(1.5).T for c in (CAMERA, behind))
    assert np.allclose(b, a * (-1.0, 1.0, 1.0, 1.0))
    assert np.allclose(reflection(mirror) @ reflection(mirror), np.eye(4))


@pytest.mark.gl
@pytest.mark.parametrize("shift", [(0.0, 0.0), (0.4, -0.3)])
@pytest.mark.parametrize("ortho", [False, True])
def test_a_mirror_shows_the_mirrored_scene(stage: Stage, ortho: bool, shift: tuple[float, float]) -> None:
    """Under an even sky a scene and its image, drawn twice, look as the scene on a mirror. `shift`: as TAA's frames are
    shifted, by parts of a pixel."""
    camera = replace(CAMERA, ymag=1.2, zfar=20.0) if ortho else CAMERA

    def take(**settings: Any) -> NDArray[np.float32]:
        view = stage.view(SIZE, camera, **settings)
        view.shift = shift
        hdr = stage.runtime.render(view, hdr=True).hdr
        assert hdr is not None
        return np.asarray(hdr.read(), np.float32)[..., :3].copy()

    stage.look(**SKY)
    bodies(stage)
    bodies(stage, -1.0)
    truth = take()
    stage.look(**SKY)
    bodies(stage)
    floor(stage, size=100.0)
    got = take()
    assert shown(stage) == 1
    without = take(planar_mirrors=0)
    off = np.abs(got - truth).max(axis=-1)
    assert np.median(off) < 0.01
    assert (off > 0.02).mean() < 0.01
    assert (np.abs(without - truth).max(axis=-1) > 0.02).mean() > 0.05, "there is an image to see"


@pytest.mark.gl
def test_lamps_and_the_sun_light_what_is_mirrored(stage: Stage) -> None:
    """A card that faces the mirror, and away from the camera, is lit in its image alone."""
    stage.look(kind="none", background="color", background_color=(0.0, 0.0, 0.0), sun_illuminance=0.0)
    floor(stage)
    down = quat.from_axis_angle((1.0, 0.0, 0.0), np.pi / 2)
    stage.add(card(1.0), surface(base_color=(1, 1, 1, 1), metallic=0.0, roughness=1.0), (0.0, 1.0, 0.0), 1.0, down)
    stage.lamp(LightAsset("point", intensity=3.0), (0.0, 0.5, 0.0))
    camera = Camera(look_at((0.0, 1.5, 3.0), (0.0, 0.0, 0.0)), 0.9, znear=0.02)
    image = stage.hdr(SIZE, camera) - stage.hdr(SIZE, camera, planar_mirrors=0)
    assert (image[..., :3].min(axis=-1) > 0.3).sum() > 60


@pytest.mark.gl
def test_a_rough_mirror_blurs_and_a_rougher_one_is_none(stage: Stage) -> None:
    """A ball at some height: its image keeps its light but not its edge; at the limit the bits are those of none."""
    pictures = {}
    for roughness in (0.0, 0.25, 0.5):
        stage.look(kind="none", background="color", background_color=(0.0, 0.0, 0.0), sun_illuminance=0.0)
        floor(stage, size=8.0, roughness=roughness)
        glow = surface(base_color=(0, 0, 0, 1), metallic=0.0, specular=0.0, emissive=(1.0, 1.0, 1.0))
        stage.add(uv_sphere(0.25), glow, (0.0, 1.4, 0.0))
        camera = Camera(look_at((0.0, 0.8, 4.0), (0.0, -0.4, 0.0)), 0.9, znear=0.02)
        pictures[roughness] = stage.hdr(SIZE, camera)[28:, :, 0]
        none = stage.hdr(SIZE, camera, planar_mirrors=0)[28:, :, 0]
    sharp, soft = pictures[0.0], pictures[0.25]
    assert sharp.max() > 0.9 > 0.8 > soft.max() > 0.1
    assert soft.sum() == pytest.approx(sharp.sum(), rel=0.15)
    edge = np.abs(np.diff(sharp, axis=1)).max()
    assert np.abs(np.diff(soft, axis=1)).max() < 0.4 * edge
    assert (pictures[0.5] == none).all()


@pytest.mark.gl
def test_glass_before_a_mirror_is_in_it(stage: Stage) -> None:
    stage.look(**SKY)
    floor(stage)
    bodies(stage)
    before = stage.hdr(SIZE, CAMERA)[..., :3]
    red = surface("transparent", base_color=(1.0, 0.0, 0.0, 0.5), metallic=0.0)
    stage.add(uv_sphere(0.3), red, (0.1, 0.4, 0.9))
    got = stage.hdr(SIZE, CAMERA)[..., :3]
    hidden = stage.hdr(SIZE, CAMERA, planar_mirrors=0)[..., :3]
    changed = (np.abs(got - before) > 0.02).any(axis=-1)
    own = changed & (np.abs(got - hidden) <= 1e-3).all(axis=-1)
    assert changed.sum() > own.sum() + 20, "the ball, and its image"


@pytest.mark.gl
def test_water_that_is_blended_mirrors_too(stage: Stage) -> None:
    """Half of what a solid mirror shows, and half of the even sky behind it."""
    pictures = []
    for queue in ("opaque", "transparent"):
        stage.look(**SKY)
        bodies(stage)
        water = surface(queue, ("planar_reflection",), **{**MIRROR, "base_color": (1.0, 1.0, 1.0, 0.5)})
        stage.add(plane(100.0), water)
        pictures.append(stage.hdr(SIZE, CAMERA)[..., :3])
        assert shown(stage) == 1
    stage.look(**SKY)
    bodies(stage)
    without = stage.hdr(SIZE, CAMERA)[..., :3]
    mirrored = np.abs(pictures[0] - without).max(axis=-1) > 0.05
    assert mirrored.sum() > 100
    np.testing.assert_allclose(pictures[1][mirrored], (pictures[0] / 2 + without / 2)[mirrored], atol=2e-3)


@pytest.mark.gl
def test_a_transmissive_body_before_a_mirror_shows_what_is_behind_it_there(stage: Stage) -> None:
    stage.look(**SKY)
    floor(stage)
    bodies(stage)
    clear = replace(
        surface(base_color=(1.0, 0.2, 0.2, 1.0), metallic=0.0, roughness=0.0, transmission=1.0), effect="layered",
        features=["transmission"],
    )  # fmt: skip
    stage.add(uv_sphere(0.3), clear, (0.1, 0.4, 0.9))
    got = stage.hdr(SIZE, CAMERA)
    assert np.isfinite(got).all()
    assert shown(stage) == 1
    image = got[40:, 20:50, :3]
    assert (image[..., 0] > 1.5 * image[..., 2]).any(), "what passes it is red"


@pytest.mark.gl
def test_waves_turn_what_is_mirrored(stage: Stage, tmp_path: Any) -> None:
    """A normal map that leans to one side moves the image that way; one that leans nowhere leaves it."""
    from engine.assets.dds import write_dds
    from engine.assets.material import TextureRef
    from engine.assets.texture import TextureAsset

    def row_of_light(lean: int) -> float:
        texels = np.full((1, 1, 4), (128 + lean, 128, 255, 255), np.uint8)
        write_dds(tmp_path / f"{lean}.dds", TextureAsset("rgba8", 1, 1, [[texels.tobytes()]]))
        stage.look(kind="none", background="color", background_color=(0.0, 0.0, 0.0), sun_illuminance=0.0)
        water = surface(features=("planar_reflection",), **MIRROR)
        water.textures["normal_map"] = TextureRef(f"{lean}.dds")
        residency = stage.runtime.residency
        mesh, material = residency.add_meshes([plane(8.0)])[0], residency.add_material(water, tmp_path)
        stage.runtime.add_instances([(stage.runtime.scene.nodes.add("water"), mesh, 0, material)])
        glow = surface(base_color=(0, 0, 0, 1), metallic=0.0, specular=0.0, emissive=(1.0, 1.0, 1.0))
        stage.add(uv_sphere(0.4), glow, (0.0, 1.0, 0.0))
        seen = stage.hdr(SIZE, Camera(look_at((0.0, 1.0, 4.0), (0.0, 0.0, 0.0)), 0.9, znear=0.02))[30:, :, 0]
        assert seen.max() > 0.5
        return float((seen.sum(axis=0) * np.arange(SIZE[0])).sum() / seen.sum())

    flat, left, right = (row_of_light(lean) for lean in (0, -6, 6))
    assert flat == pytest.approx((SIZE[0] - 1) / 2, abs=1.0)
    assert left > flat + 1.0
    assert right < flat - 1.0


# --- who pays ---


@pytest.mark.gl
def test_tiles_are_one_mirror_and_the_largest_come_first(stage: Stage) -> None:
    stage.look(**SKY)
    material = surface(features=("planar_reflection",), **MIRROR)
    for k in range(9):
        stage.add(plane(1.0), material, (k % 3 - 1.0, 0.0, k // 3 - 1.0))
    bodies(stage)
    tiles = stage.hdr(SIZE, CAMERA)
    assert shown(stage) == 1
    stage.look(**SKY)
    floor(stage)
    bodies(stage)
    assert np.abs(tiles - stage.hdr(SIZE, CAMERA)).max() < 2e-3
    stage.add(cube(0.6), material, (0.2, 0.3, 0.8))
    for most in (1, 2, 4):
        stage.hdr(SIZE, CAMERA, planar_mirrors=most)
        assert shown(stage) == most
        normals = [mirror.clip_row["plane"][:3] for mirror in stage.runtime.renderer.rows.mirrors.shown]
        assert np.allclose(normals[0], (0.0, 1.0, 0.0)), "the floor is the largest in the picture"


@pytest.mark.gl
def test_nothing_is_drawn_for_what_is_not_seen(stage: Stage) -> None:
    """Behind the camera, turned away, hidden: no draw more than without; and the frame's facts stay."""
    stage.look(**SKY)
    node = floor(stage)
    bodies(stage)
    away = Camera(look_at((0.0, 1.0, 8.0), (0.0, 1.0, 20.0)), 0.8, znear=0.02)
    beneath = Camera(look_at((0.5, -1.0, 2.0), (0.0, 0.0, 0.0)), 0.8, znear=0.02)
    facts = stage.runtime.render(stage.view(SIZE, CAMERA)).facts
    assert shown(stage) == 1
    for camera in (away, beneath):
        frame = stage.runtime.render(stage.view(SIZE, camera))
        assert shown(stage) == 0
        assert frame.facts == facts
    drawn = stage.runtime.render(stage.view(SIZE, CAMERA)).stats.counters["draws"]
    stage.runtime.scene.nodes.set_visible([node], False)
    stage.runtime.update()
    assert stage.runtime.render(stage.view(SIZE, CAMERA)).stats.counters["draws"] < drawn - 1
    assert shown(stage) == 0


@pytest.mark.gl
def test_without_such_a_material_there_is_no_byte_and_no_bit_of_it(stage: Stage) -> None:
    def picture(*features: str, most: int) -> tuple[NDArray[np.float32], int]:
        stage.look(**SKY)
        stage.add(plane(3.0), surface(features=features, **MIRROR))
        bodies(stage)
        hdr = stage.hdr(SIZE, CAMERA, planar_mirrors=most)
        frame = stage.runtime.render(stage.view(SIZE, CAMERA, planar_mirrors=most))
        assert "planar_reflections" in {item.name for item in frame.graph.left_out}
        return hdr, frame.stats.counters["transient_bytes"]

    plain, switched_off = picture(most=2), picture("planar_reflection", most=0)
    assert (plain[0] == switched_off[0]).all()
    assert plain[1] == switched_off[1]


@pytest.mark.gl
@pytest.mark.parametrize("path", ["deferred", "tiled-deferred", "forward-plus"])
def test_paths_are_bit_equal(stage: Stage, path: str) -> None:
    stage.look(**SKY)
    floor(stage, roughness=0.2)
    bodies(stage)
    stage.lamp(LightAsset("point", (1.0, 0.7, 0.4), 2.0, 4.0), (0.2, 1.0, 0.6))
    forward = stage.hdr(SIZE, CAMERA, path="forward")
    assert (stage.hdr(SIZE, CAMERA, path=path) == forward).all()
    assert stage.runtime.renderer.path.path == path
    assert (stage.hdr(SIZE, CAMERA, path=path, planar_mirrors=0) != forward).any()


@pytest.mark.gl
def test_many_lights_by_lists_are_all_lights(stage: Stage, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two mirrors, glass before them, and thirty small lamps: to the bit."""
    stage.look(**SKY)
    floor(stage)
    wall = quat.from_axis_angle((0.0, 1.0, 0.0), np.pi / 4)
    stage.add(card(3.0), surface(features=("planar_reflection",), **MIRROR), (-0.8, 0.6, -0.9), 1.0, wall)
    bodies(stage)
    stage.add(uv_sphere(0.2), surface("transparent", base_color=(0.9, 0.9, 0.2, 0.5), metallic=0.0), (0.1, 0.4, 0.9))
    for x, y, z in np.random.default_rng(3).uniform((-1, 0.1, -1), (1, 1, 1), (30, 3)):
        stage.lamp(LightAsset("point", (float(abs(x)), float(y), float(abs(z))), 0.3, 0.7), (x, y, z))
    by_lists = stage.hdr(SIZE, CAMERA)
    assert shown(stage) == 2
    assert stage.runtime.renderer.rows.mirrors.lists.words > 0
    monkeypatch.setattr("engine.render.planar.choice.LISTS_FROM", 10_000)
    assert (stage.hdr(SIZE, CAMERA) == by_lists).all()


@pytest.mark.gl
@pytest.mark.parametrize(("scale", "offset"), [(1e-4, (0, 0, 0)), (1e4, (0, 0, 0)), (1.0, (1e6, -2e5, 1e6))])
def test_tiny_huge_and_far_away(stage: Stage, scale: float, offset: tuple[float, float, float]) -> None:
    def picture(scale: float, offset: Any) -> NDArray[np.float32]:
        stage.look(**SKY)
        at = np.asarray(offset, np.float64)
        stage.add(plane(3.0), surface(features=("planar_reflection",), **MIRROR), at, scale)
        red = surface(base_color=(0.9, 0.3, 0.2, 1.0), metallic=0.0, roughness=0.7)
        stage.add(uv_sphere(0.4), red, at + np.array((-0.3, 0.45, 0.2)) * scale, scale)
        pose = CAMERA.world_from_camera.copy()
        pose[:3, 3] = pose[:3, 3] * scale + at
        return stage.hdr(SIZE, replace(CAMERA, world_from_camera=pose, znear=CAMERA.znear * scale))

    before, after = picture(1.0, (0.0, 0.0, 0.0)), picture(scale, offset)
    assert (np.abs(before - after).max(axis=-1) > 5e-3).mean() < 2e-3


@pytest.mark.gl
def test_a_smaller_picture_and_one_pixel(stage: Stage) -> None:
    stage.look(**SKY)
    floor(stage)
    bodies(stage)
    whole, half = stage.hdr(SIZE, CAMERA)[..., :3], stage.hdr(SIZE, CAMERA, planar_scale=0.5)[..., :3]
    off = np.abs(whole - half).max(axis=-1)
    assert 0.0 < (off > 0.05).mean() < 0.1, "edges in the mirror alone are coarser"
    several = stage.hdr(SIZE, CAMERA, samples=4)[..., :3]
    assert np.median(np.abs(several - whole)) < 1e-3
    for size in ((1, 1), (17, 31), (1, 40)):
        assert np.isfinite(stage.hdr(size, CAMERA, planar_scale=0.1)).all()


@pytest.mark.gl
def test_what_counts_is_how_large_a_mirror_is_in_the_picture(stage: Stage) -> None:
    """A great ceiling overhead, seen by a sliver, comes after the floor that is looked at; one not seen is none."""
    stage.look(**SKY)
    floor(stage, size=2.0)
    bodies(stage)
    over = quat.from_axis_angle((1.0, 0.0, 0.0), np.pi)
    material = surface(features=("planar_reflection",), **MIRROR)
    ceiling = stage.add(plane(40.0), material, (0.0, 2.0, 0.0), 1.0, over)
    level = Camera(look_at((0.0, 0.7, 2.0), (0.0, 0.4, 0.0)), 0.8, znear=0.02)
    for most in (1, 2):
        stage.hdr(SIZE, level, planar_mirrors=most)
        assert shown(stage) == most
        assert stage.runtime.renderer.rows.mirrors.shown[0].clip_row["plane"][1] == pytest.approx(1.0)
    stage.hdr(SIZE, CAMERA, planar_mirrors=4)
    assert shown(stage) == 1, "from above the ceiling is behind the picture's upper border"
    assert stage.runtime.scene.nodes.alive[ceiling]
