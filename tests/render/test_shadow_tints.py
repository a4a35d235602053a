"""Translucent shadows: what blended surfaces leave of the sun's light, where the right answer is known."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from engine.assets.material import MaterialAsset
from engine.assets.primitives import plane, uv_sphere
from engine.math.transform import look_at
from engine.render.camera import Camera
from engine.render.lighting import PATHS
from engine.render.shadows.quality import FILTERS
from tests.support.stage import surface

pytestmark = pytest.mark.gl

SIZE = (64, 64)
RED, ALPHA = (0.75, 0.25, 0.5), 0.5
#: mix(white, colour, alpha)
LEFT = np.array([0.875, 0.625, 0.75])
ON: dict[str, Any] = {"translucent_shadows": True, "shadow_size": 256, "shadow_cascades": 2, "shadow_filter": "pcf"}
#: nothing on the ground is within a few texels of an edge here: x of the shadow of what is at height 1 over x = -1
SHADOW_AT, LIT_AT = (32, 32), (32, 56)


def from_above(half: float = 2.0) -> Camera:
    return Camera(look_at((0.0, 50.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, -1.0)), znear=0.5, zfar=100.0, ymag=half)


def pane(stage, height: float = 1.0, color=RED, alpha: float = ALPHA, size: float = 1.0, **more: Any) -> None:
    """Its shadow falls a height to +X of it: around the middle of the picture."""
    features = more.pop("features", ("double_sided",))
    material = surface(
        more.pop("queue", "transparent"), features, base_color=(*color, alpha), metallic=0.0, specular=0.0, **more
    )
    stage.add(plane(size), material, (-height, height, 0.0))


def sunny(stage) -> None:
    stage.look(
        kind="none", background="color", background_color=(0, 0, 0), sun_illuminance=2.0,
        sun_azimuth=-math.pi / 2, sun_elevation=math.pi / 4,
    )  # fmt: skip
    stage.add(plane(8.0), surface(base_color=(1.0, 1.0, 1.0, 1.0), metallic=0.0, specular=0.0))


def tint(stage, **settings: Any) -> np.ndarray:
    """Light of the ground in the middle of the shadow over that of the sunny ground, by channel."""
    picture = stage.hdr(SIZE, from_above(), **{**ON, **settings})[..., :3]
    assert picture[LIT_AT].min() > 0.1
    return picture[SHADOW_AT] / picture[LIT_AT]


@pytest.mark.parametrize("filter", FILTERS)
def test_a_pane_leaves_its_colour_as_much_as_its_alpha(stage, filter: str) -> None:
    sunny(stage)
    pane(stage)
    assert tint(stage, shadow_filter=filter) == pytest.approx(LEFT, rel=1e-3)


def test_panes_multiply_in_any_order(stage) -> None:
    other = (0.25, 0.5, 1.0)
    both = LEFT * (0.5 + 0.5 * np.array(other))
    for heights in ((1.0, 1.4), (1.4, 1.0)):
        sunny(stage)
        pane(stage, heights[0])
        pane(stage, heights[1], other, size=1.0)
        assert tint(stage) == pytest.approx(both, rel=2e-3)


def test_behind_a_solid_caster_a_pane_does_nothing_and_before_it_there_is_no_light_to_tint(stage) -> None:
    for height in (0.5, 1.5):
        sunny(stage)
        stage.add(plane(1.0), surface(base_color=(0.5, 0.5, 0.5, 1.0), metallic=0.0), (-1.0, 1.0, 0.0))
        pane(stage, height)
        assert (tint(stage) == 0.0).all()


def test_what_is_nearer_to_the_sun_keeps_its_light_and_so_does_the_pane_itself(stage) -> None:
    """A shelf over the pane, and a pane at the same place without the option: equal to the bit."""
    sunny(stage)
    pane(stage, 0.5)
    stage.add(plane(1.0), surface(base_color=(1.0, 1.0, 1.0, 1.0), metallic=0.0, specular=0.0), (-0.2, 0.7, 1.2))
    with_it, without = (stage.hdr(SIZE, from_above(), **{**ON, "translucent_shadows": on}) for on in (True, False))
    changed = (with_it != without).any(axis=-1)
    x, z = np.meshgrid(*[(np.arange(64) + 0.5) / 16.0 - 2.0] * 2)
    pane_seen, shelf_seen = (
        (np.abs(x + at) < 0.45) & (np.abs(z - to) < 0.45) for at, to in ((0.5, 0.0), (0.2, 1.2))
    )  # fmt: skip
    assert changed.any()
    # what shines through the pane is the ground; only the half of the pane that has it in its own shade may change
    clear = pane_seen & (x < -0.6)
    assert clear.sum() > 50
    assert not changed[clear].any()
    assert shelf_seen.sum() > 100
    assert not changed[shelf_seen].any()


def test_off_or_without_a_blended_caster_every_bit_is_as_before(stage) -> None:
    sunny(stage)
    stage.add(uv_sphere(0.5, 8, 16), surface(base_color=(0.5, 0.5, 0.5, 1.0), metallic=0.0), (0.0, 0.5, 0.0))
    before = stage.hdr(SIZE, from_above(), **{**ON, "translucent_shadows": False})
    assert (stage.hdr(SIZE, from_above(), **ON) == before).all()
    frame = stage.runtime.render(stage.view(SIZE, from_above(), **ON))
    assert "shadow_tints" in {item.name for item in frame.graph.left_out}
    pane(stage, features=("double_sided", "unlit"))  # a picture of light: it tints nothing
    frame = stage.runtime.render(stage.view(SIZE, from_above(), **ON))
    assert "shadow_tints" in {item.name for item in frame.graph.left_out}


def test_all_paths_make_one_picture(stage) -> None:
    from engine.assets.scene import LightAsset

    sunny(stage)
    pane(stage)
    stage.lamp(LightAsset("point", intensity=3.0, range=6.0), (0.5, 1.0, 0.5))
    first, *others = (stage.hdr(SIZE, from_above(), **ON, path=path) for path in PATHS)
    plain = stage.hdr(SIZE, from_above(), **{**ON, "translucent_shadows": False})
    assert (first != plain).any()
    for other in others:
        assert (other == first).all()


def test_transmission_lets_its_share_through_whatever_the_alpha(stage) -> None:
    sunny(stage)
    material = MaterialAsset(
        "glass", effect="layered", features=["transmission"],
        params={"base_color": (*RED, 0.3), "transmission": 0.5, "metallic": 0.0, "roughness": 0.0},
    )  # fmt: skip
    stage.add(plane(1.0), material, (-1.0, 1.0, 0.0))
    assert tint(stage) == pytest.approx(0.5 * np.array(RED), rel=1e-3)


def test_a_closed_body_tints_once_and_with_both_faces_twice(stage) -> None:
    for features, power in (((), 1), (("double_sided",), 2)):
        sunny(stage)
        material = surface("transparent", features, base_color=(*RED, 1.0), metallic=0.0, specular=0.0)
        stage.add(uv_sphere(0.5, 16, 32), material, (-1.0, 1.0, 0.0))
        assert tint(stage) == pytest.approx(np.array(RED) ** power, rel=2e-3)


def test_a_tint_follows_its_material_and_its_node(stage) -> None:
    sunny(stage)
    pane(stage)
    assert tint(stage) == pytest.approx(LEFT, rel=1e-3)
    residency, scene = stage.runtime.residency, stage.runtime.scene
    residency.set_material_param(int(scene.instances.material[1]), "base_color", (*RED, 1.0))
    assert tint(stage) == pytest.approx(np.array(RED), rel=1e-3)
    scene.nodes.set_translation(np.array([1]), np.array([[-1.0, 1.0, 1.5]]))
    stage.runtime.update()
    assert tint(stage) == pytest.approx(np.ones(3), rel=1e-3)


def test_light_between_surfaces_is_tinted_as_well(stage) -> None:
    """The ground is the only thing that reflects light to the ball's lower half."""
    sunny(stage)
    pane(stage, 1.0, (1.0, 0.0, 0.0), 1.0, size=3.0)
    stage.add(uv_sphere(0.4, 16, 32), surface(base_color=(1.0, 1.0, 1.0, 1.0), metallic=0.0), (0.0, 0.5, 0.0))
    camera = Camera(look_at((2.0, 0.3, 0.0), (0.0, 0.3, 0.0)), 0.7)
    bounced = stage.hdr(SIZE, camera, **ON, view="indirect", gi="one", gi_steps=8)[..., :3]
    assert bounced[..., 0].max() > 0.01
    plain = stage.hdr(SIZE, camera, **{**ON, "translucent_shadows": False}, view="indirect", gi="one", gi_steps=8)
    assert bounced[..., 1].sum() < 0.5 * plain[..., 1].sum()


@pytest.mark.parametrize(("scale", "away"), [(1e-4, 0.0), (1e4, 0.0), (1.0, 1e6)], ids=str)
def test_size_and_place_of_the_world_do_not_matter(stage, scale: float, away: float) -> None:
    sunny(stage)
    pane(stage)
    scene, eye = stage.runtime.scene, np.array([away, 50.0 * scale, away])
    scene.nodes.set_translation(
        np.array([0, 1]), np.array([[0.0, 0.0, 0.0], [-1.0, 1.0, 0.0]]) * scale + (away, 0, away)
    )
    scene.nodes.set_scale(np.array([0, 1]), np.full((2, 3), scale))
    stage.runtime.update()
    pose = look_at(eye, eye - (0.0, eye[1], 0.0), (0.0, 0.0, -1.0))
    picture = stage.hdr(SIZE, Camera(pose, znear=0.5 * scale, zfar=100.0 * scale, ymag=2.0 * scale), **ON)[..., :3]
    assert picture[SHADOW_AT] / picture[LIT_AT] == pytest.approx(LEFT, rel=1e-3)
