"""Tiles of local lights are drawn again only when what they show changed: counted on the null device."""

from __future__ import annotations

import math

import pytest

from engine.assets.primitives import cube, plane
from engine.assets.scene import LightAsset
from engine.math.transform import look_at
from engine.render.camera import Camera

DOWN = (math.sin(-math.pi / 4), 0.0, 0.0, math.cos(-math.pi / 4))


def camera(x: float = 0.0, turn: float = 0.0) -> Camera:
    return Camera(look_at((x, 2.0, 6.0), (x + 3.0 * turn, 0.5, 0.0)), 0.9, znear=0.1)


@pytest.fixture
def drawn(null_stage, surface, monkeypatch):
    """A floor, a cube under a spot and one far to the right under a point light; the tiles drawn in a frame."""
    device, passes = null_stage.runtime.device, []
    begin = device.render_pass

    def noted(label, *args, **kwargs):
        passes.append(label)
        return begin(label, *args, **kwargs)

    monkeypatch.setattr(device, "render_pass", noted)
    null_stage.dark()
    null_stage.add(plane(80.0), surface(metallic=0.0))
    null_stage.cubes = [null_stage.add(cube(), surface(metallic=0.0), (x, 0.5, 0.0)) for x in (0.0, 5.0)]
    null_stage.lamp(LightAsset("spot", intensity=9.0, range=6.0, outer_angle=0.6, casts_shadow=True), (0, 3, 0), DOWN)
    null_stage.lamp(LightAsset("point", intensity=3.0, range=3.0, casts_shadow=True), (5.0, 2.5, 0.0))

    def render(at: Camera | None = None, **settings) -> int:
        passes.clear()
        null_stage.runtime.update()
        null_stage.runtime.render(null_stage.view((64, 48), at or camera(), **settings))
        return sum(name.startswith("local shadow ") for name in passes)

    return render


def test_at_rest_nothing_is_drawn_nor_where_the_camera_moves(drawn) -> None:
    assert drawn() == 7
    assert drawn() == 0
    assert [drawn(camera(0.01 * i, 0.3 * i)) for i in range(8)] == [0] * 8


def test_what_moves_is_drawn_where_it_is_seen(drawn, null_stage) -> None:
    drawn()
    nodes, lights = null_stage.runtime.scene.nodes, null_stage.runtime.scene.lights
    nodes.set_translation([null_stage.cubes[0]], [(0.1, 0.5, 0.0)])
    assert drawn() == 1
    nodes.set_translation([null_stage.cubes[1]], [(5.0, 0.6, 0.0)])
    assert 1 <= drawn() < 6
    nodes.set_translation([int(lights.node[0])], [(0.0, 3.1, 0.0)])
    assert drawn() == 1
    nodes.set_rotation([int(lights.node[1])], [DOWN])  # a point light shines all around
    assert drawn() == 0
    lights.set(0, intensity=8.0)
    assert drawn() == 0


@pytest.mark.parametrize("change", ["size", "hidden", "softness"])
def test_what_else_makes_tiles_old(drawn, null_stage, change) -> None:
    drawn()
    if change == "hidden":
        null_stage.runtime.scene.nodes.set_visible([null_stage.cubes[0]], [False])
    settings = {"size": {"local_shadow_size": 1024}, "softness": {"shadow_softness": 3.0}}.get(change, {})
    assert drawn(**settings) >= 1
    assert drawn(**settings) == 0
