"""Bad numbers in a scene's own data: the rest of the picture does not notice."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.assets.clip import Channel, ClipAsset
from engine.assets.environment_dds import write_environment
from engine.assets.material import MaterialAsset, TextureRef
from engine.assets.mesh import MeshAsset, Submesh
from engine.assets.primitives import card, cube, mesh_from_arrays, uv_sphere
from engine.assets.scene import LightAsset, NodeAsset, SceneAsset
from engine.assets.texture import TextureAsset
from engine.animation.sample import ClipPlayer
from engine.core.errors import InputError
from engine.scene.scene import Scene
from tests.stability.rows import covers
from tests.support.stage import Stage, front_camera, surface

pytestmark = pytest.mark.gl

BAD = {"nan": math.nan, "inf": math.inf, "minus_inf": -math.inf, "huge": 3e38, "minus_huge": -3e38, "denormal": 1e-40}
SIZE = (48, 32)
LEFT, RIGHT = (-0.8, 0.0, 0.0), (0.8, 0.0, 0.0)
CAMERA = front_camera(1.0, 1.5)


def lit(stage: Stage, **more: Any) -> None:
    stage.look(kind="uniform", color=(0.4, 0.5, 0.6), sun_illuminance=2.0, background="color", **more)


def grey() -> MaterialAsset:
    return surface(base_color=(0.6, 0.5, 0.4, 1), metallic=0.2, roughness=0.4)


def good_half(stage: Stage) -> NDArray[np.float32]:
    """The picture's right half, where nothing bad is placed; everything in the whole picture must be sound."""
    picture = stage.hdr(SIZE, CAMERA)
    assert np.isfinite(picture).all()
    assert picture.min() >= 0.0
    assert picture.max() <= 32000.0
    assert (picture[..., 3] <= 1.0).all()
    return picture[:, SIZE[0] // 2 :]


def reference(stage: Stage) -> NDArray[np.float32]:
    """The good half with a sound sphere alone."""
    lit(stage)
    stage.add(uv_sphere(), grey(), RIGHT)
    return good_half(stage)


def strewn(mesh: MeshAsset, stream: str, value: float) -> MeshAsset:
    """The mesh with one bad number in every tenth row of a stream; bounds as they were."""
    data = np.array(mesh.streams[stream], copy=True)
    data[::10, 0] = value
    return replace(mesh, streams={**mesh.streams, stream: data})


@covers("format.one-bad-pixel")
@pytest.mark.parametrize("value", BAD)
@pytest.mark.parametrize("stream", ["position", "uv0"])
def test_bad_vertices_stay_in_their_triangles(stage: Stage, stream: str, value: str) -> None:
    expected = reference(stage)
    lit(stage)
    stage.add(uv_sphere(), grey(), RIGHT)
    bad = strewn(uv_sphere(0.4), stream, BAD[value])
    if stream == "position" and abs(BAD[value]) > 1.0:
        # a corner far away draws across the screen, as it should; the right half is kept free by clipping it behind
        bad.streams["position"][::10, 2] = -abs(BAD[value])  # type: ignore[index]  # an array of float32
    stage.add(bad, grey(), LEFT)
    got = good_half(stage)
    if stream == "uv0" or math.isnan(BAD[value]):
        assert (got == expected).all()


@covers("pose.no-tangents")
def test_zero_and_degenerate_vectors(stage: Stage) -> None:
    """Normals and tangents of length 0, triangles without area: finite, and the sphere beside them as ever."""
    expected = reference(stage)
    lit(stage)
    stage.add(uv_sphere(), grey(), RIGHT)
    mesh = uv_sphere(0.4)
    mesh.streams["normal"][::3] = 0  # type: ignore[index]  # an int16 array
    mesh.streams["tangent"][::2] = 0  # type: ignore[index]  # likewise
    stage.add(mesh, normal_mapped(stage, 0.5), LEFT)
    sliver = mesh_from_arrays(
        "sliver", [(-1, 0, 0), (-0.5, 0, 0), (-0.75, 0, 0), (-0.5, 0, 0)], [(0, 0, 1)] * 4, [(0, 0, 0, 0)] * 4,
        [(0, 0)] * 4, [0, 1, 2, 1, 1, 3, 0, 0, 0],
    )  # fmt: skip
    stage.add(sliver, grey(), (0.0, 0.4, 0.0))
    assert (good_half(stage) == expected).all()


def normal_mapped(stage: Stage, scale: float) -> MaterialAsset:
    """A material with a normal map slot (flat) switched on."""
    return MaterialAsset("mapped", textures={"normal_map": TextureRef("")}, params={"normal_scale": scale})


@covers("format.one-bad-pixel")
@pytest.mark.parametrize("slot", ["base_color_map", "metal_rough_map", "normal_map", "occlusion_map", "emissive_map"])
@pytest.mark.parametrize("value", BAD)
@pytest.mark.parametrize("queue", ["opaque", "transparent"])
def test_bad_texels_of_a_float_texture(stage: Stage, tmp_path: Path, slot: str, value: str, queue: str) -> None:
    from engine.assets.dds import write_dds

    expected = reference(stage)
    texels = np.full((4, 4, 4), 0.5, np.float32)
    texels[1, 1] = BAD[value]
    texels[2, 3, 3] = BAD[value]
    write_dds(tmp_path / "bad.dds", TextureAsset("rgba32f", 4, 4, [[texels.tobytes()]]))
    lit(stage)
    stage.add(uv_sphere(), grey(), RIGHT)
    textures = {slot: TextureRef("bad.dds", min_filter="nearest", mag_filter="nearest")}
    material = MaterialAsset("bad", queue=queue, textures=textures, params={"emissive": (1.0, 1.0, 1.0)})
    runtime = stage.runtime
    mesh = runtime.residency.add_meshes([card(0.8)])[0]
    added = runtime.residency.add_material(material, tmp_path)
    node = runtime.scene.nodes.add("bad", -1, LEFT)
    runtime.add_instances([(node, mesh, 0, added)])
    assert not runtime.residency.findings.items
    assert (good_half(stage) == expected).all()


@covers("brdf.roughness-of-a-file", "format.one-bad-pixel")
@pytest.mark.parametrize("name", ["base_color", "roughness", "metallic", "emissive_strength", "ior", "alpha_cutoff"])
@pytest.mark.parametrize("value", [math.nan, math.inf, -1e30])
def test_bad_material_values_are_refused_before_they_reach_the_gpu(stage: Stage, name: str, value: float) -> None:
    bad = (value, value, value, 1.0) if name == "base_color" else value
    with pytest.raises(InputError, match=name):
        stage.add(uv_sphere(), surface(**{name: bad}))


@covers("format.one-bad-pixel")
@pytest.mark.parametrize("value", BAD)
@pytest.mark.parametrize("column", ["translation", "rotation", "scale"])
def test_bad_transforms_of_a_file(stage: Stage, column: str, value: str) -> None:
    """From a file or a script: reset or hidden, with a finding where it is no number."""
    number = BAD[value]
    node = NodeAsset("bad")
    old = getattr(node, column)
    setattr(node, column, (number, *old[1:]))
    scene = Scene.from_asset(SceneAsset("scene", nodes=[node, NodeAsset("child", parent=0)]))
    world = scene.nodes.world
    assert not np.isnan(world).any()
    if not math.isfinite(number):
        assert [f.code for f in scene.findings] == ["scene.number"]
        np.testing.assert_array_equal(world[:, :, 3], 0.0)


@covers("format.one-bad-pixel")
@pytest.mark.parametrize("translation", [(3e38, 0.0, 0.0), (1e300, 0.0, 0.0), (0.0, -1e30, 0.0)])
@pytest.mark.parametrize("scale", [1.0, 1e-30, 1e30, 1e200])
def test_absurd_but_finite_transforms_hide_only_themselves(
    stage: Stage, translation: tuple[float, ...], scale: float
) -> None:
    expected = reference(stage)
    lit(stage)
    stage.add(uv_sphere(), grey(), RIGHT)
    stage.add(cube(), grey(), translation, scale)
    if scale < 1e29:  # a body of 1e30 m may well stand before everything
        assert (good_half(stage) == expected).all()
    else:
        good_half(stage)


@covers("light.bad-values")
@pytest.mark.parametrize("kind", ["directional", "point", "spot"])
@pytest.mark.parametrize("field", ["intensity", "range", "color", "outer_angle", "inner_angle"])
@pytest.mark.parametrize("value", [math.nan, -1.0, math.inf, 1e8, 1e38])
def test_bad_light_values(stage: Stage, kind: str, field: str, value: float) -> None:
    lit(stage)
    stage.add(uv_sphere(), grey(), RIGHT)
    light = LightAsset(kind, range=5.0)
    setattr(light, field, (value, 0.5, 0.5) if field == "color" else value)
    stage.lamp(light, (0.0, 0.5, 1.0))
    got = good_half(stage)
    if field == "intensity" and not value > 0.0:
        assert (got == reference(stage)).all()  # no light, no change
    if not math.isfinite(value) or value < 0.0:
        stage_findings = stage.runtime.scene.findings
        assert any(f.code == "light.range-of-value" for f in stage_findings) or field != "intensity"


@covers("light.bad-values")
@pytest.mark.parametrize("inner", [0.0, math.pi / 4, math.pi / 2])
@pytest.mark.parametrize("outer", [0.0, 1e-9, math.pi / 4, math.pi / 2])
@pytest.mark.parametrize("reach", [0.0, 1e-30, 1e-9])
def test_spots_of_any_opening(stage: Stage, inner: float, outer: float, reach: float) -> None:
    stage.add(card(2.0), surface(base_color=(0.5, 0.5, 0.5, 1), metallic=0.0))
    stage.lamp(LightAsset("spot", inner_angle=inner, outer_angle=outer, range=reach), (0.0, 0.0, 1.0))
    picture = stage.hdr((17, 17), front_camera())
    assert np.isfinite(picture).all()
    if reach > 0.0:
        assert (picture[..., :3] == 0.0).all()
    elif outer > 0.1:
        assert picture[8, 8, 0] > 0.0


@covers("format.one-bad-pixel")
@pytest.mark.parametrize("value", BAD)
def test_bad_texels_of_an_environment(stage: Stage, tmp_path: Path, value: str) -> None:
    """One bad texel in the mirror level of a baked cube: the picture stays finite, diffuse surfaces do not notice."""
    size, mips = 8, 4
    pictures = []
    for number in (0.25, BAD[value]):
        levels = []
        for face in range(6):
            chain = [np.full((size >> m, size >> m, 4), 0.25, np.float32) for m in range(mips)]
            if face == 4:
                chain[0][4, 4] = number
            levels.append([level.tobytes() for level in chain])
        file = tmp_path / f"{value}-{len(pictures)}.env.dds"
        sh = np.zeros((9, 3), np.float32)
        sh[0] = 0.25 / 0.28209479
        write_environment(file, TextureAsset("rgba32f", size, size, levels, cube=True), sh)
        stage.look(kind="image", path=str(file), sun_illuminance=0.0, background="environment", background_blur=0.0)
        stage.runtime.renderer.environments.baker = lambda _, file=file: file
        stage.add(uv_sphere(), surface(metallic=1.0, roughness=0.0), LEFT)
        stage.add(card(0.8), surface(base_color=(0.5, 0.5, 0.5, 1), metallic=0.0, specular=0.0), RIGHT)
        picture = stage.hdr(SIZE, CAMERA)
        assert np.isfinite(picture).all()
        assert picture.min() >= 0.0
        assert picture.max() <= 32000.0
        pictures.append(picture)
    clean, bad = pictures
    assert (clean[8:24, 30:42] == bad[8:24, 30:42]).all()  # inside the card


@covers("format.one-bad-pixel")
@pytest.mark.parametrize("change", ["intensity", "color", "background_color", "sun_illuminance", "rotation"])
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 3e38, 1e300])
def test_bad_surroundings_set_by_a_script(stage: Stage, change: str, value: float) -> None:
    """Files are checked on reading; what a script or the editor sets comes through as it is."""
    lit(stage)
    stage.add(uv_sphere(), grey(), RIGHT)
    environment = stage.runtime.scene.environment
    old = getattr(environment, change)
    setattr(environment, change, (value, 0.5, 0.5) if isinstance(old, tuple) else value)
    good_half(stage)
    assert stage.ldr(SIZE, CAMERA).shape == (SIZE[1], SIZE[0], 4)


@covers("format.one-bad-pixel")
@pytest.mark.parametrize("exposure", [math.nan, math.inf, -math.inf, 1e6, -1e6, 100.0])
@pytest.mark.parametrize("tone_map", ["none", "agx", "aces", "neutral"])
def test_any_exposure_gives_a_picture(stage: Stage, exposure: float, tone_map: str) -> None:
    stage.look(kind="uniform", sun_illuminance=0.0, tone_map=tone_map, exposure=exposure)
    stage.add(uv_sphere(), grey(), RIGHT)
    picture = stage.ldr((16, 16), CAMERA)
    if exposure == 100.0:
        assert picture[8, 8, :3].min() > 0  # white, not black: nothing overflowed into not-a-number


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


