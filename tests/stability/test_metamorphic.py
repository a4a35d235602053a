"""Changes of a whole scene that must not change its picture, or change it in a known way."""

from __future__ import annotations

import numpy as np
import pytest

from engine.assets.primitives import card, mesh_from_arrays, uv_sphere
from engine.assets.scene import LightAsset
from engine.gpu.types import Device
from tests.stability.metamorphic import SCENES, Change, differing, picture
from tests.stability.rows import covers
from tests.support.stage import DARK, Stage, front_camera, surface

pytestmark = pytest.mark.gl


@covers("pose.tiny-and-huge")
@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("scale", [1e-4, 1e4])
def test_scaled(stage: Stage, scene: str, scale: float) -> None:
    assert differing(picture(stage, scene), picture(stage, scene, Change(scale=scale))) < 2e-3


@covers("pose.far-from-the-origin")
@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("offset", [(1e6, 0.0, 0.0), (-1e6, 2e6, 1e6)])
def test_moved(stage: Stage, scene: str, offset: tuple[float, float, float]) -> None:
    assert differing(picture(stage, scene), picture(stage, scene, Change(offset=offset))) < 2e-3


@covers("pose.mirrored")
@pytest.mark.parametrize("scene", SCENES)
def test_mirrored(stage: Stage, scene: str) -> None:
    """Left and right exchange, and nothing else: normals, culling, light directions, blending."""
    assert differing(picture(stage, scene)[:, ::-1], picture(stage, scene, Change(mirror=True))) < 5e-3


@covers("size.double-resolution")
@pytest.mark.parametrize("scene", SCENES)
def test_twice_the_resolution(stage: Stage, scene: str) -> None:
    """Averaged in blocks of four: equal but for edges, which a sample more or less moves."""
    once = picture(stage, scene)
    twice = picture(stage, scene, size=(144, 112))
    averaged = twice.reshape(56, 2, 72, 2, 4).mean(axis=(1, 3))
    assert differing(once, averaged, 0.03) < 0.12
    assert np.abs(once.mean(axis=(0, 1)) - averaged.mean(axis=(0, 1))).max() < 0.01


def test_the_comparison_can_fail(stage: Stage) -> None:
    for scene in SCENES:
        assert differing(picture(stage, scene), picture(stage, scene, Change(offset=(0.05, 0.0, 0.0)))) == 0.0
        other = Change(scale=1.02)
        moved = picture(stage, scene)
        SCENES_AT_ANOTHER_SIZE = picture(stage, scene, other)
        assert differing(moved, SCENES_AT_ANOTHER_SIZE) < 2e-3
        assert differing(moved, np.roll(moved, 1, axis=1)) > 0.01


@covers("light.empty-scene")
def test_nothing_is_exactly_the_clear_colour(stage: Stage) -> None:
    stage.look(**{**DARK, "background_color": (0.25, 0.5, 0.75)})
    picture = stage.hdr((7, 5), front_camera())
    assert (picture == np.array([0.25, 0.5, 0.75, 1.0], np.float32)).all()
    frame = stage.runtime.render(stage.view((7, 5), front_camera()))
    assert frame.stats.counters["draws"] == 1  # the tone map
    assert frame.stats.counters["instances"] == 0


@covers("light.empty-scene")
def test_no_light_is_black(stage: Stage) -> None:
    stage.add(uv_sphere(), surface(base_color=(1, 1, 1, 1)))
    assert (stage.hdr((9, 9))[..., :3] == 0.0).all()


@covers("light.empty-scene")
def test_a_mesh_of_nothing_but_degenerate_triangles(stage: Stage) -> None:
    for points in ([(0, 0, 0)] * 3, [(0, 0, 0), (1, 0, 0), (0.5, 0, 0)], [(0, 0, 0), (1e-30, 0, 0), (0, 1e-30, 0)]):
        stage.dark()
        mesh = mesh_from_arrays("thin", points, [(0, 0, 1)] * 3, [(1, 0, 0, 1)] * 3, [(0, 0)] * 3, [0, 1, 2])
        stage.add(mesh, surface(features=("unlit",)))
        picture = stage.hdr((16, 16))
        assert np.isfinite(picture).all()
        assert (picture[..., :3] == 0.0).mean() > 0.8


@covers("light.very-many")
def test_ten_thousand_lights_at_one_point_are_one(stage: Stage) -> None:
    count = 10_000
    pictures = []
    for lights in (1, count):
        stage.dark()
        stage.add(card(4.0), surface(base_color=(0.5, 0.5, 0.5, 1), metallic=0.0, roughness=0.6))
        scene = stage.runtime.scene
        node = scene.nodes.add("lamp", -1, (0.0, 0.0, 1.0))
        for _ in range(lights):
            scene.lights.add(node, LightAsset("point", intensity=2.0 / lights))
        stage.runtime.update()
        pictures.append(stage.hdr((8, 8), front_camera()))
    np.testing.assert_allclose(pictures[0], pictures[1], rtol=4e-3)
    assert pictures[0][..., 0].min() > 0.01


@covers("size.odd")
@pytest.mark.parametrize("samples", [1, 4])
def test_odd_sizes(stage: Stage, samples: int) -> None:
    for size in ((1, 1), (17, 31), (1, 9), (33, 1), (2, 2)):
        for scene in SCENES:
            got = picture(stage, scene, size=size, samples=samples)
            assert got.shape == (size[1], size[0], 4)
            assert np.isfinite(got).all()
            assert got.max() > 0.0


@covers("size.resize")
def test_resizing_any_way(stage: Stage, gl_device: Device) -> None:
    """Random sizes in a row, hdr and display, 1 and 4 samples: always that size, finite, no error of the device (the
    fixture checks), and memory does not grow with the number of sizes seen."""
    rng = np.random.default_rng(7)
    picture(stage, "glass")
    camera = front_camera(0.9)
    seen = []
    for width, height in rng.integers(1, 41, (60, 2)).tolist():
        samples = int(rng.choice([1, 4]))
        image = stage.ldr((width, height), camera, samples=samples)
        assert image.shape == (height, width, 4)
        assert np.isfinite(stage.hdr((width, height), camera, samples=samples)).all()
        seen.append(gl_device.live_objects()["texture"])
    assert max(seen[30:]) <= max(seen[:30]) + 2


@covers("size.many-vertices")
def test_more_vertices_than_sixteen_bits(stage: Stage) -> None:
    """The last vertices of 100,489 are where they should be."""
    side = 317
    u, v = np.meshgrid(np.linspace(0.0, 1.0, side), np.linspace(0.0, 1.0, side))
    position = np.stack([u - 0.5, 0.5 - v, np.zeros_like(u)], -1).reshape(-1, 3)
    row, column = np.meshgrid(np.arange(side - 1), np.arange(side - 1), indexing="ij")
    a = (row * side + column).reshape(-1)
    indices = np.stack([a, a + side, a + side + 1, a, a + side + 1, a + 1], -1)
    count = side * side
    mesh = mesh_from_arrays(
        "grid", position, np.tile([0, 0, 1], (count, 1)), np.tile([1, 0, 0, 1], (count, 1)),
        np.stack([u, v], -1).reshape(-1, 2), indices,
    )  # fmt: skip
    stage.add(mesh, surface(features=("unlit",)))
    assert (stage.hdr((40, 40), front_camera(0.3))[..., 0] == 1.0).all()


@covers("pose.singular-scale")
@pytest.mark.parametrize(
    "scale",
    [(1, 1, 0), (1, 0, 0), (0, 0, 0), (-1, 1, 1), (-1, -1, -1), (1, 1, 1e-4), (1, 0.1, 1), (1e4, 1, 1), (1, 1, 1e-20)],
    ids=str,
)
def test_singular_and_uneven_scales(stage: Stage, scale: tuple[float, float, float]) -> None:
    """Normals by the cofactor matrix: finite and unit (the debug view shows n / 2 + 1/2), culling right."""
    stage.add(uv_sphere(), surface(), scale=scale)
    picture = stage.hdr((48, 48), front_camera(0.6), view="normal")
    assert np.isfinite(picture).all()
    seen = picture[..., :3].max(axis=-1) > 0.0
    if scale[0] != 0 and scale[1] != 0:
        assert seen.sum() > 40
        normal = picture[seen][:, :3] * 2.0 - 1.0
        np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1.0, atol=0.02)
        assert (normal[:, 2] > -0.05).all()  # towards the camera: the outside is seen


@covers("pose.singular-scale")
@pytest.mark.parametrize("scale", [1e-12, 1e-9, 1e-6, 1e6, 1e9, 1e12])
def test_normals_at_any_size(stage: Stage, scale: float) -> None:
    """A model of 1e9 m under a node of 1e-9 is as good as one of 1 m."""
    expected = None
    for size in (1.0, scale):
        stage.dark()
        stage.add(uv_sphere(0.5 / size), surface(), scale=size)
        picture = stage.hdr((48, 48), front_camera(0.6), view="normal")
        expected = picture if expected is None else expected
    assert differing(expected, picture, 5e-3) < 2e-3
