"""Opening scenes, picking, and what happens to bad ones."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engine.app.framing import frame_bounds
from engine.app.runtime import Runtime
from engine.assets.lmesh import write_lmesh
from engine.assets.material import MaterialAsset, TextureRef
from engine.assets.material_toml import write_material
from engine.assets.primitives import card, cube
from engine.assets.scene import MeshRef, NodeAsset, SceneAsset
from engine.assets.scene_json import write_scene
from engine.core.errors import LucarnaError
from engine.render.view import View


def _write_two_cubes(folder: Path, **changes) -> Path:
    write_lmesh(folder / "a.lmesh", [cube(), card()], {})
    write_material(folder / "red.material.toml", MaterialAsset("red", params={"base_color": (1.0, 0.0, 0.0, 1.0)}))
    nodes = [
        NodeAsset("left", translation=(-1.0, 0.0, 0.0), mesh=MeshRef("a.lmesh", 0, "cube", ["red.material.toml"])),
        NodeAsset("right", translation=(1.0, 0.0, 0.0), mesh=MeshRef("a.lmesh", 0, "cube", [""])),
    ]
    for i, fields in changes.items():
        for name, value in fields.items():
            setattr(nodes[int(i[1:])].mesh, name, value)
    path = folder / "two.scene.json"
    write_scene(path, SceneAsset("two", nodes))
    return path


@pytest.fixture
def runtime(null_device):
    made = Runtime(null_device)
    yield made
    made.close()


def _view() -> View:
    camera = frame_bounds(np.array([-1.5, -0.5, -0.5]), np.array([1.5, 0.5, 0.5]), 2.0, azimuth=0.0, elevation=0.0)
    return View(camera, 200, 100)


def test_opens_and_draws(runtime, tmp_path) -> None:
    runtime.open(_write_two_cubes(tmp_path))
    assert len(runtime.findings) == 0
    assert runtime.render(_view()).stats.counters["instances"] == 2


def test_picks_what_is_under_the_pixel(runtime, tmp_path) -> None:
    runtime.open(_write_two_cubes(tmp_path))
    view = _view()
    assert runtime.scene.nodes.name[runtime.pick(view, 45, 50)] == "left"
    assert runtime.scene.nodes.name[runtime.pick(view, 155, 50)] == "right"
    assert runtime.pick(view, 100, 50) == -1
    runtime.scene.nodes.set_visible([0], False)
    runtime.update()
    assert runtime.pick(view, 45, 50) == -1


def test_a_missing_mesh_file_is_a_finding_and_the_rest_loads(runtime, tmp_path) -> None:
    runtime.open(_write_two_cubes(tmp_path, n0={"file": "gone.lmesh"}))
    assert [f.code for f in runtime.findings] == ["mesh.unreadable"]
    assert "gone.lmesh" in runtime.findings.items[0].message
    assert runtime.render(_view()).stats.counters["instances"] == 1


def test_a_missing_material_is_drawn_in_magenta(runtime, tmp_path) -> None:
    runtime.open(_write_two_cubes(tmp_path, n0={"materials": ["gone.material.toml"]}))
    assert [f.code for f in runtime.findings] == ["material.unreadable"]
    record = runtime.residency.material(int(runtime.scene.instances.material[0]))
    assert record.asset.params["base_color"] == (1.0, 0.0, 1.0, 1.0)


def test_a_missing_texture_is_a_finding(runtime, tmp_path) -> None:
    path = _write_two_cubes(tmp_path)
    textures = {"base_color_map": TextureRef("gone.dds")}
    write_material(tmp_path / "red.material.toml", MaterialAsset("red", textures=textures))
    runtime.open(path)
    assert [f.code for f in runtime.findings] == ["texture.unreadable"]


def test_a_mesh_index_out_of_range_is_a_finding(runtime, tmp_path) -> None:
    runtime.open(_write_two_cubes(tmp_path, n1={"index": 7}))
    assert [f.code for f in runtime.findings] == ["mesh.index"]


def test_a_bad_scene_leaves_the_open_one(runtime, tmp_path) -> None:
    runtime.open(_write_two_cubes(tmp_path))
    bad = tmp_path / "bad.scene.json"
    bad.write_text('{"schema": "lucarna.scene/1", "nodes": [{"name": "x", "parent": 5}]}')
    with pytest.raises(LucarnaError) as error:
        runtime.open(bad)
    assert "bad.scene.json" in str(error.value)
    assert runtime.scene.nodes.name[:2] == ["left", "right"]
