"""Views of one thing about the surfaces, against values worked out by hand."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from engine.app.framing import frame_bounds
from engine.assets.dds import write_dds
from engine.assets.material import MaterialAsset, TextureRef
from engine.assets.primitives import card, uv_sphere
from engine.assets.scene import LightAsset
from engine.assets.texture import TextureAsset
from engine.math.color import srgb_to_linear
from engine.render.legends import GAP, Legend, depth_range, legend_of
from engine.render.settings import DEBUG_VIEWS, ON_BLACK, VIEW_LEGENDS
from engine.report.legend_picture import draw_legend
from tests.support.shader_probe import ShaderProbe
from tests.support.stage import Stage, front_camera

SIZE = (48, 48)


def test_every_legend_is_of_a_view() -> None:
    assert set(VIEW_LEGENDS) <= set(DEBUG_VIEWS)
    assert set(ON_BLACK) <= set(VIEW_LEGENDS)


@pytest.mark.parametrize("view", ON_BLACK)
def test_what_is_behind_is_black(stage: Stage, surface, view: str) -> None:
    stage.look(kind="uniform", background="environment", sun_illuminance=0.0)
    stage.add(uv_sphere(0.3, 8, 16), surface())
    picture = stage.ldr(SIZE, front_camera(), view=view)[..., :3]
    assert (picture[:4] == 0).all()
    assert picture[20:28, 20:28].max() > 12


def test_depth_is_in_metres_and_its_legend_spans_what_is_seen(stage: Stage, surface) -> None:
    stage.dark()
    stage.add(card(10.0), surface())
    camera = front_camera()
    distance = float(camera.world_from_camera[2, 3])
    picture = stage.hdr(SIZE, camera, view="depth")
    assert picture[..., 0] == pytest.approx(distance, rel=2e-3)
    low, high = depth_range(camera, np.array([[0.0, 0.0, 0.3]]), np.array([0.1]))
    assert low == pytest.approx(distance - 0.4, abs=0.1)
    assert high == pytest.approx(distance - 0.2, abs=0.1)
    assert depth_range(camera, np.zeros((0, 3)), np.zeros(0)) == (1.0, 10.0)


def test_overdraw_counts_what_is_shaded(stage: Stage, surface) -> None:
    stage.dark()
    for k in range(3):
        stage.add(card(0.6), surface("transparent", base_color=(1, 0, 0, 0.25)), (0, 0, 0.01 * k))
    picture = stage.hdr(SIZE, front_camera(), view="overdraw")[..., :3]
    assert (picture[24, 24] == 3.0).all()
    assert (picture[2, 2] == 0.0).all()


@pytest.mark.parametrize("samples", [1, 4])
def test_a_quantity_has_the_colour_of_its_legend(stage: Stage, surface, samples: int) -> None:
    stage.dark()
    for k in range(3):
        stage.add(card(0.6), surface("transparent"), (0, 0, 0.01 * k))
    picture = stage.ldr(SIZE, front_camera(), view="overdraw", samples=samples)
    legend = legend_of("overdraw")
    assert legend is not None
    assert picture[24, 24, :3] == pytest.approx(np.array(legend.color(legend.place(3.0))) * 255.0, abs=1.0)
    assert picture[2, 2, :3].tolist() == [0, 0, 0]


@pytest.mark.parametrize("view", ["depth", "overdraw", "texel_density", "shadow_texels", "light_tiles"])
def test_legends_say_where_values_are(view: str) -> None:
    legend = legend_of(view, (0.24, 31.0))
    assert legend is not None
    ticks = legend.ticks()
    places = [place for place, _ in ticks]
    assert places[0] == 0.0
    assert places[-1] == 1.0
    assert min(np.diff(places)) >= GAP
    assert 4 <= len(ticks) <= 10
    for place, label in ticks:
        value = float(label.rstrip("+").replace(",", ""))
        assert legend.place(value) == pytest.approx(place, abs=1e-9)
        if view != "light_tiles":  # its shader has a mapping of its own
            scale, offset, log = legend.mapping
            along = (math.log2(value) if log else value) * scale + offset
            assert along == pytest.approx(1.0 - place if legend.falling else place, abs=1e-9)
    light = np.array([legend.color(p) for p in np.linspace(0, 1, 65)]) ** 2.2 @ [0.2126, 0.7152, 0.0722]
    assert (np.diff(light) * (-1.0 if legend.falling else 1.0) > 0.0).all(), "lighter all along, whatever eyes see it"


def test_the_shaders_ramp_is_the_legends(gl_device, tmp_path: Path) -> None:
    x = np.linspace(-0.1, 1.1, 49)
    made = ShaderProbe(gl_device, tmp_path)("result = vec4(ramp(x), 1.0);", "lib/ramp.glsl", x=x)[:, :3]
    legend = Legend("", "", 0.0, 1.0)
    truth = srgb_to_linear(np.array([legend.color(min(max(v, 0.0), 1.0)) for v in x]))
    assert made == pytest.approx(truth, abs=2e-6)


def test_a_legend_drawn_into_a_picture() -> None:
    legend = legend_of("overdraw")
    assert legend is not None
    grey = np.full((180, 320, 4), 128, np.uint8)
    ramp = np.array([legend.color(p) for p in np.linspace(0, 1, 64)])
    drawn = draw_legend(grey, legend.heading, legend.ticks(), ramp, legend.note)
    assert (grey == 128).all()
    assert (drawn[:90] == 128).all()
    bar = (np.abs(drawn[..., :3].astype(float) - ramp[-1] * 255.0) < 3.0).all(axis=-1)
    assert bar.sum() > 20, "the ramp's last colour"
    assert (drawn[..., :3] > 220).all(axis=-1).sum() > 60, "text"
    small = grey[:80, :80]
    assert draw_legend(small, "", [], ramp) is small


def test_wireframe_draws_edges_only(stage: Stage, surface) -> None:
    stage.dark()
    stage.add(card(0.8), surface())
    drawn = stage.hdr(SIZE, front_camera(), view="wireframe")[..., 0] > 0.0
    assert 0.02 < drawn.mean() < 0.25
    assert drawn.any(axis=0).sum() > 25, "from the left edge to the right one"
    assert not drawn[28, 36] or not drawn[20, 12], "the triangles are empty"


def test_lighting_shows_any_surface_as_white(stage: Stage, surface) -> None:
    pictures = []
    for view, color in (("lighting", (0.8, 0.1, 0.0, 1)), ("lit", (1, 1, 1, 1))):
        stage.dark()
        metal = 1.0 if view == "lighting" else 0.0
        stage.add(uv_sphere(0.5, 16, 32), surface(base_color=color, metallic=metal, roughness=0.6))
        stage.lamp(LightAsset("point", (1.0, 0.7, 0.4), 4.0), (1, 1, 2))
        pictures.append(stage.hdr(SIZE, front_camera(), view=view))
    # another layout of the G-buffer, so another half float here and there
    assert np.abs(pictures[0] - pictures[1]).max() <= 2.0**-10 * pictures[1].max()
    assert pictures[0].max() > 0.1


def test_uv_checker_begins_white_and_turns_red_and_green(stage: Stage, surface) -> None:
    stage.dark()
    stage.add(card(1.0), surface())
    camera = frame_bounds(np.full(3, -0.5), np.full(3, 0.5), 1.0, azimuth=0.0, elevation=0.0)
    picture = stage.hdr(SIZE, camera, view="uv_checker")[..., :3]
    seen = picture[picture.max(axis=-1) > 0.0]
    assert (seen == 1.0).all(axis=-1).any(), "the cell at the origin"
    inside = np.argwhere(picture.max(axis=-1) > 0.0)
    (top, left), (bottom, right) = inside.min(axis=0), inside.max(axis=0)
    middle_x, middle_y = (left + right) // 2, (top + bottom) // 2
    assert picture[middle_y - 1 : middle_y + 2, right - 3 : right, 0].max() > 0.8, "red grows with u"
    assert picture[bottom - 3 : bottom, middle_x - 1 : middle_x + 2, 1].max() > 0.8, "green grows downwards"


@pytest.mark.parametrize("size", [4.0, 0.25, 1.0 / 64.0])
def test_texel_density(stage: Stage, tmp_path: Path, size: float) -> None:
    """A card of 128 texels."""
    write_dds(tmp_path / "grey.dds", TextureAsset("rgba8-srgb", 128, 128, [[b"\x80" * (128 * 128 * 4)]]))
    stage.dark()
    residency = stage.runtime.residency
    material = residency.add_material(
        MaterialAsset("textured", textures={"base_color_map": TextureRef("grey.dds")}), tmp_path
    )
    mesh = residency.add_meshes([card(size)])[0]
    node = stage.runtime.scene.nodes.add("card")
    stage.runtime.add_instances([(node, mesh, 0, material)])
    stage.runtime.update()
    color = stage.hdr(SIZE, front_camera(0.4 * size), view="texel_density")[24, 24, :3]
    assert color == pytest.approx(128.0 / size, rel=2e-3)


def test_texel_density_without_a_texture_is_grey(stage: Stage, surface) -> None:
    stage.dark()
    stage.add(card(1.0), surface())
    assert (stage.hdr(SIZE, front_camera(0.4), view="texel_density")[24, 24, :3] == 0.0).all()
    r, g, b = stage.ldr(SIZE, front_camera(0.4), view="texel_density")[24, 24, :3].tolist()
    assert r == g == b == 80


def test_shadow_texels_are_those_of_the_map_that_is_read(stage: Stage, surface) -> None:
    """Texels a metre, as the cascade has them; 0 (grey) without a sun."""
    stage.look(kind="none", sun_illuminance=2.0, background="color", background_color=(0, 0, 0))
    stage.add(card(1.0), surface(metallic=0.0))
    seen = stage.hdr(SIZE, front_camera(0.4), view="shadow_texels", shadow_cascades=1, shadow_size=256)
    texel = stage.runtime.renderer.rows.shadows.cascades[0].texel
    assert seen[24, 24, 0] == pytest.approx(1.0 / texel, rel=1e-3)
    assert 0.7 < seen[..., 3].min() < 0.8 < seen[..., 3].max()  # cells
    stage.runtime.scene.environment.sun_illuminance = 0.0
    assert (stage.hdr(SIZE, front_camera(0.4), view="shadow_texels")[24, 24, :3] == 0.0).all()


def test_the_view_of_the_shadow_maps_shows_each_of_them(stage: Stage, surface) -> None:
    """Cascades and the lamps' map side by side; a scene without shadows shows none; other views have no such pass."""
    stage.look(kind="none", sun_illuminance=2.0, background="color", background_color=(0, 0, 0))
    stage.add(card(1.0), surface(metallic=0.0))
    bare = stage.ldr((60, 40), front_camera(0.4), view="shadow_maps", shadow_cascades=1, shadow_size=64)
    stage.lamp(LightAsset("spot", intensity=5.0, casts_shadow=True), (0.0, 0.0, 1.0))
    both = stage.ldr((60, 40), front_camera(0.4), view="shadow_maps", shadow_cascades=1, shadow_size=64)
    light = [(picture[..., :3].min(axis=-1) > 100).mean() for picture in (bare, both)]
    assert min(light) > 0.02
    assert (bare != both).any()
    stage.dark()
    stage.add(card(1.0), surface(metallic=0.0))
    assert len(np.unique(stage.ldr((60, 40), front_camera(0.4), view="shadow_maps")[..., :3])) == 1
