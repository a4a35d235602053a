"""Pictures of the sun's shadows whose right answer is known."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from engine.animation.reach import joint_reach
from engine.assets.dds import write_dds
from engine.assets.material import MaterialAsset, TextureRef
from engine.assets.mesh import Skeleton
from engine.assets.primitives import card, cube, plane, uv_sphere
from engine.assets.scene import LightAsset
from engine.assets.texture import TextureAsset
from engine.math import quat
from engine.math.transform import look_at
from engine.render.camera import Camera
from engine.render.shadows.quality import FILTERS
from engine.render.shadows.sun import SunShadows

pytestmark = pytest.mark.gl

#: the sun of the geometry tests stands 45 degrees high in -X: shadows fall to +X, as long as what casts is high
SUN = {"sun_azimuth": -math.pi / 2, "sun_elevation": math.pi / 4}
SIZE = (200, 200)


def sunny(stage, **sun: float) -> None:
    stage.look(kind="none", background="color", background_color=(0, 0, 0), **{"sun_illuminance": 2.0, **SUN, **sun})


def grey(surface, *args, **params):
    return surface(*args, **{"base_color": (0.5, 0.5, 0.5, 1), "metallic": 0.0, "specular": 0.0, **params})


def from_above(half: float, center: tuple[float, float, float] = (0.0, 0.0, 0.0), height: float = 50.0) -> Camera:
    """Straight down on the square of that half width; picture right is +X, picture down is +Z."""
    eye = np.add(center, (0.0, height, 0.0))
    return Camera(look_at(eye, center, (0.0, 0.0, -1.0)), znear=height * 0.01, zfar=height * 2, ymag=half)


def ground(half: float, center=(0.0, 0.0, 0.0), size=SIZE) -> tuple[np.ndarray, np.ndarray]:
    """World x and z of the pixels of `from_above`."""
    along = (np.arange(size[0]) + 0.5) / size[0] * 2 - 1
    z, x = np.meshgrid(along * half + center[2], along * half + center[0], indexing="ij")
    return x, z


def brightness(stage, camera, size=SIZE, **settings) -> np.ndarray:
    return stage.hdr(size, camera, **settings)[..., 0]


def cascades(stage):
    return stage.runtime.renderer.rows.shadows.cascades


@pytest.mark.parametrize("filter", FILTERS)
def test_the_edge_of_a_card_falls_where_geometry_says(stage, surface, filter) -> None:
    """A 1 m card 1.5 m above the floor darkens the square around x = 1.5, within 2 texels and a pixel of its edge."""
    sunny(stage)
    stage.add(plane(12.0), grey(surface))
    stage.add(plane(1.0), grey(surface), (0.0, 1.5, 0.0))
    lit = brightness(stage, from_above(3.0), shadows=False)
    dark = brightness(stage, from_above(3.0), shadow_filter=filter, shadow_softness=1.0) < 0.5 * lit
    x, z = ground(3.0)
    inside = 0.5 - np.maximum(np.abs(x - 1.5), np.abs(z))  # how far within the shadow's edge
    wrong = dark != (inside > 0.0)
    assert np.abs(inside[wrong]).max(initial=0.0) < 2.0 * cascades(stage)[0].texel + 6.0 / SIZE[0]
    assert dark.sum() == pytest.approx((SIZE[0] / 6.0) ** 2, rel=0.05)


def test_shadowed_is_dark_and_the_environment_is_not_shadowed(stage, surface) -> None:
    sunny(stage)
    stage.add(plane(12.0), grey(surface))
    stage.add(plane(1.0), grey(surface), (0.0, 1.5, 0.0))
    x, z = ground(3.0)
    core, far = np.maximum(np.abs(x - 1.5), np.abs(z)) < 0.4, x < -0.6
    picture = brightness(stage, from_above(3.0))
    assert (picture[core] == 0.0).all()
    assert picture[far] == pytest.approx(np.full(far.sum(), 0.5 / math.pi * 2.0 * math.sin(math.pi / 4)), rel=2e-3)
    environment = stage.runtime.scene.environment
    environment.kind = "uniform"
    with_sky = brightness(stage, from_above(3.0))
    environment.sun_illuminance = 0.0
    assert with_sky[core] == pytest.approx(brightness(stage, from_above(3.0))[core], rel=1e-3)


@pytest.mark.parametrize(
    ("filter", "theta"),
    [(f, theta) for f in FILTERS[:5] for theta in (0, 1, 10, 30, 45, 60, 75, 80, 85, 88, 89)]
    + [(f, theta) for f in FILTERS[5:] for theta in (0, 30, 75, 89)],
)
def test_a_tilted_plane_does_not_shadow_itself(stage, surface, theta, filter) -> None:
    """Sun overhead, floor tilted by theta about an axis that is not the map's: no pixel loses light."""
    sunny(stage, sun_elevation=math.pi / 2)
    turn = quat.from_axis_angle((math.cos(0.6), 0.0, math.sin(0.6)), math.radians(theta))
    node = stage.add(plane(12.0), grey(surface))
    stage.runtime.scene.nodes.set_rotation([node], [turn])
    stage.runtime.update()
    normal = quat.to_matrix3(np.asarray(turn)) @ (0.0, 1.0, 0.0)
    camera = Camera(look_at(normal * 20, (0, 0, 0), (0.3, 0.1, 0.9)), znear=0.1, zfar=100.0, ymag=3.0)
    options = {"sun_angle": 5.0} if filter == "pcss" else {}
    lit = brightness(stage, camera, (96, 96), shadows=False)
    shadowed = brightness(stage, camera, (96, 96), shadow_filter=filter, **options)
    assert (lit > 0.0).all()
    assert (shadowed == lit).all()


def test_acne_would_be_seen(stage, surface, monkeypatch) -> None:
    """The tilted plane can fail: where the shader is told that texels have no size, nothing is lifted."""
    sunny(stage, sun_elevation=math.pi / 2)
    node = stage.add(plane(8.0), grey(surface))
    stage.runtime.scene.nodes.set_rotation([node], [quat.from_axis_angle((1.0, 0.0, 0.0), math.radians(60.0))])
    stage.runtime.update()
    fill = SunShadows.fill

    def without_texels(self, row, *args, **kwargs) -> None:
        fill(self, row, *args, **kwargs)
        row["shadow_cascades"][::2, 3] = 0.0

    monkeypatch.setattr(SunShadows, "fill", without_texels)
    camera = Camera(look_at((0, 10, 17.3), (0, 0, 0)), znear=0.1, zfar=100.0, ymag=3.0)
    lit = brightness(stage, camera, (96, 96), shadows=False)
    assert (brightness(stage, camera, (96, 96), shadow_filter="pcf") < 0.9 * lit).mean() > 0.1


@pytest.mark.parametrize("filter", ["none", "pcf", "vogel8", "vogel16"])
@pytest.mark.parametrize("elevation", [20.0, 45.0, 70.0])
def test_a_cube_on_the_floor_touches_its_shadow(stage, surface, filter, elevation) -> None:
    """From above, the floor beside the cube's far side is dark at once: the lit gap is under two texels."""
    sunny(stage, sun_elevation=math.radians(elevation))
    stage.add(plane(12.0), grey(surface))
    stage.add(cube(), grey(surface), (0.0, 0.5, 0.0))
    half, center = 0.1, (0.55, 0.0, 0.0)
    camera = from_above(half, center)
    lit = brightness(stage, camera, shadows=False)
    picture = brightness(stage, camera, shadow_filter=filter, shadow_size=256)
    x, _ = ground(half, center)
    floor = x > 0.5 + 1e-3
    gap = (picture > 0.5 * lit) & floor
    width = gap.sum(axis=1) * (2 * half / SIZE[0])
    assert width.max() < 2.0 * cascades(stage)[0].texel
    assert (picture[floor] < 0.5 * lit[floor]).any()


@pytest.mark.parametrize("offset", [(0.0, 0.0, 0.0), (1e6, 0.0, -1e6)])
def test_moving_the_camera_by_less_than_a_texel_moves_no_shadow(stage, surface, offset) -> None:
    """The camera goes by whole pixels of its own, each a part of a texel, across texels, squares' steps and the
    origin's cells: every point of the floor keeps its light."""
    sunny(stage)
    stage.add(plane(40.0), grey(surface), tuple(offset))
    for i in range(5):
        stage.add(cube(0.4), grey(surface), tuple(np.add(offset, (i * 0.9 - 2.0, 0.7, 0.35 * i - 0.7))))
    half, pixels, steps, stride = 2.0, 120, 40, 2
    pixel = 2 * half / pixels
    wide, places, pictures = [], set(), []
    for i in range(steps):
        camera = from_above(half, tuple(np.add(offset, (i * stride * pixel, 0.0, 0.0))), height=10.0)
        camera.znear = 5e-4  # cells of half a metre
        picture = brightness(stage, camera, (pixels, pixels), shadow_filter="pcf", shadow_size=64, shadow_cascades=1)
        wide.append(cascades(stage)[0].half_width)
        places.add((cascades(stage)[0].x, cascades(stage)[0].y))
        pictures.append(picture)
    assert len(set(wide)) == 1
    assert len(places) > 1  # the square did step along
    assert cascades(stage)[0].texel > 3 * pixel
    for i, picture in enumerate(pictures[1:], 1):
        apart = np.abs(picture[:, : pixels - i * stride] - pictures[0][:, i * stride :])
        # the cubes' own outlines may round to another pixel
        assert (apart > 0.02).mean() < 3e-3, f"step {i}"


def test_an_alpha_tested_caster_is_cut_by_its_texture(stage, surface, tmp_path: Path) -> None:
    """The left half of the card's texture is clear: only the right half casts."""
    texels = np.full((4, 4, 4), 255, np.uint8)
    texels[:, :2, 3] = 0
    write_dds(tmp_path / "half.dds", TextureAsset("rgba8-srgb", 4, 4, [[texels.tobytes()]]))
    sunny(stage)
    stage.add(plane(12.0), grey(surface))
    material = MaterialAsset("half", queue="alpha_test", features=["double_sided"], params={"metallic": 0.0})
    material.textures["base_color_map"] = TextureRef("half.dds", min_filter="nearest", mag_filter="nearest")
    mesh = stage.runtime.residency.add_meshes([plane(1.0)])[0]
    node = stage.runtime.scene.nodes.add("leaf", translation=(0.0, 1.5, 0.0))
    stage.runtime.add_instances([(node, mesh, 0, stage.runtime.residency.add_material(material, tmp_path))])
    stage.runtime.update()
    lit = brightness(stage, from_above(3.0), shadows=False)
    dark = brightness(stage, from_above(3.0)) < 0.5 * lit
    x, z = ground(3.0)
    uv_right = np.asarray(plane(1.0).streams["uv0"])[np.argmax(np.asarray(plane(1.0).streams["position"])[:, 0]), 0]
    side = 1.0 if float(uv_right) > 0.5 else -1.0
    shadow = (np.abs(z) < 0.5) & (np.abs(x - 1.5) < 0.5)
    half = shadow & ((x - 1.5) * side > 0.05)
    other = shadow & ((x - 1.5) * side < -0.05)
    assert dark[half].mean() > 0.9
    assert dark[other].mean() < 0.02


def test_a_skinned_caster_casts_where_its_joints_are(stage, surface) -> None:
    sunny(stage)
    stage.add(plane(12.0), grey(surface))
    mesh = cube()
    weights = np.zeros((mesh.vertex_count, 4), "<u2")
    weights[:, 0] = 65535
    mesh.streams |= {"joints": np.zeros((mesh.vertex_count, 4), "<u2"), "weights": weights}
    mesh.skeleton = Skeleton(["a"], np.array([-1], np.int32), np.eye(4, dtype="<f4")[None])
    nodes, skins = stage.runtime.scene.nodes, stage.runtime.scene.skins
    joint = nodes.add("joint", translation=(-1.0, 1.5, 0.5))
    node = stage.add(mesh, grey(surface))
    reach = joint_reach(mesh.streams["position"], mesh.streams["joints"], weights, mesh.skeleton.inverse_bind)
    skins.add(node, [joint], mesh.skeleton.inverse_bind, reach)
    stage.runtime.update()
    skinned = brightness(stage, from_above(3.0))
    nodes.set_translation([joint], [(-1.0, 1.5, -0.5)])
    stage.runtime.update()
    moved = brightness(stage, from_above(3.0))
    sunny(stage)
    stage.add(plane(12.0), grey(surface))
    stage.add(cube(), grey(surface), (-1.0, 1.5, 0.5))
    plain = brightness(stage, from_above(3.0))
    assert (np.abs(skinned - plain) > 1e-2).mean() < 2e-3
    assert (np.abs(moved - plain) > 1e-2).mean() > 0.02


def _group(stage, surface, offset, scale: float, **settings) -> np.ndarray:
    sunny(stage)
    offset = np.array(offset)
    stage.add(plane(8.0), grey(surface), tuple(offset), scale)
    stage.add(cube(), grey(surface), tuple(offset + scale * np.array((0.0, 0.5, 0.0))), scale)
    stage.add(uv_sphere(), grey(surface), tuple(offset + scale * np.array((-0.6, 1.6, 0.4))), scale)
    eye = offset + scale * np.array((2.0, 3.0, 4.0))
    camera = Camera(look_at(eye, offset + scale * np.array((0.4, 0.4, 0.0))), 0.9, znear=0.05 * scale)
    return brightness(stage, camera, (120, 120), shadow_filter="pcf", **settings)


@pytest.mark.parametrize("offset", [(1e6, 0.0, 0.0), (-1e6, 2e6, 1e6)])
def test_shadows_far_from_the_origin(stage, surface, offset) -> None:
    near, far = _group(stage, surface, (0, 0, 0), 1.0), _group(stage, surface, offset, 1.0)
    lit = _group(stage, surface, (0, 0, 0), 1.0, shadows=False)
    assert (np.abs(near - lit) > 0.1).mean() > 0.03
    assert (np.abs(near - far) > 0.02).mean() < 0.01  # the grid of texels lies elsewhere: edges differ within a texel


@pytest.mark.parametrize("scale", [1e-4, 1e4])
def test_shadows_of_a_scaled_scene(stage, surface, scale) -> None:
    one, other = _group(stage, surface, (0, 0, 0), 1.0), _group(stage, surface, (0, 0, 0), scale)
    assert (np.abs(one - other) > 0.02).mean() < 0.01


def test_a_round_body_shadows_itself_only_where_it_hardly_faces_the_sun(stage, surface) -> None:
    sunny(stage)
    stage.add(uv_sphere(), grey(surface))
    camera = from_above(0.6)
    lit, shadowed = brightness(stage, camera, shadows=False), brightness(stage, camera)
    assert (np.abs(shadowed - lit) > 0.1 * lit.max()).mean() < 2e-3
    assert (shadowed <= lit + 1e-6).all()


def test_what_casts_may_be_behind_the_camera_or_very_high(stage, surface) -> None:
    sunny(stage)
    stage.add(plane(12.0), grey(surface))
    stage.add(plane(1.0), grey(surface), (0.0, 1.5, 0.0))
    low = brightness(stage, from_above(1.0, (1.5, 0.0, 0.0), height=0.5))
    assert (low[90:110, 90:110] == 0.0).all()
    sunny(stage)
    stage.add(plane(12.0), grey(surface))
    stage.add(plane(1.0), grey(surface), (1.5 - 2000.0, 2000.0, 0.0))
    high = brightness(stage, from_above(1.0, (1.5, 0.0, 0.0)))
    assert (high[90:110, 90:110] == 0.0).all()


@pytest.mark.parametrize("axis", ["azimuth", "vertical"])
def test_a_vertical_sun_and_one_that_turns(stage, surface, axis) -> None:
    """The shadow of a card goes around with the sun; in the zenith it lies below."""
    for azimuth in (0.0, 1.0, 2.5, 4.0):
        elevation = math.pi / 2 if axis == "vertical" else math.pi / 4
        sunny(stage, sun_azimuth=azimuth, sun_elevation=elevation)
        stage.add(plane(12.0), grey(surface))
        stage.add(plane(1.0), grey(surface), (0.0, 1.5, 0.0))
        toward = -stage.runtime.renderer.rows.shadows.axes[2]
        camera = from_above(3.0)
        lit, picture = brightness(stage, camera, shadows=False), brightness(stage, camera)
        toward = -stage.runtime.renderer.rows.shadows.axes[2]
        middle = toward / -toward[1] * 1.5
        x, z = ground(3.0)
        dark = picture < 0.5 * lit
        if axis == "vertical":
            assert dark.sum() < 40  # hidden from above by the card
        else:
            assert x[dark].mean() == pytest.approx(middle[0], abs=0.03)
            assert z[dark].mean() == pytest.approx(middle[2], abs=0.03)
            assert np.hypot(middle[0], middle[2]) == pytest.approx(1.5, rel=1e-3)


def test_blended_and_unlit_bodies_cast_none_and_blended_ones_are_shadowed(stage, surface) -> None:
    for material in (grey(surface, "transparent", base_color=(1, 1, 1, 0.5)), grey(surface, features=("unlit",))):
        sunny(stage)
        stage.add(plane(12.0), grey(surface))
        stage.add(plane(1.0), material, (0.0, 1.5, 0.0))
        camera = from_above(0.3, (1.5, 0.0, 0.0))
        assert (brightness(stage, camera) == brightness(stage, camera, shadows=False)).all()
    sunny(stage)
    stage.add(plane(1.0), grey(surface), (0.0, 1.5, 0.0))
    stage.add(plane(12.0), grey(surface, "transparent", base_color=(1, 1, 1, 0.5)))
    camera = from_above(0.3, (1.5, 0.0, 0.0))
    assert (brightness(stage, camera, shadows=False) > 0.1).all()
    assert (brightness(stage, camera) == 0.0).all()


def test_of_two_suns_only_the_first_is_shadowed(stage, surface) -> None:
    """The environment's sun comes first, then directional lights in their order."""
    sunny(stage)
    stage.add(plane(12.0), grey(surface))
    stage.add(plane(1.0), grey(surface), (0.0, 1.5, 0.0))
    camera = from_above(3.0)
    x, z = ground(3.0)
    core = np.maximum(np.abs(x - 1.5), np.abs(z)) < 0.4
    node = stage.runtime.scene.nodes.add("second", rotation=quat.from_axis_angle((1, 0, 0), -math.pi / 2))
    stage.runtime.scene.lights.add(node, LightAsset("directional", intensity=math.pi))
    stage.runtime.update()
    picture = brightness(stage, camera)
    assert picture[core] == pytest.approx(np.full(core.sum(), 0.5), rel=2e-3)  # all of the second one
    stage.runtime.scene.environment.sun_illuminance = 0.0
    assert (brightness(stage, camera)[core] > 0.4).all()  # now it is the first, and shines straight down


def test_passes_are_left_out_with_the_reason(stage, surface) -> None:
    def left_out(**settings) -> bool:
        frame = stage.runtime.render(stage.view(camera=from_above(3.0), **settings))
        reasons = {item.name: item.reason for item in frame.graph.left_out}
        assert reasons.get("shadow_cascades", "-")
        return "shadow_cascades" in reasons

    sunny(stage)
    assert left_out()  # nothing at all
    stage.add(plane(2.0), grey(surface, "transparent", base_color=(1, 1, 1, 0.5)))
    assert left_out()  # nothing that casts
    stage.add(cube(), grey(surface))
    assert not left_out()
    assert left_out(shadows=False)
    stage.runtime.scene.environment.sun_illuminance = 0.0
    assert left_out()  # no sun


@pytest.mark.parametrize("filter", [*FILTERS[:5], "poisson24", "vsm", "msm"])
@pytest.mark.parametrize("case", ["shadow", "no sun", "no caster", "off", "looks away"])
def test_pruned_and_forced_pictures_are_bit_equal(stage, surface, case, filter) -> None:
    sunny(stage, sun_illuminance=0.0 if case == "no sun" else 2.0)
    stage.runtime.scene.environment.kind = "uniform"
    blended = case == "no caster"
    for position in ((0.0, 0.0, 0.0), (0.0, 1.5, 0.0)):
        material = grey(surface, "transparent", base_color=(1, 1, 1, 0.5)) if blended else grey(surface)
        stage.add(plane(1.0 if position[1] else 12.0), material, position)
    camera = from_above(3.0)
    if case == "looks away":
        camera = Camera(look_at((0, 9, 0), (0, 20, 0.1)), 0.8)
    options = {"shadow_filter": filter, "shadows": case != "off", "shadow_size": 256}
    assert (stage.hdr(SIZE, camera, **options) == stage.hdr(SIZE, camera, force_all=True, **options)).all()


def test_shadows_end_at_their_distance(stage, surface) -> None:
    sunny(stage)
    stage.add(plane(60.0), grey(surface))
    for z in (0.0, -25.0):
        stage.add(cube(), grey(surface), (0.0, 0.5, z))
    camera = Camera(look_at((2.0, 6.0, 6.0), (1.0, 0.0, -12.0)), 0.9, znear=0.1)
    lit = brightness(stage, camera, shadows=False)
    all_of_it, near = brightness(stage, camera), brightness(stage, camera, shadow_distance=15.0)
    far_rows = slice(0, 100)
    assert (all_of_it < 0.5 * lit)[far_rows].sum() > 3
    assert (near < 0.5 * lit)[far_rows].sum() == 0
    assert (near < 0.5 * lit)[100:].sum() > 50


def test_cascades_meet_without_a_seam(stage, surface) -> None:
    """A plain floor through all cascades and their blends: not a pixel is darker."""
    sunny(stage, sun_elevation=0.5)
    stage.add(plane(200.0), grey(surface))
    camera = Camera(look_at((0.0, 1.6, 90.0), (3.0, 0.0, 0.0)), 0.9, znear=0.05)
    lit = brightness(stage, camera, (160, 90), shadows=False)
    for count in (1, 2, 4, 8):
        assert (brightness(stage, camera, (160, 90), shadow_cascades=count) == lit).all()
    tinted = stage.hdr((160, 90), camera, view="cascades", shadow_cascades=4)[..., :3]
    hues = np.unique(np.round(tinted[lit > 0] / tinted[lit > 0].max(axis=1, keepdims=True), 2), axis=0)
    assert len(hues) > 4  # several cascades, and their blends


def test_pcss_is_softer_the_further_from_what_casts(stage, surface) -> None:
    widths = []
    for height in (0.5, 3.0):
        sunny(stage)
        stage.add(plane(20.0), grey(surface))
        stage.add(plane(2.0), grey(surface), (0.0, height, 0.0))
        camera = from_above(0.6, (height + 1.0, 0.0, 0.0))
        lit = brightness(stage, camera, shadows=False)
        picture = brightness(stage, camera, shadow_filter="pcss", sun_angle=3.0, shadow_size=2048) / lit
        widths.append(float(((picture > 0.05) & (picture < 0.95)).mean() * 1.2))
    expected = [2 * math.tan(math.radians(1.5)) * h * math.sqrt(2) * math.sqrt(2) for h in (0.5, 3.0)]
    assert widths[1] > 2.5 * widths[0]
    assert widths[1] == pytest.approx(expected[1], rel=0.35)


def test_the_card_that_faces_away_casts_too(stage, surface) -> None:
    """A single-sided card blocks light from behind as from the front."""
    for turn in (0.0, math.pi):
        sunny(stage, sun_azimuth=0.0, sun_elevation=0.3)
        stage.add(card(4.0), grey(surface), (0.0, 0.0, -2.0))
        node = stage.add(card(0.5), grey(surface))
        stage.runtime.scene.nodes.set_rotation([node], [quat.from_axis_angle((0, 1, 0), turn)])
        stage.runtime.update()
        camera = Camera(look_at((0, -3, 6), (0, -0.6, -2)), 0.6)
        lit = brightness(stage, camera, shadows=False)
        assert ((brightness(stage, camera) < 0.5 * lit) & (lit > 0)).sum() > 50
