"""Shadow maps are drawn again only when what they show changed: counted on the null device, seen on the real one."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from engine.assets.primitives import cube, plane
from engine.math.transform import look_at
from engine.render.camera import Camera

SUN = {"sun_illuminance": 2.0, "sun_azimuth": -math.pi / 2, "sun_elevation": math.pi / 4}


def camera(x: float = 0.0) -> Camera:
    return Camera(look_at((x, 2.0, 6.0), (x, 0.5, 0.0)), 0.9, znear=0.1)


def build(stage, surface) -> int:
    """A floor under thirty cubes along -Z; the node of the first."""
    stage.look(kind="none", **SUN)
    stage.add(plane(80.0), surface(metallic=0.0))
    nodes = [stage.add(cube(), surface(metallic=0.0), (0.3 * i - 2.0, 0.5, -1.0 * i)) for i in range(30)]
    return nodes[0]


@pytest.fixture
def drawn(null_stage, monkeypatch):
    """Render a frame; the shadow maps drawn in it."""
    device = null_stage.runtime.device
    passes: list[str] = []
    begin = device.render_pass

    def noted(label, *args, **kwargs):
        passes.append(label)
        return begin(label, *args, **kwargs)

    monkeypatch.setattr(device, "render_pass", noted)

    def render(at: Camera | None = None, **settings) -> list[int]:
        passes.clear()
        null_stage.runtime.update()
        null_stage.runtime.render(null_stage.view((64, 48), at or camera(), **{"shadow_split": 0.8, **settings}))
        return [int(name.rsplit(" ", 1)[1]) for name in passes if name.startswith("shadow cascade")]

    return render


def test_a_scene_at_rest_draws_its_maps_once(null_stage, surface, drawn) -> None:
    build(null_stage, surface)
    assert drawn() == [0, 1, 2]
    with_maps = null_stage.runtime.device.counters.draws
    for _ in range(3):
        assert drawn() == []
    assert null_stage.runtime.device.counters.draws < with_maps


def test_a_little_step_of_the_camera_draws_nothing(null_stage, surface, drawn) -> None:
    build(null_stage, surface)
    drawn()
    texel = null_stage.runtime.renderer.rows.shadows.cascades[0].texel
    maps = [len(drawn(camera(i * texel / 7))) for i in range(60)]
    assert sum(maps) <= 6
    assert sum(len(drawn(camera(i * 1.0))) for i in range(8)) > 4  # and a walk does


def test_what_moves_is_drawn_again_only_where_it_is(null_stage, surface, drawn) -> None:
    first = build(null_stage, surface)
    drawn()
    nodes = null_stage.runtime.scene.nodes
    nodes.set_translation([first], [(-2.0, 0.6, 0.0)])
    assert drawn() == [0, 1, 2]
    last = nodes.name.index("cube") + 29
    nodes.set_translation([last], [(6.7, 0.6, -29.0)])  # far behind: not in the first cascade
    assert drawn() == [1, 2]
    assert drawn() == []


@pytest.mark.parametrize("change", ["sun", "material", "hidden", "removed", "added", "size"])
def test_what_else_makes_a_map_old(null_stage, surface, drawn, change) -> None:
    first = build(null_stage, surface)
    runtime = null_stage.runtime
    drawn()
    settings = {}
    if change == "sun":
        runtime.scene.environment.sun_azimuth += 0.01
    elif change == "material":
        runtime.residency.set_material_param(1, "alpha_cutoff", 0.7)
    elif change == "hidden":
        runtime.scene.nodes.set_visible([first], False)
    elif change == "removed":
        runtime.scene.remove([first])
    elif change == "added":
        null_stage.add(cube(), surface(metallic=0.0), (0.0, 3.0, 0.0))
    else:
        settings = {"shadow_size": 512}
    assert drawn(**settings) == [0, 1, 2]
    assert drawn(**settings) == []


def test_two_views_of_different_size_keep_their_own_maps(null_stage, surface, drawn) -> None:
    build(null_stage, surface)
    runtime = null_stage.runtime
    drawn()
    runtime.render(null_stage.view((32, 32), camera(5.0)))
    assert drawn() == []


def test_casters_of_a_kind_are_one_call_a_map(null_stage, surface) -> None:
    """Thirty cubes of one mesh in ten materials: one indirect draw in each map."""
    null_stage.look(kind="none", **SUN)
    residency, nodes = null_stage.runtime.residency, null_stage.runtime.scene.nodes
    mesh = residency.add_meshes([cube()])[0]
    materials = [residency.add_material(surface(roughness=i / 10, metallic=0.0), Path()) for i in range(10)]
    rows = [nodes.add(f"c{i}", translation=(i * 1.5, 0.0, -2.0 * i)) for i in range(30)]
    null_stage.runtime.add_instances([(row, mesh, 0, materials[i % 10]) for i, row in enumerate(rows)])
    null_stage.runtime.update()
    view = null_stage.view((64, 48), camera())
    null_stage.runtime.render(view)
    maps = len(null_stage.runtime.renderer.rows.shadows.cascades)
    first = null_stage.runtime.device.counters.draws
    null_stage.runtime.render(view)
    assert maps >= 2
    assert first - null_stage.runtime.device.counters.draws == maps


@pytest.mark.gl
def test_a_kept_map_gives_the_picture_of_a_new_one(stage, surface) -> None:
    first = build(stage, surface)
    walked = [stage.hdr((64, 48), camera(0.05 * i)) for i in range(12)]
    stage.runtime.scene.nodes.set_translation([first], [(-1.5, 0.7, 0.0)])
    stage.runtime.update()
    moved = stage.hdr((64, 48), camera(0.55))
    first = build(stage, surface)
    for i in range(11, -1, -1):
        assert (stage.hdr((64, 48), camera(0.05 * i)) == walked[i]).all()
    stage.runtime.scene.nodes.set_translation([first], [(-1.5, 0.7, 0.0)])
    stage.runtime.update()
    assert (stage.hdr((64, 48), camera(0.55)) == moved).all()
    assert np.abs(moved - walked[11]).max() > 0.1
