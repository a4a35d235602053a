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
from engine.render.settings import DEBUG_VIEWS, ON_BLACK, VIEW_LEGENDS
from tests.support.stage import Stage, front_camera

SIZE = (48, 48)


def test_every_legend_is_of_a_view() -> None:
    assert set(VIEW_LEGENDS) <= set(DEBUG_VIEWS)
    assert set(ON_BLACK) <= set(VIEW_LEGENDS)


@pytest.mark.parametrize("view", ON_BLACK)
def test_what_is_behind_is_black(stage: Stage, surface, view: str) -> None:
    stage.look(kind="uniform", background="environment", sun_illuminance=0.0)
    stage.add(uv_sphere(0.3, 8, 16), surface())
    picture = stage.hdr(SIZE, front_camera(), view=view)[..., :3]
    assert (picture[:4] == 0.0).all()
    assert picture[20:28, 20:28].max() > 0.05


def test_depth_darkens_with_every_doubling(stage: Stage, surface) -> None:
    stage.dark()
    stage.add(card(10.0), surface())
    camera = front_camera()
    distance = float(camera.world_from_camera[2, 3])
    expected = (1.0 + math.log2(camera.znear / distance) / 12.0) ** 2
    assert stage.hdr(SIZE, camera, view="depth")[24, 24, :3] == pytest.approx(expected, rel=2e-3)


def test_overdraw_counts_what_is_shaded(stage: Stage, surface) -> None:
    stage.dark()
    for k in range(3):
        stage.add(card(0.6), surface("transparent", base_color=(1, 0, 0, 0.25)), (0, 0, 0.01 * k))
    picture = stage.hdr(SIZE, front_camera(), view="overdraw")[..., :3]
    assert picture[24, 24] == pytest.approx((0.6, 0.3, 0.15), abs=2e-3)
    assert (picture[2, 2] == 0.0).all()


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


@pytest.mark.parametrize(("size", "brightest"), [(4.0, 2), (0.25, 1), (1.0 / 64.0, 0)])
def test_texel_density_by_colour(stage: Stage, tmp_path: Path, size: float, brightest: int) -> None:
    """A card of 128 texels: 32 a metre are blue, 512 green, 8192 red."""
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
    assert int(np.argmax(color)) == brightest
    assert np.sort(color)[-1] > 3.0 * np.sort(color)[-2]


def test_texel_density_without_a_texture_is_grey(stage: Stage, surface) -> None:
    stage.dark()
    stage.add(card(1.0), surface())
    assert stage.hdr(SIZE, front_camera(0.4), view="texel_density")[24, 24, :3] == pytest.approx(0.08, abs=1e-3)
