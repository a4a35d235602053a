"""Bad numbers in a scene's own data: the rest of the picture does not notice."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.animation.sample import ClipPlayer
from engine.assets.clip import Channel, ClipAsset
from engine.assets.dds import write_dds
from engine.assets.environment_dds import write_environment
from engine.assets.material import MaterialAsset, TextureRef
from engine.assets.mesh import MeshAsset
from engine.assets.primitives import card, cube, mesh_from_arrays, uv_sphere
from engine.assets.scene import CameraAsset, LightAsset, NodeAsset, SceneAsset
from engine.assets.texture import TextureAsset
from engine.core.errors import InputError
from engine.math import quat
from engine.math.transform import compose
from engine.render.camera import Camera
from engine.render.environments import MAX_BRIGHTNESS, usable
from engine.scene.lights import LIGHT_TYPES
from engine.scene.scene import Scene
from tests.stability.rows import covers
from tests.support.poison import shoot
from tests.support.stage import Stage, front_camera, surface

BAD = {"nan": math.nan, "inf": math.inf, "minus_inf": -math.inf, "huge": 3e38, "minus_huge": -3e38, "denormal": 1e-40}
SIZE = (48, 32)
#: the debug view that shows what a texture slot gives
VIEW_OF = {
    "base_color_map": "base_color", "metal_rough_map": "roughness", "normal_map": "normal",
    "occlusion_map": "occlusion", "emissive_map": "emission",
}  # fmt: skip
LEFT, RIGHT = (-0.8, 0.0, 0.0), (0.8, 0.0, 0.0)
CAMERA = front_camera(1.0, 1.5)


def grey() -> MaterialAsset:
    return surface(base_color=(0.6, 0.5, 0.4, 1), metallic=0.2, roughness=0.4)


def sound_scene(stage: Stage) -> NDArray[np.float32]:
    """Start over with a sphere in the right half; its picture there."""
    stage.look(kind="uniform", color=(0.4, 0.5, 0.6), sun_illuminance=2.0, background="color")
    stage.add(uv_sphere(), grey(), RIGHT)
    return right_half(stage)


def right_half(stage: Stage) -> NDArray[np.float32]:
    """The picture's right half, where nothing bad is placed; everything in the whole picture must be sound."""
    picture = stage.hdr(SIZE, CAMERA)
    sound(picture)
    return picture[:, SIZE[0] // 2 :]


def sound(picture: NDArray[np.float32]) -> None:
    assert np.isfinite(picture).all()
    assert picture.min() >= 0.0
    assert picture.max() <= 32000.0
    assert (picture[..., 3] <= 1.0).all()


def strewn(mesh: MeshAsset, stream: str, value: float) -> MeshAsset:
    """The mesh with one bad number in every tenth row of a stream; bounds as they were."""
    data = np.array(mesh.streams[stream], copy=True)
    data[::10, 0] = value
    return replace(mesh, streams={**mesh.streams, stream: data})


@pytest.mark.gl
@covers("format.one-bad-pixel")
@pytest.mark.parametrize("value", BAD)
def test_bad_vertices_stay_in_their_triangles(stage: Stage, value: str) -> None:
    """Positions that are no numbers take their triangles with them; absurd ones may draw right across the screen."""
    expected = sound_scene(stage)
    stage.add(strewn(uv_sphere(0.4), "uv0", BAD[value]), grey(), LEFT)
    assert (right_half(stage) == expected).all()
    stage.add(strewn(uv_sphere(0.4), "position", BAD[value]), grey(), LEFT)
    if value in ("nan", "denormal"):
        assert (right_half(stage) == expected).all()
    else:
        right_half(stage)


@pytest.mark.gl
@covers("pose.no-tangents")
def test_zero_and_degenerate_vectors(stage: Stage) -> None:
    """Normals and tangents of length 0, triangles without area: finite, and the sphere beside them as ever."""
    expected = sound_scene(stage)
    mesh = uv_sphere(0.4)
    mesh.streams["normal"][::3] = 0  # type: ignore[index]  # an int16 array
    mesh.streams["tangent"][::2] = 0  # type: ignore[index]  # likewise
    stage.add(mesh, MaterialAsset("mapped", textures={"normal_map": TextureRef("")}), LEFT)
    sliver = mesh_from_arrays(
        "sliver", [(-1, 0, 0), (-0.5, 0, 0), (-0.75, 0, 0), (-0.5, 0, 0)], [(0, 0, 1)] * 4, [(0, 0, 0, 0)] * 4,
        [(0, 0)] * 4, [0, 1, 2, 1, 1, 3, 0, 0, 0],
    )  # fmt: skip
    stage.add(sliver, grey(), (0.0, 0.4, 0.0))
    assert (right_half(stage) == expected).all()


@pytest.mark.gl
@covers("format.one-bad-pixel")
@pytest.mark.parametrize("slot", ["base_color_map", "metal_rough_map", "normal_map", "occlusion_map", "emissive_map"])
@pytest.mark.parametrize("queue", ["opaque", "alpha_test", "transparent"])
def test_bad_texels_of_a_float_texture(stage: Stage, tmp_path: Path, slot: str, queue: str) -> None:
    expected = sound_scene(stage)
    texels = np.full((4, 4, 4), 0.5, np.float32)
    for i, value in enumerate(BAD.values()):
        texels[i // 4, i % 4, :3] = value
        texels[2 + i // 4, i % 4, 3] = value
    write_dds(tmp_path / "bad.dds", TextureAsset("rgba32f", 4, 4, [[texels.tobytes()]]))
    textures = {slot: TextureRef("bad.dds", min_filter="nearest", mag_filter="nearest")}
    material = MaterialAsset("bad", queue=queue, textures=textures, params={"emissive": (1.0, 1.0, 1.0)})
    runtime = stage.runtime
    mesh = runtime.residency.add_meshes([card(0.8)])[0]
    added = runtime.residency.add_material(material, tmp_path)
    runtime.add_instances([(runtime.scene.nodes.add("bad", -1, LEFT), mesh, 0, added)])
    assert not runtime.residency.findings.items
    assert (right_half(stage) == expected).all()
    drawn_by = "transparent" if queue == "transparent" else "opaque"
    sound(shoot(runtime, stage.view(SIZE, CAMERA), drawn_by).outputs["hdr"])  # at once, not only at the end
    if queue == "opaque":
        sound(stage.hdr(SIZE, CAMERA, view=VIEW_OF[slot]))


@pytest.mark.gl
@covers("brdf.roughness-of-a-file", "format.one-bad-pixel")
def test_bad_material_values_are_refused_before_they_reach_the_gpu(stage: Stage) -> None:
    names = ("base_color", "roughness", "metallic", "emissive_strength", "ior", "alpha_cutoff")
    for name, value in itertools.product(names, [math.nan, math.inf, -1e30]):
        with pytest.raises(InputError, match=name):
            stage.add(uv_sphere(), surface(**{name: (value, 0.0, 0.0, 1.0) if name == "base_color" else value}))


@covers("format.one-bad-pixel", "pose.bad-quaternion")
@pytest.mark.parametrize("value", BAD)
@pytest.mark.parametrize("column", ["translation", "rotation", "scale"])
def test_bad_transforms_of_a_file(column: str, value: str) -> None:
    """Reset, with a finding, where it is no number; kept where it is just absurd."""
    node = NodeAsset("bad")
    setattr(node, column, (BAD[value], *getattr(node, column)[1:]))
    scene = Scene.from_asset(SceneAsset("scene", nodes=[node, NodeAsset("child", parent=0)]))
    assert not np.isnan(scene.nodes.world).any()
    if not math.isfinite(BAD[value]):
        assert [f.code for f in scene.findings] == ["scene.number"]
        np.testing.assert_array_equal(scene.nodes.world[:, :, 3], 0.0)


@covers("pose.bad-quaternion")
def test_rotations_of_any_length_are_the_same_pose() -> None:
    q = np.array([0.1, -0.5, 0.3, 0.8])
    poses = []
    for size in (1e-30, 1e-10, 1.0, 1e10, 1e30):
        scene = Scene()
        scene.nodes.add("n", -1, (0, 0, 0), q * size)
        scene.update()
        poses.append(scene.nodes.world_matrix(0))
    for pose in poses[1:]:
        np.testing.assert_allclose(pose, poses[0], atol=1e-14)


@pytest.mark.gl
@covers("format.one-bad-pixel")
def test_absurd_but_finite_transforms_hide_only_themselves(stage: Stage) -> None:
    expected = sound_scene(stage)
    node = stage.add(cube(), grey(), LEFT)
    for place, scale in itertools.product(
        [(3e38, 0.0, 0.0), (1e300, 0.0, 0.0), (0.0, -1e30, 0.0)], [1e-300, 1e-30, 1.0, 1e30, 1e200]
    ):
        stage.runtime.scene.nodes.set_trs([node], [place], [(0, 0, 0, 1)], [(scale,) * 3])
        got = right_half(stage)
        assert scale >= 1e29 or (got == expected).all()  # a body of 1e30 m may well stand before everything


@pytest.mark.gl
@covers("light.bad-values")
@pytest.mark.parametrize("kind", LIGHT_TYPES)
def test_bad_light_values(stage: Stage, kind: str) -> None:
    expected = sound_scene(stage)
    lights = stage.runtime.scene.lights
    for field, value in itertools.product(
        ["intensity", "range", "color", "outer_angle", "inner_angle", "width", "height", "temperature"],
        [math.nan, -1.0, math.inf, 1e8, 1e38],
    ):
        row = stage.lamp(LightAsset(kind, range=5.0), (0.0, 0.5, 1.0))
        findings = stage.runtime.scene.findings
        before = len(findings)
        lights.set(row, findings, **{field: (value, value, value) if field == "color" else value})
        got = right_half(stage)
        if field in ("intensity", "color") and not value > 0.0:
            assert (got == expected).all()  # no light, no change
        if not 0.0 <= value < 1e30:
            assert len(findings) > before or field == "color", f"{field} {value} was not reported"
            findings.items.clear()
        lights.remove(row)


@pytest.mark.gl
@covers("light.bad-values")
def test_spots_of_any_opening(stage: Stage) -> None:
    stage.add(card(2.0), surface(base_color=(0.5, 0.5, 0.5, 1), metallic=0.0))
    row = stage.lamp(LightAsset("spot"), (0.0, 0.0, 1.0))
    openings = [0.0, 1e-9, math.pi / 4, math.pi / 2]
    for inner, outer, reach in itertools.product(openings, openings, [0.0, 1e-30, 1e-9]):
        stage.runtime.scene.lights.set(row, inner_angle=inner, outer_angle=outer, range=reach)
        picture = stage.hdr((17, 17), front_camera())
        sound(picture)
        if reach > 0.0:
            assert (picture[..., :3] == 0.0).all()
        elif outer > 0.1:
            assert picture[8, 8, 0] > 0.0


def _moved(**values: Any) -> Camera:
    """The camera with its position, its axes or a value of its lens changed."""
    camera = front_camera()
    if "position" in values:
        camera.world_from_camera[:3, 3] = values.pop("position")
    if "axes" in values:
        camera.world_from_camera[:3, :3] *= values.pop("axes")
    return replace(camera, **values)


@pytest.mark.gl
@covers("pose.bad-camera")
def test_cameras_of_any_kind(stage: Stage) -> None:
    """A picture, or an error that names the camera; never anything else."""
    stage.look(kind="uniform", sun_illuminance=2.0)
    stage.add(uv_sphere(), grey())
    for change in (
        {"position": (math.nan, 0, 0)}, {"position": (math.inf, 0, 0)}, {"axes": 0.0}, {"axes": math.nan},
        {"axes": np.array([1.0, 0.0, 1.0])}, {"znear": 0.0}, {"znear": math.nan}, {"znear": -1.0}, {"yfov": 0.0},
        {"yfov": math.pi}, {"yfov": math.nan}, {"ymag": 1.0, "zfar": math.nan}, {"ymag": 1.0, "znear": math.inf},
    ):  # fmt: skip
        with pytest.raises(InputError, match="impossible camera"):
            stage.hdr((9, 9), _moved(**change))
    for change in (
        {"position": (1e300, 0, 0)}, {"position": (3e38, 1e30, -1e15)}, {"znear": 1e-300}, {"znear": 1e-12},
        {"znear": 1e30}, {"yfov": 1e-9}, {"yfov": 3.14159}, {"ymag": 1e-30}, {"ymag": 1e30}, {"axes": 1e-20},
        {"axes": -1.0}, {"ymag": 1.0, "znear": -1e6},
    ):  # fmt: skip
        sound(stage.hdr((9, 9), _moved(**change)))


@covers("pose.bad-camera", "pose.singular-scale")
@pytest.mark.parametrize(
    "scale", [(0, 0, 0), (0, 1, 1), (1, 0, 1), (1, 1, 0), (-1, 1, 1), (1e-100, 1, 1e100), (1e-4,) * 3], ids=str
)
def test_camera_on_a_node_of_any_scale_is_rigid(scale: tuple[float, float, float]) -> None:
    world = compose((1.0, 2.0, 3.0), quat.from_axis_angle((1, 2, 3), 0.7), scale)
    camera = Camera.from_asset(CameraAsset(znear=0.0, yfov=math.pi), world)
    camera.check(1.5)
    pose = camera.world_from_camera
    np.testing.assert_allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3), atol=1e-9)
    assert np.linalg.det(pose[:3, :3]) > 0.0
    np.testing.assert_array_equal(pose[:3, 3], (1.0, 2.0, 3.0))


@pytest.mark.gl
@covers("format.one-bad-pixel")
def test_bad_texels_of_an_environment(stage: Stage, tmp_path: Path) -> None:
    """One bad texel in the mirror level of a baked cube: the picture stays finite, diffuse surfaces do not notice."""
    size, mips = 8, 4
    sh = np.zeros((9, 3), np.float32)
    sh[0] = 0.25 / 0.28209479
    pictures = []
    for number in (0.25, *BAD.values()):
        levels = []
        for face in range(6):
            chain = [np.full((size >> m, size >> m, 4), 0.25, np.float32) for m in range(mips)]
            if face == 4:
                chain[0][4, 4] = number
            levels.append([level.tobytes() for level in chain])
        file = tmp_path / f"{len(pictures)}.env.dds"
        write_environment(file, TextureAsset("rgba32f", size, size, levels, cube=True), sh)
        stage.look(kind="image", path=str(file), sun_illuminance=0.0, background="environment", background_blur=0.0)
        stage.runtime.renderer.environments.baker = lambda _, file=file: file  # type: ignore[misc]  # bound right here
        stage.add(uv_sphere(), surface(metallic=1.0, roughness=0.0), LEFT)
        stage.add(card(0.8), surface(base_color=(0.5, 0.5, 0.5, 1), metallic=0.0, specular=0.0), RIGHT)
        picture = stage.hdr(SIZE, CAMERA)
        sound(picture)
        pictures.append(picture[12:20, 34:40])  # inside the card
    for other in pictures[1:]:
        assert (other == pictures[0]).all()


@pytest.mark.gl
@covers("format.one-bad-pixel")
def test_bad_surroundings_set_by_a_script(stage: Stage) -> None:
    """Files are checked on reading; what a script, an animation or the editor sets comes through as it is."""
    expected = sound_scene(stage)
    environment = stage.runtime.scene.environment
    names = ("intensity", "color", "background_color", "sun_illuminance", "rotation", "sun_elevation")
    for name, value in itertools.product(names, [math.nan, math.inf, -math.inf, 3e38, 1e300, -1.0]):
        old = getattr(environment, name)
        setattr(environment, name, (value, 0.5, 0.5) if isinstance(old, tuple) else value)
        sound(stage.hdr(SIZE, CAMERA))
        stage.ldr(SIZE, CAMERA)
        setattr(environment, name, old)
    assert (right_half(stage) == expected).all()


@covers("format.one-bad-pixel")
def test_usable_surroundings_are_bounded_and_good_ones_untouched() -> None:
    good = SceneAsset("s").environment
    assert usable(good) is good
    fixed = usable(replace(good, intensity=1e300, color=(-1.0, math.nan, 2.0), rotation=math.inf, sun_azimuth=-9.0))
    assert (fixed.intensity, fixed.color, fixed.rotation, fixed.sun_azimuth) == (
        MAX_BRIGHTNESS, (0.0, 1.0, 2.0), 0.0, -9.0,
    )  # fmt: skip


@pytest.mark.gl
@covers("format.one-bad-pixel")
@pytest.mark.parametrize("tone_map", ["none", "agx", "aces", "neutral"])
def test_any_exposure_gives_a_picture(stage: Stage, tone_map: str) -> None:
    stage.look(kind="uniform", sun_illuminance=0.0, tone_map=tone_map)
    stage.add(uv_sphere(), grey())
    for exposure in (math.nan, math.inf, -math.inf, 1e6, -1e6, 100.0, 60.0, 14.0):
        stage.runtime.scene.look.exposure = exposure
        middle = stage.ldr((16, 16), CAMERA)[8, 8, :3]
        if exposure >= 14.0:
            assert middle.min() > 240, f"{exposure}: {middle} is not white"  # nothing overflowed into not-a-number
        elif exposure < 0.0:
            assert middle.max() < 10


@covers("pose.bad-bone")
def test_one_bad_key_moves_nothing_else() -> None:
    def clip(bad: float | None) -> ClipAsset:
        times = np.linspace(0.0, 1.0, 5, dtype=np.float32)
        channels = []
        for node in range(4):
            values = np.random.default_rng(node).normal(size=(5, 3)).astype(np.float32)
            if bad is not None and node == 2:
                values[3, 1] = bad
            channels.append(Channel(node, "translation", "linear", times, values))
        return ClipAsset("clip", channels)

    good = ClipPlayer(clip(None), range(4)).sample(0.6)[0][2]
    for bad in (math.nan, math.inf, -math.inf):
        player = ClipPlayer(clip(bad), range(4))
        got = player.sample(0.6)[0][2]
        assert np.isfinite(got).all()
        np.testing.assert_array_equal(got[[0, 1, 3]], good[[0, 1, 3]])
        assert [f.code for f in player.findings] == ["clip.finite"]


@covers("pose.odd-clips")
@pytest.mark.parametrize("interpolation", ["step", "linear", "cubic"])
@pytest.mark.parametrize("times", [[], [0.5], [0.5, 0.5], [1.0, 0.0], [0.0, 0.0, 1.0, 1.0], [-2.0, -1.0]])
def test_odd_clips_at_odd_times(interpolation: str, times: list[float]) -> None:
    width = (len(times), 3, 3) if interpolation == "cubic" else (len(times), 3)
    values = np.random.default_rng(1).normal(size=width).astype(np.float32)
    channel = Channel(0, "translation", interpolation, np.array(times, np.float32), values)
    player = ClipPlayer(ClipAsset("odd", [channel]), [0])
    for time, mode in itertools.product([-1e9, -0.0, 0.25, 1e12, math.inf, math.nan], ["loop", "once", "ping-pong"]):
        for _, rows, got in player.sample(time, mode):
            assert rows.tolist() == [0]
            assert np.isfinite(got).all()
            assert (np.abs(got) <= np.abs(values).max() * 3.0 + 1.0).all()
