"""Translucent shadows of lamps: what blended surfaces leave of their light, where the right answer is known."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from engine.assets.primitives import plane
from engine.assets.scene import LightAsset
from engine.math import quat
from engine.math.transform import look_at
from engine.render.camera import Camera
from engine.render.lighting import PATHS
from tests.support.stage import surface

pytestmark = pytest.mark.gl

SIZE = (48, 48)
RED, ALPHA = (0.75, 0.25, 0.5), 0.5
#: mix(white, colour, alpha)
LEFT = np.array([0.875, 0.625, 0.75])
ON: dict[str, Any] = {
    "translucent_shadows": True, "local_shadows": "all", "local_shadow_size": 512, "shadow_filter": "pcf",
}  # fmt: skip
#: pixels well inside the pane's shadow, and well beside it
SHADOW_AT, LIT_AT = (24, 24), (24, 44)
DOWN = quat.from_axis_angle((1.0, 0.0, 0.0), -math.pi / 2)
LAMPS = {
    "spot": LightAsset("spot", intensity=30.0, inner_angle=0.8, outer_angle=0.9),
    "point": LightAsset("point", intensity=30.0),
    "ball": LightAsset("point", intensity=30.0, radius=0.1),
    "rectangle": LightAsset("rectangle", intensity=100.0, width=0.2, height=0.2),
    "disk": LightAsset("disk", intensity=100.0, width=0.2, height=0.2),
}


def from_above(half: float = 2.0) -> Camera:
    return Camera(look_at((0.0, 50.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, -1.0)), znear=0.5, zfar=100.0, ymag=half)


def lit(stage, kind: str = "point", size: float = 8.0) -> None:
    """A white floor 4 m under a lamp."""
    stage.look(kind="none", background="color", background_color=(0, 0, 0), sun_illuminance=0.0)
    stage.add(plane(size), surface(base_color=(1.0, 1.0, 1.0, 1.0), metallic=0.0, specular=0.0))
    stage.lamp(LAMPS[kind], (0.0, 4.0, 0.0), DOWN)


def pane(stage, height: float = 2.0, color=RED, alpha: float = ALPHA, size: float = 1.0) -> None:
    """Its shadow is as wide as its size times 4 / (4 - height)."""
    material = surface("transparent", ("double_sided",), base_color=(*color, alpha), metallic=0.0, specular=0.0)
    stage.add(plane(size), material, (0.0, height, 0.0))


def tint(stage, camera: Camera | None = None, **settings: Any) -> np.ndarray:
    """Light of the floor with the option over that without, by channel: what is seen through the pane divides out."""
    camera = camera or Camera(look_at((0.0, 1.0, 6.0), (0.0, 0.0, 0.0)), 0.7)
    with_it, without = (
        stage.hdr(SIZE, camera, **{**ON, **settings, "translucent_shadows": on})[..., :3] for on in (True, False)
    )
    assert without[SHADOW_AT].min() > 0.01
    return np.where(without > 0.0, with_it / np.maximum(without, 1e-9), 1.0)


@pytest.mark.parametrize(
    ("kind", "filter"), [(kind, "pcf") for kind in LAMPS] + [("point", "none"), ("point", "vogel16"), ("spot", "evsm4")]
)
def test_a_pane_leaves_its_colour_as_much_as_its_alpha(stage, kind: str, filter: str) -> None:
    lit(stage, kind)
    pane(stage)
    found = tint(stage, shadow_filter=filter)
    assert found[SHADOW_AT] == pytest.approx(LEFT, rel=2e-3)
    assert found[30, 46] == pytest.approx(np.ones(3), rel=2e-3)


def test_panes_multiply_and_a_solid_caster_before_or_behind_is_alone(stage) -> None:
    other = (0.25, 0.5, 1.0)
    for heights in ((1.5, 2.0), (2.0, 1.5)):
        lit(stage)
        pane(stage, heights[0])
        pane(stage, heights[1], other)
        assert tint(stage)[SHADOW_AT] == pytest.approx(LEFT * (0.5 + 0.5 * np.array(other)), rel=4e-3)
    camera = Camera(look_at((0.0, 1.0, 6.0), (0.0, 0.0, 0.0)), 0.7)
    for height in (1.0, 2.5):
        lit(stage)
        stage.add(plane(1.0), surface(base_color=(0.5, 0.5, 0.5, 1.0), metallic=0.0), (0.0, 1.8, 0.0))
        pane(stage, height, size=0.7)
        assert (stage.hdr(SIZE, camera, **ON)[SHADOW_AT][:3] == 0.0).all()


def test_the_floor_before_a_pane_and_the_pane_itself_keep_their_light(stage) -> None:
    """A lamp between floor and pane; and a pane as the lamp sees it."""
    lit(stage)
    pane(stage, 5.0)
    assert tint(stage) == pytest.approx(np.ones((*SIZE[::-1], 3)), rel=1e-6)
    lit(stage)
    pane(stage, 2.0, size=0.9)
    above = Camera(look_at((0.0, 3.5, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, -1.0)), znear=0.01, zfar=2.5, ymag=0.4)
    first, second = (stage.hdr(SIZE, above, **{**ON, "translucent_shadows": on}) for on in (True, False))
    floor_seen = 1.0 - ALPHA  # all that may change is the floor, through the pane
    assert (np.abs(first - second) <= floor_seen * second + 1e-6).all()


def test_all_paths_make_one_picture_and_off_is_as_before(stage) -> None:
    lit(stage)
    pane(stage)
    camera = Camera(look_at((0.0, 1.0, 6.0), (0.0, 0.0, 0.0)), 0.7)
    first, *others = (stage.hdr(SIZE, camera, **ON, path=path) for path in PATHS)
    for other in others:
        assert (other == first).all()
    off = stage.hdr(SIZE, camera, **{**ON, "translucent_shadows": False})
    assert (off != first).any()
    frame = stage.runtime.render(stage.view(SIZE, camera, **{**ON, "translucent_shadows": False}))
    assert "local_tints" in {item.name for item in frame.graph.left_out}


def test_a_tint_follows_its_pane_and_is_kept_at_rest(stage) -> None:
    lit(stage)
    pane(stage)
    assert tint(stage)[SHADOW_AT] == pytest.approx(LEFT, rel=2e-3)
    residency, scene = stage.runtime.residency, stage.runtime.scene
    residency.set_material_param(int(scene.instances.material[1]), "base_color", (*RED, 1.0))
    assert tint(stage)[SHADOW_AT] == pytest.approx(np.array(RED), rel=4e-3)
    scene.nodes.set_translation(np.array([int(scene.instances.node[1])]), np.array([[50.0, 2.0, 0.0]]))
    stage.runtime.update()
    assert tint(stage)[SHADOW_AT] == pytest.approx(np.ones(3), rel=1e-3)


@pytest.mark.parametrize(("scale", "away"), [(1e-4, 0.0), (1e4, 0.0), (1.0, 1e6)], ids=str)
def test_size_and_place_of_the_world_do_not_matter(stage, scale: float, away: float) -> None:
    lit(stage)
    pane(stage)
    scene, center = stage.runtime.scene, np.array([away, 0.0, away])
    nodes = np.concatenate([scene.instances.node, scene.lights.node])
    scene.nodes.set_translation(nodes, scene.nodes.translation[nodes] * scale + center)
    scene.nodes.set_scale(scene.instances.node, np.full((2, 3), scale))
    scene.lights.set(0, intensity=30.0 * scale * scale)
    stage.runtime.update()
    pose = look_at(center + np.array((0.0, 1.0, 6.0)) * scale, center)
    assert tint(stage, Camera(pose, 0.7, znear=0.1 * scale))[SHADOW_AT] == pytest.approx(LEFT, rel=4e-3)
